"""Constants of a session: static bias, how sensors sit on their segments, and how good that is."""

from estimators.calibration._contract import Calibration
from estimators.calibration._device import DeviceCalibration, TriadCalibration, correct, direction_variance
from estimators.calibration._ferraris import FerrarisResult, Rest, ferraris, find_positions
from estimators.calibration._n_pose import n_pose
from estimators.calibration._placement import MisplacedError, PlacementFinding, check_mounting
from estimators.calibration._static import UNUSUAL_BIAS_SCORE, StaticBias, static_bias, unusual_bias
from estimators.calibration.field.full_turns import FullTurn, doubted_turns
from estimators.calibration.field.local_field import LocalField, odd_fields
from estimators.calibration.field.magnetometer import (
    MagnetometerCollector,
    MagnetometerProgress,
    MagnetometerResult,
)
from estimators.calibration.field.turns import circle_fit
from estimators.calibration.force.verdict import Correction
from estimators.calibration.movement.facing import (
    CONTRADICTED_SCORE,
    JUDGED,
    Postures,
    has_impossible,
    judged_by_movement,
)
from estimators.calibration.movement.functional import FunctionalResult, functional
from estimators.calibration.movement.joint_axes import AxisEstimate
from estimators.calibration.movement.one_way_joints import HINGES, bendings, raisings
from estimators.calibration.movement.ordinary_elbow import OrdinaryElbow, elbow_from_movement
from estimators.calibration.plausibility.finding import Finding, Hemisphere, TwoLooks, in_words
from estimators.calibration.plausibility.recording_check import STRETCH_S, RecordingCheck, check_recording
from estimators.calibration.plausibility.same_signals import check_distinct, same_signals

__all__ = [
    "CONTRADICTED_SCORE",
    "HINGES",
    "JUDGED",
    "STRETCH_S",
    "UNUSUAL_BIAS_SCORE",
    "AxisEstimate",
    "Calibration",
    "Correction",
    "DeviceCalibration",
    "FerrarisResult",
    "Finding",
    "FullTurn",
    "FunctionalResult",
    "Hemisphere",
    "LocalField",
    "MagnetometerCollector",
    "MagnetometerProgress",
    "MagnetometerResult",
    "MisplacedError",
    "OrdinaryElbow",
    "PlacementFinding",
    "Postures",
    "RecordingCheck",
    "Rest",
    "StaticBias",
    "TriadCalibration",
    "TwoLooks",
    "bendings",
    "check_distinct",
    "check_mounting",
    "check_recording",
    "circle_fit",
    "correct",
    "direction_variance",
    "doubted_turns",
    "elbow_from_movement",
    "ferraris",
    "find_positions",
    "functional",
    "has_impossible",
    "in_words",
    "judged_by_movement",
    "n_pose",
    "odd_fields",
    "raisings",
    "same_signals",
    "static_bias",
    "unusual_bias",
]
