"""Odd tables drawn by a seed: clock, layout, units, heads, losses, signs and sensors crossed at random."""

from dataclasses import dataclass, field

import numpy as np

from tests.app.readers.odd_draws.clocks import KINDS
from tests.app.readers.odd_draws.layouts import LAYOUTS, Table
from tests.app.readers.odd_draws.motion import Sensor, Signals, measured
from tests.app.readers.odd_draws.names import DEVICES, QUANTITIES, style
from tests.app.readers.odd_draws.texts import as_bytes

Random = np.random.Generator
RATES = (20.0, 25.0, 50.0, 60.0, 62.5, 64.0, 100.0, 100.0, 104.0, 120.0, 128.0, 148.148, 200.0, 256.0, 400.0)
LOSSES = ("none", "none", "single", "holes", "both", "empty cells")
_EACH_LOSES = (
    "rows of devices",
    "rows of devices and kinds",
    "own clocks",
    "one value a row, several sensors",
)
_ONE_CLOCK = ("own clocks", "own clocks of quantities")


@dataclass
class Draw:
    """One odd table and the truth of it.

    Attributes
    ----------
    seed : int
    kinds : dict of str to str
        What was drawn of each kind.
    content : bytes
    sensors : list of Sensor
    rate_hz : float
    said_hz : float or None
        What a person says of the rate.
    turned : str
        Empty, `sign` or `names`: how a person says that the accelerometer has the other sign.
    """

    seed: int
    kinds: dict[str, str]
    content: bytes
    sensors: list[Sensor]
    rate_hz: float
    said_hz: float | None
    turned: str
    table: Table = field(repr=False, default_factory=Table)


def draw(seed: int) -> Draw:
    """Return the table of a seed."""
    rng = np.random.default_rng(seed)
    layout = list(LAYOUTS)[rng.integers(len(LAYOUTS))]
    clock = _clock(rng, layout)
    losses = "none" if clock == "whole seconds" else LOSSES[rng.integers(len(LOSSES))]
    if clock == "counter of 8 bits" and losses == "empty cells":
        losses = "single"
    several = layout not in (
        "one sensor",
        "rows of kinds",
        "own clocks of quantities",
        "one value a row",
    )
    count = int(rng.integers(2, 5)) if several else 1
    # Of a clock of whole seconds some ticks must be whole.
    rates = [rate for rate in RATES if rate <= 104.0 or clock != "whole seconds"]
    rate_hz = rates[rng.integers(len(rates))]
    quantities = QUANTITIES[: 2 + int(rng.random() < 0.5)]
    names = DEVICES[rng.integers(len(DEVICES))]
    sensors = [_sensor(rng, name, quantities, rate_hz, layout, clock) for name in names[:count]]
    _lose(rng, sensors, losses, layout)
    turned = ("sign", "names")[rng.integers(2)] if rng.random() < 0.2 else ""
    written = LAYOUTS[layout](rng, sensors, rate_hz, clock, style(rng), -1.0 if turned else 1.0)
    head_rate = written.needs_rate and rng.random() < 0.5
    content, texts = as_bytes(rng, written, rate_hz if head_rate else None)
    kinds = {"layout": layout, "clock": clock, "losses": losses, "turned": turned, **texts}
    said_hz = rate_hz if written.needs_rate and not head_rate else None
    return Draw(seed, kinds, content, sensors, rate_hz, said_hz, turned, written)


def _clock(rng: Random, layout: str) -> str:
    fitting = list(KINDS)
    if layout in _ONE_CLOCK:
        fitting = ["seconds", "milliseconds", "microseconds"]
    return fitting[rng.integers(len(fitting))]


def _sensor(
    rng: Random, name: str, quantities: tuple[str, ...], rate_hz: float, layout: str, clock: str
) -> Sensor:
    """Return a sensor with all its samples; of its own clock it begins on its own."""
    count = int(rng.integers(220, 380))
    if layout not in _ONE_CLOCK:
        count = 300
    begins_s = float(rng.uniform(0.0, 0.3)) * count / rate_hz if layout == "own clocks" else 0.0
    is_apart = (
        layout in ("own clocks of quantities", "rows of kinds", "one value a row")
        and "counter" not in clock
        # Packets hold as many samples of each.
        and clock not in ("bursts", "two clocks")
        and rng.random() < 0.5
    )
    times = {}
    for quantity in quantities:
        slower = {"accelerometer": 0.96, "magnetometer": 0.5}.get(quantity, 1.0) if is_apart else 1.0
        number = np.arange(round(count * slower), dtype=np.float64)
        jitter = (
            rng.uniform(-0.08, 0.08, number.size)
            if clock in ("seconds", "microseconds") and is_apart
            else 0.0
        )
        times[quantity] = begins_s + (number + jitter) / (rate_hz * slower)
    values = measured(rng, times)
    signals = {q: Signals(times[q], values[q], np.ones(times[q].size, dtype=bool)) for q in quantities}
    return Sensor(name, signals)


def _lose(rng: Random, sensors: list[Sensor], losses: str, layout: str) -> None:
    """Mark what the table does not hold; sensors in one row lose it together."""
    together: np.ndarray | None = None
    for sensor in sensors:
        there = next(iter(sensor.signals.values())).there
        if together is None or layout in _EACH_LOSES:
            together = _there(rng, there.size, losses)
        for signals in sensor.signals.values():
            signals.there = (
                together if signals.there.size == together.size else _there(rng, signals.there.size, losses)
            )


def _there(rng: Random, count: int, losses: str) -> np.ndarray:
    there = np.ones(count, dtype=bool)
    if losses in ("single", "both", "empty cells"):
        there[rng.choice(np.arange(5, count - 5), max(2, count // 40), replace=False)] = False
    if losses in ("holes", "both"):
        for _ in range(2):
            at = int(rng.integers(30, count - 70))
            there[at : at + int(rng.integers(20, 60))] = False
    return there
