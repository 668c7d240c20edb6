"""The local magnetic field: norm and dip, from corrected readings and the vertical."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import CalibrationError, ShapeError
from estimators.recording import Float

_QUIET: Final = 0.04
"""How far specific force may be from gravity, relative, for its direction to be up."""


@dataclass(frozen=True)
class LocalField:
    """The earth's field at the place, as far as it was told.

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


def local_field(field: Float, accelerometer_mps2: Float | None = None) -> LocalField:
    """Return norm and dip of the field, from corrected samples, shape (N, 3), and the accelerometer's.

    Only quiet samples, whose specific force is gravity to 4 percent, count for the dip.
    """
    if field.ndim != 2 or field.shape[1] != 3:
        raise ShapeError(f"field has shape {field.shape}; it must be (N, 3)")
    finite = np.isfinite(field).all(axis=1)
    ups = np.full(field.shape, np.nan) if accelerometer_mps2 is None else quiet_up(accelerometer_mps2)
    if not finite.any():
        raise CalibrationError("the magnetometer gave no data; check that it is switched on")
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


__all__ = ["LocalField", "field_of", "local_field", "quiet_up"]
