"""The body network with exact truth: movements, sensors, their errors; faults in `simulation.faults`."""

from estimators.simulation import faults
from estimators.simulation._calibration_movements import (
    CALIBRATION_STYLE,
    calibration_exercise,
    calibration_ranges_s,
)
from estimators.simulation._errors import SENSOR_PRESETS, SensorErrors, TriadErrors, sensor_errors
from estimators.simulation._exercises import EXERCISES, Exercise, ExerciseName
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

__all__ = [
    "ARM_PLACEMENTS",
    "CALIBRATION_STYLE",
    "EXERCISES",
    "IMPAIRMENT",
    "SENSOR_PRESETS",
    "ArmScenario",
    "ArmTruth",
    "EarthField",
    "Exercise",
    "ExerciseName",
    "Magnet",
    "Mounting",
    "MovementStyle",
    "PatientName",
    "Schedule",
    "SensorClocks",
    "SensorErrors",
    "SimulatedSession",
    "TriadErrors",
    "calibration_exercise",
    "calibration_ranges_s",
    "demonstration_scenario",
    "dipole_field",
    "faults",
    "outward_mounting",
    "sensor_errors",
    "simulate_arm",
    "style_of_impairment",
]
