"""Measures of a walk that are followed over sessions, by a name each, stored with its result."""

from app.kinds.walk.schemas import WalkContent

Followed = tuple[str, str, float, float | None, int]
"""Name, unit, mean over the strides that count, standard deviation over them, number of them."""


def followed_of(content: WalkContent) -> list[Followed]:
    """Return the measures of a walk that have a value.

    Returns
    -------
    list of tuple
        Named `stride_length:left` of a foot and `uneven:stride_length` of an asymmetry; the result of a walking test,
        without spread, is the first.
    """
    found: dict[str, tuple[str, float | None, float | None, int]] = {}
    test = content.test
    if test is not None and test.kind == "timed_up_and_go":
        found["test_time"] = ("s", test.time_s, None, 1)
    if test is not None and test.kind == "six_minute_walk":
        found["test_distance"] = ("metres", test.distance_m, None, 1)
    parts = [(one, f"{one.measure}:{foot.side}") for foot in content.feet for one in foot.measures]
    parts += [(one, f"uneven:{one.measure}") for one in content.asymmetry]
    parts += [(one, one.measure) for one in content.both]
    if content.balance is not None:
        parts += [(one, one.measure) for one in content.balance.measures]
    found |= {name: (one.unit, one.value, one.spread, one.count) for one, name in parts}
    return [
        (name, unit, value, spread, count)
        for name, (unit, value, spread, count) in found.items()
        if value is not None
    ]
