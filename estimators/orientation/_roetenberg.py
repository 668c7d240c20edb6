"""The complementary Kalman filter with magnetic disturbance of Roetenberg (2006), chapters 2 and 3, corrected.

Corrected (method page, section 3): the turn of the error with the sensor (E1), sign and size of the
covariance of a step (E2), offset and noise that were counted twice (E3, E4), and the cross covariances that
were thrown away (E5). The recommended detector smooths the field before it differences it, and a rule lets the
disturbance vanish where norm and dip are those of the start (E7, 2.5).

The page keeps the published treatment of the predicted acceleration; its sister page on the parent filter
derives that it overstates gravity's weight (Luinge, E-7). The default here is the derived form, since only it
keeps the errors inside their covariance; `PAGE` is the page's, `PUBLISHED` the thesis' structure.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation import _roetenberg_kernel as kernel
from estimators.orientation import _roetenberg_layout as at
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._strapdown_estimator import (
    REFERENCE_RATE_HZ,
    StrapdownEstimator,
    StrapdownParameters,
    StrapdownResult,
)
from estimators.recording import Float


@dataclass(frozen=True)
class RoetenbergParameters(StrapdownParameters):
    """The page's recommended figures (section 5); magnetic ones are in units of the field at the start.

    `magnetometer_sigma`: noise of a sample. `disturbance_correlation`: c_d of d(t) = c_d d(t - 10 ms) + w.
    `detector_smoothing` and `detector_dead_band`: of norm and dip, for 10 ms; `detector_norm_gain` and
    `detector_dip_gain` (per rad) turn their change into that of the disturbance, never less than
    `disturbance_floor`. Where the norm is within `nominal_norm` of one and the dip within `nominal_dip_deg` for
    `nominal_s` there is no disturbance; outside `guard_norm` and `guard_dip_deg` the field is flagged, and after
    `magnetic_trust_s` of that, or with a heading sigma above `heading_lost_deg`, the heading is not trusted.

    `compensation` off is the filter without disturbance, `use_field` off the inclination alone, `use_gravity`
    off as well the gyroscope alone. `published_covariance`, `published_detector` and `published_acceleration`
    select the thesis' block-diagonal covariance, raw differences and fixed predicted acceleration.
    """

    acceleration_change_sigma_mps2: float = 1.0
    bias_walk_degps_per_sqrt_s: float = 3e-3
    initial_attitude_sigma_deg: float = 2.0
    magnetometer_sigma: float = 0.01
    disturbance_correlation: float = 1.0
    disturbance_floor: float = 1e-5
    detector_smoothing: float = 0.1
    detector_dead_band: float = 4e-4
    detector_norm_gain: float = 10.0
    detector_dip_gain: float = 10.0
    nominal_norm: float = 0.02
    nominal_dip_deg: float = 1.2
    nominal_s: float = 0.3
    guard_norm: float = 0.05
    guard_dip_deg: float = 3.0
    magnetic_trust_s: float = 60.0
    heading_lost_deg: float = 5.0
    compensation: bool = True
    use_gravity: bool = True
    use_field: bool = True
    published_covariance: bool = False
    published_detector: bool = False
    published_acceleration: bool = False


PAGE: Final[dict[str, Any]] = {"published_acceleration": True}
"""The method page's recommended filter to the letter."""

PUBLISHED: Final[dict[str, Any]] = {
    "published_covariance": True,
    "published_acceleration": True,
    "published_detector": True,
    "detector_norm_gain": 3.0,
    "detector_dip_gain": 3.0,
    "disturbance_floor": 1e-4,
}
"""The thesis' structure: blocks of the covariance only, raw differences (page, section 5)."""


class RoetenbergEstimator(StrapdownEstimator):
    """State: errors of orientation, offset and magnetic disturbance (9); gravity and field measure.

    The reference is the field at the first start and is not learned anew: a start beside iron is flagged as
    disturbed when the sensor leaves it. After a long gap the heading is taken from the field only where that
    is the reference. A detector of norm and dip cannot see a field that is merely turned.
    """

    name: ClassVar[str] = "roetenberg_disturbance"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Magnetic-disturbance Kalman filter"
    description: ClassVar[str] = (
        "Published filter that works out how iron nearby bends the magnetic field and keeps the heading beside it."
    )
    _parameter_kind = RoetenbergParameters
    _positive = (*StrapdownEstimator._positive, "magnetometer_sigma", "heading_lost_deg")
    _covariance_size = at.STATES
    _memory_columns = at.MEMORY
    _counter_columns = at.COUNTERS
    _details = at.DETAILS
    _parameters: RoetenbergParameters

    def _own_settings(self) -> Float:
        p, step_s = self._parameters, self._guard.time_step_s
        steps_per_reference = step_s * REFERENCE_RATE_HZ
        # What the share of gravity in the row is divided by, and the variance that this leaves (Luinge page, E-7).
        lever = 1.0 / (1.0 - self._acceleration_gain)
        tilt_variance = self._change_variance + (1.0 + self._acceleration_gain**2) * self._force_variance
        settings = np.zeros(at.SETTINGS - steps.SHARED_SETTINGS)
        for position, value in (
            (at.USE_GRAVITY, float(p.use_gravity)),
            (at.USE_FIELD, float(p.use_field)),
            (at.COMPENSATE, float(p.compensation)),
            (at.BLOCKS_ONLY, float(p.published_covariance)),
            (at.RAW_DETECTOR, float(p.published_detector)),
            (at.HELD_ACCELERATION, float(p.published_acceleration)),
            (at.CHANGE_VARIANCE, self._change_variance),
            (at.FORCE_VARIANCE, self._force_variance),
            (at.FIELD_VARIANCE, p.magnetometer_sigma**2 * self._noise_scale),
            (at.DISTURBANCE_GAIN, p.disturbance_correlation**steps_per_reference),
            (at.SMOOTHING, 1.0 - (1.0 - min(p.detector_smoothing, 1.0)) ** steps_per_reference),
            (at.DEAD_BAND, p.detector_dead_band * steps_per_reference),
            # A step of the field grows with the time step; the variance of a second of steps is to stay.
            (at.NORM_GAIN, p.detector_norm_gain / math.sqrt(steps_per_reference)),
            (at.DIP_GAIN, p.detector_dip_gain / math.sqrt(steps_per_reference)),
            (at.FLOOR_VARIANCE, p.disturbance_floor**2 * steps_per_reference if p.compensation else 0.0),
            (at.NOMINAL_NORM, p.nominal_norm),
            (at.NOMINAL_DIP, math.radians(p.nominal_dip_deg)),
            (at.NOMINAL_TICKS, round(p.nominal_s / step_s)),
            (at.GUARD_NORM, p.guard_norm),
            (at.GUARD_DIP, math.radians(p.guard_dip_deg)),
            (at.HEADING_LOST, math.radians(p.heading_lost_deg) ** 2),
            (at.TRUST_TICKS, p.magnetic_trust_s / step_s),
            (at.TILT_LEVER, lever),
            (at.TILT_VARIANCE, tilt_variance * (lever / GRAVITY_MPS2) ** 2),
        ):
            settings[position - steps.SHARED_SETTINGS] = value
        return settings

    def _run(self, *arrays: NDArray[Any]) -> None:
        kernel.run(*arrays)

    def _detailed(self, result: StrapdownResult, details: Float) -> StrapdownResult:
        return replace(
            result,
            whitened_innovations=details[..., 3 : 3 + at.INNOVATIONS],
            disturbance_earth=details[..., at.DETAIL_DISTURBANCE : at.DETAIL_DISTURBANCE + 3],
            field_norm=details[..., at.DETAIL_NORM],
            field_dip_rad=details[..., at.DETAIL_DIP],
        )


__all__ = ["PAGE", "PUBLISHED", "RoetenbergEstimator", "RoetenbergParameters"]
