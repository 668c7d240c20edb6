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

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._parameters import parameter
from estimators.orientation._strapdown_steps import DETAIL_INNOVATION
from estimators.recording import Float
from published._strapdown_estimator import (
    REFERENCE_RATE_HZ,
    StrapdownEstimator,
    StrapdownParameters,
    StrapdownResult,
)
from published.roetenberg import _kernel as kernel
from published.roetenberg._model import (
    DETAILS,
    DIP,
    DISTURBANCE,
    NORM,
    SETTINGS,
    STATE,
    STATES,
)


@dataclass(frozen=True)
class RoetenbergParameters(StrapdownParameters):
    """The page's recommended figures (section 5); magnetic ones are in units of the field at the start.

    The detector's changes of norm and dip, in 10 ms, become that of the disturbance.
    """

    acceleration_change_sigma_mps2: float = parameter(1.0, "m/s^2", "sigma_w of the acceleration")
    bias_walk_degps_per_sqrt_s: float = parameter(3e-3, "deg/s/sqrt(s)", "random walk of the gyroscope bias")
    initial_attitude_sigma_deg: float = parameter(2.0, "deg", "of an axis at a start at rest")
    magnetometer_sigma: float = parameter(0.01, "field", "noise of a sample", above=0.0)
    disturbance_correlation: float = parameter(1.0, "", "c_d of d(t) = c_d d(t - 10 ms) + w")
    disturbance_floor: float = parameter(1e-5, "field", "least change of the disturbance in 10 ms")
    detector_smoothing: float = parameter(0.1, "", "share of a new norm and dip, for 10 ms")
    detector_dead_band: float = parameter(4e-4, "field or rad", "change of norm or dip that is none")
    detector_norm_gain: float = parameter(10.0, "", "of the change of norm")
    detector_dip_gain: float = parameter(10.0, "1/rad", "of the change of dip")
    nominal_norm: float = parameter(0.02, "field", "within this of one there is no disturbance")
    nominal_dip_deg: float = parameter(1.2, "deg", "and within this of the reference's dip")
    nominal_s: float = parameter(0.3, "s", "and for so long")
    guard_norm: float = parameter(0.05, "field", "norm off one from which the field is flagged")
    guard_dip_deg: float = parameter(3.0, "deg", "dip off the reference's from which the field is flagged")
    magnetic_trust_s: float = parameter(
        60.0, "s", "of a flagged field after which the heading is not trusted"
    )
    heading_lost_deg: float = parameter(5.0, "deg", "sigma above which the heading is not trusted", above=0.0)
    compensation: bool = parameter(True, "", "off: the filter without disturbance")
    use_gravity: bool = parameter(True, "", "off, with the field: the gyroscope alone")
    use_field: bool = parameter(True, "", "off: the inclination alone")
    published_covariance: bool = parameter(False, "", "the thesis' block-diagonal covariance")
    published_detector: bool = parameter(False, "", "the thesis' raw differences")
    published_acceleration: bool = parameter(False, "", "the thesis' fixed predicted acceleration")


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

    The reference is the field at the first start and is not learned again: a start beside iron is flagged as
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
    _settings_kind = SETTINGS
    _state_kind = STATE
    _covariance_size = STATES
    _details = DETAILS
    _parameters: RoetenbergParameters

    def _own_settings(self) -> dict[str, float]:
        p, step_s = self._parameters, self._guard.time_step_s
        steps_per_reference = step_s * REFERENCE_RATE_HZ
        # What the share of gravity in the row is divided by, and the variance that this leaves (Luinge page, E-7).
        lever = 1.0 / (1.0 - self._acceleration_gain)
        tilt_variance = self._change_variance + (1.0 + self._acceleration_gain**2) * self._force_variance
        return {
            "use_gravity": p.use_gravity,
            "use_field": p.use_field,
            "compensate": p.compensation,
            "blocks_only": p.published_covariance,
            "raw_detector": p.published_detector,
            "held_acceleration": p.published_acceleration,
            "field_variance": p.magnetometer_sigma**2 * self._noise_scale,
            "disturbance_gain": p.disturbance_correlation**steps_per_reference,
            "smoothing": 1.0 - (1.0 - min(p.detector_smoothing, 1.0)) ** steps_per_reference,
            "dead_band": p.detector_dead_band * steps_per_reference,
            # A step of the field grows with the time step; the variance of a second of steps is to stay.
            "norm_gain": p.detector_norm_gain / math.sqrt(steps_per_reference),
            "dip_gain": p.detector_dip_gain / math.sqrt(steps_per_reference),
            "floor_variance": p.disturbance_floor**2 * steps_per_reference if p.compensation else 0.0,
            "nominal_norm": p.nominal_norm,
            "nominal_dip": math.radians(p.nominal_dip_deg),
            "nominal_ticks": round(p.nominal_s / step_s),
            "guard_norm": p.guard_norm,
            "guard_dip": math.radians(p.guard_dip_deg),
            "heading_lost_variance": math.radians(p.heading_lost_deg) ** 2,
            "trust_ticks": p.magnetic_trust_s / step_s,
            "tilt_lever": lever,
            "tilt_variance": tilt_variance * (lever / GRAVITY_MPS2) ** 2,
        }

    def _run(self, *arguments: Any) -> None:
        kernel.run(*arguments)

    def _detailed(self, result: StrapdownResult, details: Float) -> StrapdownResult:
        return replace(
            result,
            whitened_innovations=details[..., DETAIL_INNOVATION:DISTURBANCE],
            disturbance_earth=details[..., DISTURBANCE:NORM],
            field_norm=details[..., NORM],
            field_dip_rad=details[..., DIP],
        )
