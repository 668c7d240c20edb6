"""Conditions of a random world: its motion, sensor, field and recording, drawn from a seed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np

MOTIONS: Final = {
    "hand": 3,
    "reaching": 3,
    "foot": 2,
    "shank": 2,
    "pelvis": 2,
    "trunk": 2,
    "turning": 2,
    "pendulum": 2,
    "impacts": 1,
    "none": 1,
}
"""How many of twenty worlds have each motion. Foot, shank and pelvis walk; "none" is a sensor on a table."""
GRADES: Final = ("laboratory", "usual", "consumer")
FIELDS: Final = {
    "clean": 4,
    "room": 3,
    "iron at the start": 4,
    "iron worn": 2,
    "iron put on": 1,
    "iron taken off": 1,
    "magnets passing": 2,
    "lift or bed": 2,
    "turned all along": 1,
}
"""How many of twenty worlds have each field: of the earth alone, of a room with furniture, of iron at the place of the
start, of iron on the wearer all along or for a part, of magnets, of another place for a while, or turned as a whole."""
_BESIDE_IRON: Final = frozenset({"room", "iron at the start", "iron worn"})
_RATES_HZ: Final = (25.0, 50.0, 60.0, 100.0, 100.0, 100.0, 128.0, 200.0, 286.0, 400.0)
_AXES: Final = (9, 9, 9, 9, 9, 6)
_CLIPS: Final = ("none",) * 7 + ("gyroscope", "gyroscope", "accelerometer")
_LOSSES: Final = ("none", "none", "none", "short", "short", "long")
_FREEZES: Final = ("none",) * 12 + ("gyroscope", "accelerometer", "magnetometer", "whole")
_TISSUES: Final = (False, False, True)
_SHORT_REST_S: Final = 2.0

Card = TypeVar("Card")


@dataclass(frozen=True)
class Conditions:
    """What one world is like.

    Attributes
    ----------
    grade : str
        Of `GRADES`, or "ideal" for a device without any error, which no seed draws.
    field : str
        Of `FIELDS`; of nine axes only.
    axes : int
        9, or 6 without magnetometer.
    rest_s : float
        Rest at the start; zero when the movement goes on at the first sample.
    dip_rad : float
        Below the horizon positive: on the northern hemisphere.
    strength_t : float
        Of the earth's field.
    clip : str
        Which triad is cut off at the end of its range: "gyroscope", "accelerometer" or "none".
    is_range_declared : bool
        The recording knows the range, and its samples at the edge are marked SATURATED.
    is_averaging : bool
        Accelerometer samples are means over the sampling interval, not single values at its end.
    delay_s : float
        Of the magnetometer behind the gyroscope.
    jitter : float
        Standard deviation of the stamps, as a share of the sampling interval.
    loss : str
        "none", "short" (bursts that are bridged) or "long" (also bursts beyond that).
    freeze : str
        What repeats one value for some seconds: a triad, "turned all along" or "none".
    has_soft_tissue : bool
        The sensor wobbles on the bone.
    is_warming : bool
        Offsets move from switching on to their end value.
    """

    motion: str
    grade: str
    field: str
    axes: int
    rate_hz: float
    duration_s: float
    rest_s: float
    dip_rad: float
    strength_t: float
    clip: str = "none"
    is_range_declared: bool = False
    is_averaging: bool = True
    delay_s: float = 0.0
    jitter: float = 0.0
    loss: str = "none"
    freeze: str = "none"
    has_soft_tissue: bool = False
    is_warming: bool = False

    def rows(self) -> tuple[str, ...]:
        """Return the rows of the table that this world counts in."""
        found = [f"sensor: {self.grade}", f"motion: {self.motion}", f"rest: {_rest_band(self.rest_s)}"]
        if self.axes == 9:
            found += [f"field: {self.field}", f"dip: {_dip_band(abs(self.dip_rad))}"]
        found += [f"clip: {self.clip}", f"rate: {_rate_band(self.rate_hz)}", f"axes: {self.axes}"]
        found += [f"loss: {self.loss}"] * (self.loss != "none")
        found += [f"frozen: {self.freeze}"] * (self.freeze != "none")
        found += ["soft tissue"] * self.has_soft_tissue + ["warming"] * self.is_warming
        return tuple(found)


REST_BANDS: Final = ("none", "below 2 s", "2 s and more")
DIP_BANDS: Final = ("below 40 deg", "40 to 65 deg", "65 deg and more")
RATE_BANDS: Final = ("25 to 60 Hz", "100 to 128 Hz", "200 to 400 Hz")
WHOLE: Final = "field: turned all along"
"""Row of the worlds whose field is turned all along: no sensor can know it, and they count in no other row."""
ROWS: Final = (
    *(f"sensor: {grade}" for grade in GRADES),
    *(f"field: {kind}" for kind in FIELDS),
    *(f"motion: {kind}" for kind in MOTIONS),
    *(f"rest: {band}" for band in REST_BANDS),
    *(f"clip: {kind}" for kind in dict.fromkeys(_CLIPS)),
    *(f"dip: {band}" for band in DIP_BANDS),
    *(f"rate: {band}" for band in RATE_BANDS),
    *(f"axes: {count}" for count in dict.fromkeys(_AXES)),
    *(f"loss: {kind}" for kind in dict.fromkeys(_LOSSES) if kind != "none"),
    *(f"frozen: {kind}" for kind in dict.fromkeys(_FREEZES) if kind != "none"),
    *("soft tissue", "warming"),
)


def _rest_band(rest_s: float) -> str:
    return REST_BANDS[0 if rest_s == 0.0 else 1 if rest_s < _SHORT_REST_S else 2]


def _dip_band(dip_rad: float) -> str:
    return DIP_BANDS[int(np.searchsorted(np.radians([40.0, 65.0]), dip_rad, side="right"))]


def _rate_band(rate_hz: float) -> str:
    return RATE_BANDS[int(np.searchsorted([80.0, 160.0], rate_hz))]


def stream(seed: int, part: str) -> np.random.Generator:
    """Return the random numbers of one part of a world: no part shifts those of another."""
    return np.random.default_rng([seed, *part.encode()])


def conditions_of(seed: int) -> Conditions:
    """Draw the conditions of a world.

    Kinds are dealt like cards: every pack of seeds, as long as the pack and beginning at a multiple of that, has each
    kind as often as the pack holds it.
    """
    generator = stream(seed, "conditions")
    rest_s = float(_dealt(seed, "rest", (0.0, generator.uniform(0.1, 2.0), generator.uniform(2.0, 10.0))))
    drawn = Conditions(
        motion=_dealt(seed, "motion", _pack(MOTIONS)),
        grade=_dealt(seed, "grade", GRADES),
        field=_dealt(seed, "field", _pack(FIELDS)),
        axes=_dealt(seed, "axes", _AXES),
        rate_hz=_dealt(seed, "rate", _RATES_HZ),
        duration_s=float(generator.uniform(60.0, 120.0)),
        rest_s=rest_s,
        dip_rad=float(np.radians(generator.uniform(0.0, 85.0)) * generator.choice([-1.0, 1.0])),
        strength_t=float(generator.uniform(25e-6, 65e-6)),
        clip=_dealt(seed, "clip", _CLIPS),
        is_range_declared=bool(generator.random() < 0.5),
        is_averaging=bool(generator.random() < 0.6),
        delay_s=float(generator.uniform(0.0, 0.03) * (generator.random() < 0.5)),
        jitter=float(generator.uniform(0.02, 0.15) * (generator.random() < 0.3)),
        loss=_dealt(seed, "loss", _LOSSES),
        freeze=_dealt(seed, "freeze", _FREEZES),
        has_soft_tissue=_dealt(seed, "tissue", _TISSUES),
        is_warming=bool(generator.random() < 0.5),
    )
    return _possible(drawn)


def _pack(counts: Mapping[str, int]) -> tuple[str, ...]:
    return tuple(kind for kind, count in counts.items() for _ in range(count))


def _dealt(seed: int, part: str, pack: Sequence[Card]) -> Card:
    """Take the card of this seed from a pack that is shuffled anew for every stretch of seeds of its length."""
    stretch, place = divmod(seed, len(pack))
    order: list[int] = stream(stretch, part).permutation(len(pack)).tolist()
    return pack[order[place]]


def _possible(drawn: Conditions) -> Conditions:
    """Leave out what a world without magnetometer, without movement or at one place cannot have or show."""
    if drawn.axes == 6:
        drawn = replace(
            drawn, field="clean", freeze="none" if drawn.freeze == "magnetometer" else drawn.freeze
        )
    if drawn.motion == "none":
        # Beside iron from the first sample to the last, a sensor at rest sees a field turned as a whole.
        still = "turned all along" if drawn.field in _BESIDE_IRON else drawn.field
        drawn = replace(drawn, field=still, rest_s=drawn.duration_s, clip="none", has_soft_tissue=False)
    if drawn.motion == "turning" and drawn.field == "room":
        drawn = replace(drawn, field="clean")
    return drawn
