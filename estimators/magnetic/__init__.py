"""Relative pose from body-worn magnetic sources."""

from estimators.magnetic._bench import Stop, find_stops
from estimators.magnetic._coil import Coil, FieldModel, Source, perpendicular_source
from estimators.magnetic._coil_calibration import CoilCalibration
from estimators.magnetic._coil_state import CURRENT_SPAN_A, coil_state, read_coil_state
from estimators.magnetic._iron import IronSphere
from estimators.magnetic._place_calibration import calibrate_at_places
from estimators.magnetic._pulses import Pulse, bursts, extract_pulses, integrate_gyroscope
from estimators.magnetic._validity import PACEMAKER_LIMIT_T, keep_away_distance_m
from estimators.magnetic.relative.parameters import RelativePoseParameters
from estimators.magnetic.relative.pose import (
    EnergyAccount,
    RelativeChunk,
    RelativeFlag,
    RelativePoseFilter,
    RelativeResult,
)
from estimators.magnetic.tracker.burst import BurstNoise, CarriedFix, ModuleSignals
from estimators.magnetic.tracker.follow import FollowedBurst, follow_bursts
from estimators.magnetic.tracker.fusion import (
    TrackerFusionChunk,
    TrackerFusionParameters,
    TrackerFusionResult,
)
from estimators.magnetic.tracker.fusion_smoother import smooth_tracker_fusion
from estimators.magnetic.tracker.segment_tracker import Fix, TrackerFlag, TrackerLimits, locate

__all__ = [
    "CURRENT_SPAN_A",
    "PACEMAKER_LIMIT_T",
    "BurstNoise",
    "CarriedFix",
    "Coil",
    "CoilCalibration",
    "EnergyAccount",
    "FieldModel",
    "Fix",
    "FollowedBurst",
    "IronSphere",
    "ModuleSignals",
    "Pulse",
    "RelativeChunk",
    "RelativeFlag",
    "RelativePoseFilter",
    "RelativePoseParameters",
    "RelativeResult",
    "Source",
    "Stop",
    "TrackerFlag",
    "TrackerFusionChunk",
    "TrackerFusionParameters",
    "TrackerFusionResult",
    "TrackerLimits",
    "bursts",
    "calibrate_at_places",
    "coil_state",
    "extract_pulses",
    "find_stops",
    "follow_bursts",
    "integrate_gyroscope",
    "keep_away_distance_m",
    "locate",
    "perpendicular_source",
    "read_coil_state",
    "smooth_tracker_fusion",
]
