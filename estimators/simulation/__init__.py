"""The body network with exact truth: movements, sensors, their errors; faults in `simulation.faults`."""

from estimators.simulation import faults
from estimators.simulation._calibration_movements import (
    CALIBRATION_STYLE,
    calibration_exercise,
    calibration_ranges_s,
)
from estimators.simulation._errors import SENSOR_PRESETS, SensorErrors, TriadErrors, sensor_errors
from estimators.simulation._exercises import EXERCISES, Exercise, ExerciseName
from estimators.simulation._gait_body import BodyStyle
from estimators.simulation._gait_course import Bout, FootStyle, Leg, WalkStyle
from estimators.simulation._gait_scenario import (
    GAIT_PLACEMENTS,
    GaitScenario,
    SimulatedWalk,
    simulate_gait,
)
from estimators.simulation._gait_truth import FootTruth, GaitTruth
from estimators.simulation._movements import (
    MovementStyle,
    Schedule,
    style_of_impairment,
)
from estimators.simulation._patients import IMPAIRMENT, PatientName, demonstration_scenario
from estimators.simulation._scenario import (
    ARM_PLACEMENTS,
    ArmScenario,
    ArmTruth,
    SensorClocks,
    SimulatedSession,
    simulate_arm,
)
from estimators.simulation._sensors import EarthField, Magnet, Mounting, dipole_field, outward_mounting
from estimators.simulation._shoe import LoadCellErrors, ShoeErrors, ShoeGeometry, shoe_errors

__all__ = [
    "ARM_PLACEMENTS",
    "CALIBRATION_STYLE",
    "EXERCISES",
    "GAIT_PLACEMENTS",
    "IMPAIRMENT",
    "SENSOR_PRESETS",
    "ArmScenario",
    "ArmTruth",
    "BodyStyle",
    "Bout",
    "EarthField",
    "Exercise",
    "ExerciseName",
    "FootStyle",
    "FootTruth",
    "GaitScenario",
    "GaitTruth",
    "Leg",
    "LoadCellErrors",
    "Magnet",
    "Mounting",
    "MovementStyle",
    "PatientName",
    "Schedule",
    "SensorClocks",
    "SensorErrors",
    "ShoeErrors",
    "ShoeGeometry",
    "SimulatedSession",
    "SimulatedWalk",
    "TriadErrors",
    "WalkStyle",
    "calibration_exercise",
    "calibration_ranges_s",
    "demonstration_scenario",
    "dipole_field",
    "faults",
    "outward_mounting",
    "sensor_errors",
    "shoe_errors",
    "simulate_arm",
    "simulate_gait",
    "style_of_impairment",
]
