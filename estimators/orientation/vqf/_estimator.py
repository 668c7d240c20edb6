"""VQF (Laidig and Seel, 2023) behind the contract; its own package is the oracle in the tests."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from estimators.orientation._record_estimator import RecordEstimator
from estimators.orientation.vqf import _kernel as kernel
from estimators.orientation.vqf._parameters import VqfParameters, in_bias_units, settings_of
from estimators.orientation.vqf._steps import SETTINGS, STATE


class VqfEstimator(RecordEstimator):
    """VQF for a network, with gaps, flags and an error budget (see `_quality.annotate`).

    Without MISSING samples the estimate is that of `vqf.VQF.updateBatch`, sensor by sensor, with the
    magnetometer where it is finite. A MISSING sample holds the last orientation; the first usable one
    after it restarts the averaging of inclination and heading around the held values, with the
    gyroscope bias and the reference field as they were.
    """

    name: ClassVar[str] = "vqf"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "VQF"
    description: ClassVar[str] = (
        "Learns the sensor's drift while still and moving and ignores passing magnetic disturbances; "
        "widely used and well proven."
    )
    _parameter_kind = VqfParameters
    _settings_kind = SETTINGS
    _state_kind = STATE
    _covariance_size = 3
    _bias_first = 0
    _parameters: VqfParameters

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(sensor_count, time_step_s, parameters)
        x = self._state
        x["gyroscope_q"][:, 0] = x["accelerometer_q"][:, 0] = 1.0
        x["start_gain"] = x["is_field_rejected"] = 1
        x["rejected_s"] = self._parameters.magnetic_maximum_rejection_s
        x["candidate_norm"] = x["since_start"] = -1
        super()._set_bias_covariance(in_bias_units(self._parameters.bias_sigma_initial_degps))

    def _set_bias_covariance(self, sigma_radps: float) -> None:
        super()._set_bias_covariance(in_bias_units(math.degrees(sigma_radps)))

    def _make_settings(self) -> dict[str, Any]:
        return settings_of(self._parameters, self._guard.time_step_s)

    def _run(self, *arguments: Any) -> None:
        kernel.run(*arguments)
