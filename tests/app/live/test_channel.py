"""Who listens to a topic harms nobody else."""

from typing import Any

from app.live.bus import BusMetrics, Channel


class Heard:
    """Takes messages, or raises."""

    topics = ("session/one/blocks",)

    def __init__(self, *, fails: bool = False) -> None:
        self.messages: list[Any] = []
        self._fails = fails

    def put(self, _: str, message: Any) -> bool:
        if self._fails:
            raise OSError("gone")
        self.messages.append(message)
        return True


def test_a_listener_that_fails_is_counted_and_the_others_hear() -> None:
    metrics = BusMetrics()
    channel, sound = Channel("session/one/blocks", metrics), Heard()
    channel.listeners.extend([Heard(fails=True), sound])
    channel.publish("first")
    channel.publish("second")
    assert sound.messages == ["first", "second"]
    assert (metrics.published, metrics.delivered, metrics.dropped) == (2, 4, 2)
