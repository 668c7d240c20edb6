"""The published magnetic model and tracker, and the parts of ours: for experiments and tests."""

from estimators.magnetic._closed_form import ClosedForm, closed_form, closed_form_published, dipole_covariance
from estimators.magnetic._coil import biot_savart, dipole_field, dipole_gradient
from estimators.magnetic._coil_calibration import calibrate_coils, calibrate_moments
from estimators.magnetic._loop_kernel import MU0_TM_PER_A
from estimators.magnetic._measurement import (
    Prediction,
    Updated,
    choose_coil,
    choose_current,
    noise_covariance,
    posterior_covariance,
    predict,
    update,
)
from estimators.magnetic._pulses import find_pulses
from estimators.magnetic._shoes import SHOE_PARAMETERS, shoe_source
from estimators.magnetic._validity import (
    axial_dipole_error,
    axial_reach_m,
    curvature_per_m2,
    linearisation_error_percent,
    range_m,
    required_moment_am2,
)
from estimators.magnetic.relative.parameters import SPARING_PARAMETERS
from estimators.magnetic.relative.smoother import SmoothedPose
from estimators.magnetic.tracker.burst import BurstPath, locate_moving, pulse_covariance
from estimators.magnetic.tracker.follow import middle_tick
from estimators.magnetic.tracker.fusion import TrackerFusion

__all__ = [
    "MU0_TM_PER_A",
    "SHOE_PARAMETERS",
    "SPARING_PARAMETERS",
    "BurstPath",
    "ClosedForm",
    "Prediction",
    "SmoothedPose",
    "TrackerFusion",
    "Updated",
    "axial_dipole_error",
    "axial_reach_m",
    "biot_savart",
    "calibrate_coils",
    "calibrate_moments",
    "choose_coil",
    "choose_current",
    "closed_form",
    "closed_form_published",
    "curvature_per_m2",
    "dipole_covariance",
    "dipole_field",
    "dipole_gradient",
    "find_pulses",
    "linearisation_error_percent",
    "locate_moving",
    "middle_tick",
    "noise_covariance",
    "posterior_covariance",
    "predict",
    "pulse_covariance",
    "range_m",
    "required_moment_am2",
    "shoe_source",
    "update",
]
