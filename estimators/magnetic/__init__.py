"""Relative pose from body-worn magnetic sources."""

from estimators.magnetic._bench import Stop, find_stops
from estimators.magnetic._closed_form import ClosedForm, closed_form, closed_form_published, dipole_covariance
from estimators.magnetic._coil import (
    Coil,
    FieldModel,
    Source,
    biot_savart,
    dipole_field,
    dipole_gradient,
    perpendicular_source,
)
from estimators.magnetic._coil_calibration import CoilCalibration, calibrate_coils, calibrate_moments
from estimators.magnetic._coil_state import CURRENT_SPAN_A, coil_state, read_coil_state
from estimators.magnetic._iron import IronSphere
from estimators.magnetic._loop_kernel import MU0_TM_PER_A
from estimators.magnetic._measurement import (
    MAGNETOMETER_SIGMA_T,
    Prediction,
    Updated,
    choose_coil,
    choose_current,
    noise_covariance,
    posterior_covariance,
    predict,
    update,
)
from estimators.magnetic._place_calibration import calibrate_at_places
from estimators.magnetic._pulses import Pulse, bursts, extract_pulses, find_pulses, integrate_gyroscope
from estimators.magnetic._shoes import SHOE_PARAMETERS, shoe_source
from estimators.magnetic._validity import (
    PACEMAKER_LIMIT_T,
    axial_dipole_error,
    axial_reach_m,
    curvature_per_m2,
    keep_away_distance_m,
    linearisation_error_percent,
    range_m,
    required_moment_am2,
)
from estimators.magnetic.relative.parameters import SPARING_PARAMETERS, RelativePoseParameters
from estimators.magnetic.relative.pose import (
    EnergyAccount,
    RelativeChunk,
    RelativeFlag,
    RelativePoseFilter,
    RelativeResult,
)
from estimators.magnetic.relative.smoother import SmoothedPose, smooth_relative_pose
from estimators.magnetic.tracker.burst import (
    BurstNoise,
    BurstPath,
    CarriedFix,
    ModuleSignals,
    burst_path,
    locate_moving,
    pulse_covariance,
)
from estimators.magnetic.tracker.follow import FollowedBurst, follow_bursts, middle_tick
from estimators.magnetic.tracker.fusion import (
    TrackerFusion,
    TrackerFusionChunk,
    TrackerFusionParameters,
    TrackerFusionResult,
)
from estimators.magnetic.tracker.fusion_smoother import smooth_tracker_fusion
from estimators.magnetic.tracker.segment_tracker import Fix, TrackerFlag, TrackerLimits, locate

__all__ = [
    "CURRENT_SPAN_A",
    "MAGNETOMETER_SIGMA_T",
    "MU0_TM_PER_A",
    "PACEMAKER_LIMIT_T",
    "SHOE_PARAMETERS",
    "SPARING_PARAMETERS",
    "BurstNoise",
    "BurstPath",
    "CarriedFix",
    "ClosedForm",
    "Coil",
    "CoilCalibration",
    "EnergyAccount",
    "FieldModel",
    "Fix",
    "FollowedBurst",
    "IronSphere",
    "ModuleSignals",
    "Prediction",
    "Pulse",
    "RelativeChunk",
    "RelativeFlag",
    "RelativePoseFilter",
    "RelativePoseParameters",
    "RelativeResult",
    "SmoothedPose",
    "Source",
    "Stop",
    "TrackerFlag",
    "TrackerFusion",
    "TrackerFusionChunk",
    "TrackerFusionParameters",
    "TrackerFusionResult",
    "TrackerLimits",
    "Updated",
    "axial_dipole_error",
    "axial_reach_m",
    "biot_savart",
    "burst_path",
    "bursts",
    "calibrate_at_places",
    "calibrate_coils",
    "calibrate_moments",
    "choose_coil",
    "choose_current",
    "closed_form",
    "closed_form_published",
    "coil_state",
    "curvature_per_m2",
    "dipole_covariance",
    "dipole_field",
    "dipole_gradient",
    "extract_pulses",
    "find_pulses",
    "find_stops",
    "follow_bursts",
    "integrate_gyroscope",
    "keep_away_distance_m",
    "linearisation_error_percent",
    "locate",
    "locate_moving",
    "middle_tick",
    "noise_covariance",
    "perpendicular_source",
    "posterior_covariance",
    "predict",
    "pulse_covariance",
    "range_m",
    "read_coil_state",
    "required_moment_am2",
    "shoe_source",
    "smooth_relative_pose",
    "smooth_tracker_fusion",
    "update",
]
