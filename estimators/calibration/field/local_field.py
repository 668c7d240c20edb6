"""The local magnetic field: norm and dip, from corrected readings and the vertical, distinguished from others."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import CalibrationError, ShapeError
from estimators.recording import Float
from estimators.sentences import Sentence, say

_QUIET: Final = 0.04
"""How far specific force may be from gravity, relative, for its direction to be up."""
EARTH_NORM_T: Final = (25e-6, 65e-6)
"""Norm of the earth's field, from South America to the poles."""
_NORM_RANGE_T: Final = (20e-6, 75e-6)
"""Farther off it is not the earth's alone, whatever the scale error of an uncalibrated device."""
_LEAST_DIP_RAD: Final = math.radians(17.0)
"""Nearer to the magnetic equator the sign of the dip says nothing about the hemisphere."""
_LEAST_LEVEL_T: Final = 8e-6
"""Of the part along the floor: with less a compass hardly tells a direction."""
_APART: Final = 0.15
_DIP_APART_RAD: Final = math.radians(10.0)


@dataclass(frozen=True)
class LocalField:
    """The earth's field at the place, as far as it was reported.

    Attributes
    ----------
    norm : float
        In the unit of the readings (tesla in the product).
    dip_rad : float
        Below the horizontal; NaN without an accelerometer.
    norm_spread, dip_spread_rad : float
        Standard deviation over the samples: how uniform the field is.
    """

    norm: float
    dip_rad: float
    norm_spread: float
    dip_spread_rad: float

    def to_dict(self) -> dict[str, float | None]:
        """Return plain JSON types, None for NaN; `from_dict` reverses it exactly."""
        return {name: value if math.isfinite(value) else None for name, value in asdict(self).items()}

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> "LocalField":
        """Rebuild from `to_dict` after a trip through JSON."""
        return cls(
            **{n: float("nan") if stored[n] is None else float(stored[n]) for n in cls.__annotations__}
        )

    def doubts(self, hemisphere: str = "unknown") -> tuple[Sentence, ...]:
        """Return why this cannot be the earth's field alone, in plain words with what to do; empty when it can.

        Parameters
        ----------
        hemisphere : {"north", "south", "unknown"}
            Of the place: the field points down in the north and up in the south.
        """
        found = []
        low, high = EARTH_NORM_T
        if not _NORM_RANGE_T[0] <= self.norm <= _NORM_RANGE_T[1]:
            found.append(say("compass.norm_implausible", norm_t=self.norm, low_t=low, high_t=high))
        if not math.isfinite(self.dip_rad):
            return tuple(found)
        down = self.dip_rad if hemisphere == "north" else -self.dip_rad if hemisphere == "south" else 0.0
        if down < -_LEAST_DIP_RAD:
            found.append(
                say("compass.points_up", angle_rad=-self.dip_rad)
                if hemisphere == "north"
                else say("compass.points_down", angle_rad=self.dip_rad)
            )
        level = self.norm * math.cos(self.dip_rad)
        if level < _LEAST_LEVEL_T:
            found.append(say("compass.hardly_level", level_t=level))
        return tuple(found)


def odd_fields(fields: Mapping[str, LocalField]) -> dict[str, Sentence]:
    """Return which of at least three sensors turned at one place saw another field than most, with the words for it.

    Parameters
    ----------
    fields : mapping of str to LocalField
        By sensor.
    """
    if len(fields) < 3:
        return {}
    norm = float(np.median([one.norm for one in fields.values()]))
    dips = [one.dip_rad for one in fields.values() if math.isfinite(one.dip_rad)]
    dip = float(np.median(dips)) if len(dips) >= 3 else float("nan")
    found = {}
    for name, one in fields.items():
        if abs(one.norm - norm) > _APART * norm or abs(one.dip_rad - dip) > _DIP_APART_RAD:
            found[name] = (
                say(
                    "compass.odd_dip",
                    norm_t=one.norm,
                    dip_rad=one.dip_rad,
                    others_t=norm,
                    others_dip_rad=dip,
                )
                if math.isfinite(one.dip_rad) and math.isfinite(dip)
                else say("compass.odd_field", norm_t=one.norm, others_t=norm)
            )
    return found


def local_field(field: Float, accelerometer_mps2: Float | None = None) -> LocalField:
    """Return norm and dip of the field, from corrected samples, shape (N, 3), and the accelerometer's.

    Only quiet samples, whose specific force is gravity to 4 percent, count for the dip.
    """
    if field.ndim != 2 or field.shape[1] != 3:
        raise ShapeError(f"field has shape {field.shape}; it must be (N, 3)")
    finite = np.isfinite(field).all(axis=1)
    ups = np.full(field.shape, np.nan) if accelerometer_mps2 is None else quiet_up(accelerometer_mps2)
    if not finite.any():
        raise CalibrationError(say("compass.no_data"))
    return field_of(field[finite], ups[finite])


def field_of(true: Float, ups: Float) -> LocalField:
    """Return norm and dip of corrected readings and up directions (NaN where unknown), each (N, 3)."""
    norms = np.linalg.norm(true, axis=1)
    known = np.isfinite(ups).all(axis=1) & (norms > 0.0)
    dip = spread = float("nan")
    if known.any():
        sines = -np.sum(true[known] * ups[known], axis=1) / norms[known]
        dips = np.arcsin(np.clip(sines, -1.0, 1.0))
        dip, spread = float(np.mean(dips)), float(np.std(dips))
    return LocalField(float(np.mean(norms)), dip, float(np.std(norms)), spread)


def quiet_up(accelerometer_mps2: Float) -> Float:
    """Return the up direction in sensor axes, shape (N, 3); NaN where specific force is not gravity."""
    size = np.linalg.norm(accelerometer_mps2, axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        quiet = np.abs(size / GRAVITY_MPS2 - 1.0) < _QUIET
    return np.where(quiet, accelerometer_mps2 / np.maximum(size, 1e-9), np.nan)
