"""How drawn tables say the time: columns of stamps, counters and text, right and as drivers write them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

import numpy as np

Random = np.random.Generator


@dataclass
class Written:
    """The time columns of some rows.

    Attributes
    ----------
    columns : dict of str to list of str
        By name.
    needs_rate : bool
        Whether a person or the head must say the rate.
    """

    columns: dict[str, list[str]] = field(default_factory=dict)
    needs_rate: bool = False


def written(kind: str, rng: Random, time_s: np.ndarray, rate_hz: float, number: np.ndarray) -> Written:
    """Return the time columns of rows.

    Parameters
    ----------
    kind : str
        A key of `KINDS`.
    rng : Generator
    time_s : ndarray, shape (N,)
        When the rows were measured, from about zero.
    rate_hz : float
    number : ndarray of int, shape (N,)
        Of the sample: rows that are missing are missing in it.
    """
    return KINDS[kind](rng, time_s, rate_hz, number)


def _pick(rng: Random, *names: str) -> str:
    return names[int(rng.integers(len(names)))]


def _decimals(values: np.ndarray, digits: int) -> list[str]:
    return [f"{value:.{digits}f}" for value in values]


def _whole(values: np.ndarray) -> list[str]:
    return [str(int(value)) for value in np.rint(values)]


def _epoch(rng: Random) -> float:
    return float(rng.integers(1_690_000_000, 1_790_000_000))


def _seconds(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    start = (0.0, float(rng.uniform(1, 9000)), _epoch(rng))[rng.integers(3)]
    name = _pick(rng, "time", "t", "Time (s)", "time_s", "Zeit [s]", "timestamp", "seconds_elapsed", "Time")
    return Written({name: _decimals(time_s + start, int(rng.integers(4, 7)))})


def _milliseconds(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    start = (0.0, float(rng.integers(10, 10**7)), 1000.0 * _epoch(rng))[rng.integers(3)]
    name = _pick(rng, "time_ms", "Timestamp [ms]", "timestamp", "millis", "Time (ms)", "TimestampMs")
    stamps = 1000.0 * time_s + start
    return Written({name: _whole(stamps) if rng.random() < 0.5 else _decimals(stamps, 2)})


def _microseconds(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    start = (0.0, float(rng.integers(10, 10**9)), 1e6 * _epoch(rng))[rng.integers(3)]
    name = _pick(rng, "time_us", "Timestamp (µs)", "timestamp", "micros", "Time [us]")
    return Written({name: _whole(1e6 * time_s + start)})


def _nanoseconds(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    start = int(_epoch(rng)) * 10**9
    return Written({_pick(rng, "timestamp", "time", "time_ns"): [str(start + int(1e9 * t)) for t in time_s]})


def _counter(bits: int) -> Callable[..., Written]:
    def of(rng: Random, time_s: np.ndarray, rate_hz: float, number: np.ndarray) -> Written:
        size = 2**bits
        # Begins near its end, so that it wraps.
        count = (number + size - int(rng.integers(1, 200))) % size
        names = ("Counter", "PacketCounter", "Packet number", "sample counter", "Sample", "frame", "seq")
        return Written({_pick(rng, *names): _whole(count)}, needs_rate=True)

    return of


def _fine(rng: Random, time_s: np.ndarray, rate_hz: float, number: np.ndarray) -> Written:
    stamps = _whole((1e6 * time_s + rng.integers(0, 2**32)) % 2**32)
    if rng.random() < 0.5:
        return Written({"SampleTimeFine": stamps})
    return Written(
        {"PacketCounter": _whole((number + int(rng.integers(0, 65_536))) % 65_536), "SampleTimeFine": stamps}
    )


def _moments(rng: Random, time_s: np.ndarray) -> list[datetime]:
    start = datetime(
        2026, int(rng.integers(1, 13)), int(rng.integers(1, 28)), int(rng.integers(3, 23)), tzinfo=UTC
    )
    start += timedelta(minutes=int(rng.integers(0, 60)), seconds=int(rng.integers(0, 60)))
    return [start + timedelta(microseconds=round(1e6 * t)) for t in time_s]


def _iso(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    pattern = _pick(
        rng,
        "%Y-%m-%dT%H:%M:%S.<ms>Z",
        "%Y-%m-%dT%H:%M:%S.%f",
        "%Y-%m-%d %H:%M:%S.<ms>",
        "%Y-%m-%dT%H:%M:%S.%f+02:00",
        "%d.%m.%Y %H:%M:%S.<ms>",
        "%m/%d/%Y %H:%M:%S.<ms>",
        "%m/%d/%y %I:%M:%S.<ms> %p",
        "%H:%M:%S.<ms>",
        "%H:%M:%S:<ms>",
    )
    texts = [
        m.strftime(pattern).replace("<ms>", f"{m.microsecond // 1000:03d}") for m in _moments(rng, time_s)
    ]
    return Written({_pick(rng, "time", "Timestamp", "DateTime", "Clock", "recorded at"): texts})


def _minutes(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    at = time_s + float(rng.integers(0, 3600))
    texts = [f"{int(t // 60) % 60:02d}:{t % 60:06.3f}" for t in np.floor(1000.0 * at + 1e-6) / 1000.0]
    return Written({_pick(rng, "time", "Zeit", "Time (mm:ss)"): texts})


def _repeated(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    stamps = time_s.copy()
    late = rng.choice(np.arange(3, len(stamps) - 3, 3), max(1, len(stamps) // 70), replace=False)
    stamps[late] = stamps[late - 1]
    if rng.random() < 0.5:
        return Written({_pick(rng, "time", "time_s"): _decimals(stamps, 5)})
    return Written({_pick(rng, "timestamp", "time_ms"): _whole(1000.0 * (stamps + _epoch(rng)))})


def _bursts(rng: Random, time_s: np.ndarray, rate_hz: float, number: np.ndarray) -> Written:
    size = int(rng.integers(2, 9))
    packet = number // size
    # A packet is stamped when its last sample was measured, or its first.
    edge = packet * size + (size - 1 if rng.random() < 0.5 else 0)
    stamps = time_s + (edge - number) / rate_hz + (number % size) * (0.0, 2e-5)[rng.integers(2)]
    return Written({_pick(rng, "time", "timestamp (s)", "arrival time [s]"): _decimals(stamps, 5)})


def _coarse(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    moments = _moments(rng, time_s + float(rng.uniform()))
    return Written({_pick(rng, "time", "Timestamp"): [m.strftime("%Y-%m-%d %H:%M:%S") for m in moments]})


def _two(rng: Random, time_s: np.ndarray, rate_hz: float, number: np.ndarray) -> Written:
    plain = {"time (s)": _decimals(time_s, 5)}
    epoch = {"timestamp_ms": _whole(1000.0 * (time_s + _epoch(rng)))}
    text = {"datetime": _iso(rng, time_s).columns.popitem()[1]}
    burst = {"host time (s)": _bursts(rng, time_s, rate_hz, number).columns.popitem()[1]}
    count = {"PacketCounter": _whole((number + int(rng.integers(0, 65_536))) % 65_536)}
    pairs = [
        plain | epoch,
        epoch | plain,
        text | plain,
        {"device time (s)": plain["time (s)"]} | burst,
        burst | {"device time (s)": plain["time (s)"]},
        count | plain,
        epoch | count,
    ]
    return Written(pairs[rng.integers(len(pairs))])


def _wrapping(rng: Random, time_s: np.ndarray, *_: object) -> Written:
    size, factor, name = (
        (2.0**16, 1e3, _pick(rng, "time_ms", "millis")),
        (2.0**32, 1e3, _pick(rng, "time_ms", "timestamp")),
        (2.0**32, 1e6, _pick(rng, "time_us", "micros")),
    )[rng.integers(3)]
    before = float(rng.uniform(0.2, 0.8)) * (time_s[-1] - time_s[0])
    return Written({name: _whole(np.floor((factor * (time_s - time_s[0] - before)) % size))})


KINDS: dict[str, Callable[..., Written]] = {
    "seconds": _seconds,
    "milliseconds": _milliseconds,
    "microseconds": _microseconds,
    "nanoseconds": _nanoseconds,
    "counter of 8 bits": _counter(8),
    "counter of 16 bits": _counter(16),
    "counter of 32 bits": _counter(32),
    "SampleTimeFine": _fine,
    "text": _iso,
    "minutes and seconds": _minutes,
    "repeated": _repeated,
    "bursts": _bursts,
    "whole seconds": _coarse,
    "two clocks": _two,
    "stamps that wrap": _wrapping,
}
