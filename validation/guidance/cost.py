"""Processor time of a tick of a guided session, on the way that frames take while it streams."""

import time
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from estimators.guidance import Guide
from estimators.guidance.live import ChannelSelector, GuidanceRunner
from estimators.pipelines import Frames
from validation.guidance.sessions import STEP_S, streamed
from validation.protocol import Data, Figure, Protocol, Values

_PACKET: Final = 5
"""Ticks of a packet."""
_ROUNDS: Final = 9
_REFERENCE_ROUNDS: Final = 2000


def _spent_s(work: Callable[[], object]) -> float:
    """Return the processor time of this process that a piece of work takes: others on the machine do not count."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def _exponentials() -> None:
    """Do what stands for the machine: `_REFERENCE_ROUNDS` times the exponentials of 64 phases by 10 sizes, by numpy."""
    table = np.linspace(-8.0, 0.0, 640).reshape(10, 64)
    for _ in range(_REFERENCE_ROUNDS):
        np.exp(table)


def _measure(seeds: Sequence[int], data: Data) -> Values:
    packets_us, together_us, times_reference = [], [], []
    for seed in seeds:
        ready, frames = streamed("no rest", seed)
        packets: list[Frames] = [
            frames.ticks(start, start + _PACKET)
            for start in range(0, frames.tick_count - _PACKET + 1, _PACKET)
        ]
        values, sigma = ChannelSelector(ready).pick(frames)

        def follow() -> None:
            following = GuidanceRunner(ready, STEP_S)  # noqa: B023 - called within the round
            for packet in packets:  # noqa: B023
                following.feed(packet)

        def at_once() -> None:
            Guide(ready, STEP_S).feed(values, sigma)  # noqa: B023

        # The first round compiles or loads, and is not counted.
        rounds = np.array(
            [[_spent_s(work) for work in (follow, at_once, _exponentials)] for _ in range(_ROUNDS + 1)]
        )[1:]
        of_packet = rounds[:, 0] / (_PACKET * len(packets))
        packets_us.append(1e6 * np.median(of_packet))
        together_us.append(1e6 * np.median(rounds[:, 1]) / frames.tick_count)
        times_reference.append(np.median(of_packet / (rounds[:, 2] / _REFERENCE_ROUNDS)))
    return {
        _LIVE: np.array(packets_us),
        _TOGETHER: np.array(together_us),
        _TIMES: np.array(times_reference),
    }


_LIVE: Final = "a tick, from frames in packets of five to cues and stops"
_TOGETHER: Final = "a tick of the guide alone, all ticks at once"
_TIMES: Final = "the first of these over 640 exponentials of numpy"

COST = Protocol(
    name="guidance_cost",
    title="Processor time of guidance",
    source="House page on live guidance, sections 2 and 9",
    what="A set without rest through sensors and filters; its frames go packet by packet through what a live session "
    "calls, at 100 Hz, with 64 phases, 10 sizes, all channels of the template and the rules of the house. Processor "
    "time, the median of nine rounds; the page measured 6.2 of a guide alone, with 7 sizes. The ratio to exponentials "
    "of as many numbers as there are phases and sizes, in the same rounds, says the same of any machine.",
    figures=(
        Figure(_LIVE, "us", 20.0, judged_by="median"),
        Figure(_TOGETHER, "us", judged_by="median"),
        Figure(_TIMES, "1", judged_by="median"),
    ),
    measure=_measure,
)
