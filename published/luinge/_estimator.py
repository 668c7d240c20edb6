"""The inclination and gyroscope-offset Kalman filter of Luinge and Veltink (2005), corrected.

The default is the form the method page calls consistent (A5): error in the earth frame, full covariance, and a
measurement row that knows that the predicted acceleration came from the same orientation. `PUBLISHED` is the
structure of the paper with its signs and dimensions put right (A4) and its own drift of the offset.

Of the paper's errors (page, section 3) the default corrects the sign of the measurement matrix (E-1), the
offset that entered twice (E-2, E-3), a missing step time (E-4), the turn of the error with the sensor (E-5),
the dropped cross covariance (E-6) and the neglected dependence of the acceleration on orientation (E-7).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._parameters import parameter
from estimators.orientation._strapdown_steps import DETAIL_INNOVATION
from estimators.recording import Float, ImuChunk
from published._strapdown_estimator import (
    StrapdownEstimator,
    StrapdownParameters,
    StrapdownResult,
)
from published.luinge import _consistent as consistent
from published.luinge import _published as published
from published.luinge._rest import BLOCKS


@dataclass(frozen=True)
class LuingeParameters(StrapdownParameters):
    """The consistent filter with the page's figures; the offset may drift with temperature (E-9)."""

    rest_update: bool = parameter(True, "", "measure the offset where nothing varies")
    rest_window_s: float = parameter(0.5, "s", "in which nothing may vary", above=0.0)
    rest_sigma_factor: float = parameter(2.0, "", "times the noise, the most that rest varies by", above=0.0)
    published_structure: bool = parameter(False, "", "the paper's filter (A4), without rest update")


PUBLISHED: Final[dict[str, Any]] = {
    "published_structure": True,
    "rest_update": False,
    "bias_walk_degps_per_sqrt_s": 3e-3,
}
"""The paper's structure with its 0.3e-3 degrees a second of offset drift in each step of 10 ms."""


class LuingeEstimator(StrapdownEstimator):
    """State: orientation error and offset error (6), measured by the direction of gravity alone.

    The magnetometer is not used. Heading is what the gyroscope makes of an arbitrary start: always flagged
    HEADING_NOT_TRUSTED, its sigma that of the drift since the start (pi after a long gap). The acceleration
    model takes motion for noise, so that sigma is smaller than the error where acceleration lasts (E-12).
    """

    name: ClassVar[str] = "luinge_inclination"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Inclination Kalman filter"
    description: ClassVar[str] = (
        "Published filter that ignores magnetism: how far each sensor leans is sound, where it faces drifts."
    )
    _parameter_kind = LuingeParameters
    _settings_kind = consistent.SETTINGS
    _state_kind = consistent.STATE
    _covariance_size = 6
    _details = 6
    _parameters: LuingeParameters

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(sensor_count, time_step_s, parameters)
        self._kernel = published.run if self._parameters.published_structure else consistent.run

    def _own_settings(self) -> dict[str, float]:
        p, step_s = self._parameters, self._guard.time_step_s
        force, gain = self._force_variance, self._acceleration_gain
        rate_sigma = p.gyroscope_sigma_radps * math.sqrt(self._noise_scale)
        return {
            # R_v of A5.3 over the square of the row's (1 - c_a).
            "inclination_variance": (self._change_variance + (1.0 + gain**2) * force)
            / (GRAVITY_MPS2 * (1.0 - gain)) ** 2,
            "block_ticks": max(round(p.rest_window_s / BLOCKS / step_s), 1) if p.rest_update else 0,
            "rate_limit": p.rest_sigma_factor * rate_sigma,
            "force_limit": p.rest_sigma_factor * math.sqrt(force),
        }

    def _field(self, chunk: ImuChunk) -> Float | None:
        return None

    def _run(self, *arguments: Any) -> None:
        self._kernel(*arguments)

    def _detailed(self, result: StrapdownResult, details: Float) -> StrapdownResult:
        innovations = 3 if self._parameters.published_structure else 2
        return replace(
            result, whitened_innovations=details[..., DETAIL_INNOVATION : DETAIL_INNOVATION + innovations]
        )
