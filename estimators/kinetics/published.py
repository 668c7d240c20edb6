"""The parts of force calibration, reaction and ankle power: for experiments and tests."""

from estimators.kinetics._conditioning import fill_gaps, lag_s, on_one_time_base, shank_mounting
from estimators.kinetics._contact import shoe_contact
from estimators.kinetics._cycles import CycleCurves, over_cycles, rms_difference
from estimators.kinetics._ground_reaction import REPORT_SHARE, is_inside_sole, pressure_point
from estimators.kinetics._joint_loads import ankle_load, environment_power, hinge_load, work_j
from estimators.kinetics._load_cell import calibrate_load_cell, tare, unloaded
from estimators.kinetics._predicted import PredictedReaction, predicted_reaction
from estimators.kinetics._shoe_pose import shoe_pose

__all__ = [
    "REPORT_SHARE",
    "CycleCurves",
    "PredictedReaction",
    "ankle_load",
    "calibrate_load_cell",
    "environment_power",
    "fill_gaps",
    "hinge_load",
    "is_inside_sole",
    "lag_s",
    "on_one_time_base",
    "over_cycles",
    "predicted_reaction",
    "pressure_point",
    "rms_difference",
    "shank_mounting",
    "shoe_contact",
    "shoe_pose",
    "tare",
    "unloaded",
    "work_j",
]
