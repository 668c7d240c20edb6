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

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation import _luinge_kernel as consistent
from estimators.orientation import _luinge_published_kernel as published
from estimators.orientation import _luinge_rest as rest
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._strapdown_estimator import (
    StrapdownEstimator,
    StrapdownParameters,
    StrapdownResult,
)
from estimators.recording import Float, ImuChunk


@dataclass(frozen=True)
class LuingeParameters(StrapdownParameters):
    """The consistent filter with the page's figures; the offset may drift with temperature (E-9).

    `rest_update`: measure the offset where nothing varies for `rest_window_s` by more than
    `rest_sigma_factor` times the noise. `published_structure`: the paper's filter (A4), without rest update.
    """

    rest_update: bool = True
    rest_window_s: float = 0.5
    rest_sigma_factor: float = 2.0
    published_structure: bool = False


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
    _positive = (*StrapdownEstimator._positive, "rest_window_s", "rest_sigma_factor")
    _covariance_size = 6
    _memory_columns = rest.MEMORY
    _counter_columns = rest.COUNTERS
    _details = 6
    _parameters: LuingeParameters

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(sensor_count, time_step_s, parameters)
        self._kernel = published.run if self._parameters.published_structure else consistent.run

    def _own_settings(self) -> Float:
        p, step_s = self._parameters, self._guard.time_step_s
        force, gain = self._force_variance, self._acceleration_gain
        # R_v of A5.3 over the square of the row's (1 - c_a).
        inclination = (self._change_variance + (1.0 + gain**2) * force) / (GRAVITY_MPS2 * (1.0 - gain)) ** 2
        block = max(round(p.rest_window_s / rest.BLOCKS / step_s), 1) if p.rest_update else 0
        rate_sigma = p.gyroscope_sigma_radps * math.sqrt(self._noise_scale)
        settings = np.zeros(published.SETTINGS - steps.SHARED_SETTINGS)
        for position, value in (
            (consistent.INCLINATION_VARIANCE, inclination),
            (rest.BLOCK_TICKS, float(block)),
            (rest.RATE_LIMIT, p.rest_sigma_factor * rate_sigma),
            (rest.FORCE_LIMIT, p.rest_sigma_factor * math.sqrt(force)),
            (published.FORCE_VARIANCE, force),
            (published.CHANGE_VARIANCE, self._change_variance),
        ):
            settings[position - steps.SHARED_SETTINGS] = value
        return settings

    def _field(self, chunk: ImuChunk) -> Float | None:
        return None

    def _run(self, *arrays: NDArray[Any]) -> None:
        self._kernel(*arrays)

    def _detailed(self, result: StrapdownResult, details: Float) -> StrapdownResult:
        innovations = 3 if self._parameters.published_structure else 2
        return replace(result, whitened_innovations=details[..., 3 : 3 + innovations])


__all__ = ["PUBLISHED", "LuingeEstimator", "LuingeParameters"]
