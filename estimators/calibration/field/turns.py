"""Hard iron from two full turns about the vertical: the circle fit of Marzouk (2009), A17."""

import math
from typing import Final

import numpy as np

from estimators import rotation
from estimators.calibration._device import TriadCalibration, matrix, vector
from estimators.calibration.field.local_field import local_field
from estimators.calibration.field.magnetometer import MagnetometerResult
from estimators.errors import CalibrationError, ShapeError
from estimators.recording import Float
from estimators.sentences import say

_SECTORS: Final = 24
_FEWEST_SAMPLES: Final = 40
_TILT_RAD: Final = math.radians(12.0)
_RESIDUAL_WARNING: Final = 0.08
_RESIDUAL_FAULT: Final = 0.25
_LEAST_SHARE: Final = 0.08


def circle_fit(field: Float, accelerometer_mps2: Float | None = None) -> MagnetometerResult:
    """Find the hard iron across the vertical from turns about it.

    Parameters
    ----------
    field : ndarray, shape (N, 3)
        Raw readings, before any normalisation, while the sensor was turned level, best two full turns.
    accelerometer_mps2 : ndarray, shape (N, 3), optional
        Tells the vertical in sensor axes; its bias must have been taken out: a degree of tilt leaves a degree
        times the tangent of the dip in the heading. Without it the sensor's z axis is taken.

    Returns
    -------
    MagnetometerResult
        Method `circle`; `bias` has no part along the vertical, which level turns cannot tell: right for a
        sensor used in this attitude, less so when it is tilted (the score says so).

    Raises
    ------
    CalibrationError
        If the turn was not a full one, not about the vertical, or the field is not uniform.

    Notes
    -----
    Least squares of x^2 + y^2 = 2 a x + 2 b y + c in the plane across the vertical.
    """
    if field.ndim != 2 or field.shape[1] != 3:
        raise ShapeError(f"field has shape {field.shape}; it must be (N, 3)")
    finite = np.isfinite(field).all(axis=1)
    up = np.array([0.0, 0.0, 1.0])
    if accelerometer_mps2 is not None:
        finite &= np.isfinite(accelerometer_mps2).all(axis=1)
        force = accelerometer_mps2[finite]
        up = np.median(force, axis=0) / np.linalg.norm(np.median(force, axis=0))
        away = np.arccos(np.clip(force @ up / np.linalg.norm(force, axis=1), -1.0, 1.0))
        if np.median(away) > _TILT_RAD:
            raise CalibrationError(say("compass.tilted"))
    values = field[finite]
    if len(values) < _FEWEST_SAMPLES:
        raise CalibrationError(say("compass.few_samples", samples=len(values)))
    to_level = rotation.shortest(up, [0.0, 0.0, 1.0])
    level = rotation.rotate(to_level, values)
    across, along = level[:, :2], level[:, 2]
    middle, size = across.mean(axis=0), float(across.std()) or 1.0
    scaled = (across - middle) / size
    design = np.column_stack((2.0 * scaled, np.ones(len(scaled))))
    solved = np.linalg.lstsq(design, np.sum(scaled**2, axis=1), rcond=None)[0]
    centre = middle + size * solved[:2]
    radius = size * float(np.sqrt(max(solved[2] + solved[:2] @ solved[:2], 0.0)))
    true = across - centre
    if radius < _LEAST_SHARE * float(np.linalg.norm(np.median(level - np.append(centre, 0.0), axis=0))):
        raise CalibrationError(say("compass.field_constant"))
    sectors = np.unique(np.floor(np.arctan2(true[:, 1], true[:, 0]) / (2 * np.pi) * _SECTORS)).size
    if sectors < _SECTORS:
        seen_rad = 2.0 * math.pi * sectors / _SECTORS
        raise CalibrationError(say("compass.part_of_turn", angle_rad=seen_rad))
    distance = np.linalg.norm(true, axis=1) / radius - 1.0
    residual = float(np.sqrt(np.mean(distance**2)))
    if residual > _RESIDUAL_FAULT:
        raise CalibrationError(say("compass.not_uniform", residual=residual))
    score, reasons = 0.8, [say("compass.level_turns_only")]
    if residual > _RESIDUAL_WARNING:
        score *= _RESIDUAL_WARNING / residual
        reasons.append(say("compass.circle_off", residual=residual))
    bias = rotation.rotate(rotation.conjugate(to_level), np.append(centre, 0.0))
    noise = residual * radius
    # Each coordinate of the centre has the variance 2 / N of a sample's; a heading sees one of them.
    heading_sigma = noise * math.sqrt(2.0 / len(values)) / radius
    found = local_field(values - bias, None if accelerometer_mps2 is None else accelerometer_mps2[finite])
    return MagnetometerResult(
        TriadCalibration(matrix(np.eye(3)), vector(bias)),
        "circle",
        found,
        float(np.std(np.hypot(np.linalg.norm(true, axis=1), along)) / found.norm),
        sectors / _SECTORS,
        heading_sigma,
        float("nan"),
        score,
        tuple(reasons),
    )
