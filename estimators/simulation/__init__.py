"""The body network with exact truth: movements, sensors, their errors; faults in `simulation.faults`."""

from estimators.kinetics import ShoeGeometry
from estimators.simulation._errors import SENSOR_PRESETS, SensorErrors, TriadErrors
from estimators.simulation._handling import HandlingName, simulate_handling
from estimators.simulation._sensors import EarthField, Magnet, Mounting, outward_mounting
from estimators.simulation.arm.calibration_movements import (
    CALIBRATION_STYLE,
    calibration_exercise,
    calibration_ranges_s,
    t_pose_exercise,
)
from estimators.simulation.arm.exercises import EXERCISES, Exercise, ExerciseName
from estimators.simulation.arm.movements import (
    MovementStyle,
    PlannedRepetition,
    Schedule,
    style_of_impairment,
)
from estimators.simulation.arm.patients import PatientName, demonstration_scenario
from estimators.simulation.arm.repeated_movement import RepeatedMovement, simulate_repetitions
from estimators.simulation.arm.repeated_shapes import SHAPES
from estimators.simulation.arm.scenario import (
    ARM_PLACEMENTS,
    ArmScenario,
    ArmTruth,
    SensorClocks,
    SimulatedSession,
    simulate_arm,
)
from estimators.simulation.gait.course import Bout, FootStyle, Leg, WalkStyle
from estimators.simulation.gait.presets import GAIT_PRESETS, eyes_closed, gait_preset
from estimators.simulation.gait.scenario import GaitScenario, SimulatedWalk, simulate_gait
from estimators.simulation.gait.shoe import LoadCellErrors, ShoeErrors
from estimators.simulation.gait.truth import FootTruth, GaitTruth
from estimators.simulation.gait.upper import BodyStyle

REPEATED_FAMILIES = tuple(SHAPES)
"""Families of movements that `simulate_repetitions` makes."""

__all__ = [
    "ARM_PLACEMENTS",
    "CALIBRATION_STYLE",
    "EXERCISES",
    "GAIT_PRESETS",
    "REPEATED_FAMILIES",
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
    "HandlingName",
    "Leg",
    "LoadCellErrors",
    "Magnet",
    "Mounting",
    "MovementStyle",
    "PatientName",
    "PlannedRepetition",
    "RepeatedMovement",
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
    "eyes_closed",
    "gait_preset",
    "outward_mounting",
    "simulate_arm",
    "simulate_gait",
    "simulate_handling",
    "simulate_repetitions",
    "style_of_impairment",
    "t_pose_exercise",
]
