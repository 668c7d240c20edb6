"""Forces under the foot and what they ask of its joints, from an instrumented shoe.

::

    shoe = analyse_shoe(recording.sensors["heel_left"], recording.sensors["forefoot_left"])
    shoe.reaction.cop_m, shoe.reaction.force_n
"""

from estimators.kinetics._analysis import (
    ShoeKinetics,
    ShoeParameters,
    analyse_shoe,
    floor_under,
    segment_rate,
)
from estimators.kinetics._conditioning import fill_gaps, lag_s, on_one_time_base, shank_mounting
from estimators.kinetics._contact import ContactParameters, ShoeContact, shoe_contact, stretches
from estimators.kinetics._cycles import CycleCurves, ForcePeaks, force_peaks, over_cycles, rms_difference
from estimators.kinetics._ground_reaction import (
    LEAST_LOAD_N,
    REPORT_SHARE,
    GroundReaction,
    ShoeLoads,
    ground_reaction,
    is_inside_sole,
    pressure_point,
)
from estimators.kinetics._joint_loads import (
    FootSegment,
    JointLoad,
    ankle_load,
    environment_power,
    hinge_load,
    work_j,
)
from estimators.kinetics._load_cell import (
    LoadCellCalibration,
    calibrate_load_cell,
    clipped_at,
    is_tareable,
    tare,
    unloaded,
)
from estimators.kinetics._predicted import PredictedReaction, predicted_reaction
from estimators.kinetics._shoe_geometry import ShoeGeometry
from estimators.kinetics._shoe_pose import ShoePose, shoe_pose

__all__ = [
    "LEAST_LOAD_N",
    "REPORT_SHARE",
    "ContactParameters",
    "CycleCurves",
    "FootSegment",
    "ForcePeaks",
    "GroundReaction",
    "JointLoad",
    "LoadCellCalibration",
    "PredictedReaction",
    "ShoeContact",
    "ShoeGeometry",
    "ShoeKinetics",
    "ShoeLoads",
    "ShoeParameters",
    "ShoePose",
    "analyse_shoe",
    "ankle_load",
    "calibrate_load_cell",
    "clipped_at",
    "environment_power",
    "fill_gaps",
    "floor_under",
    "force_peaks",
    "ground_reaction",
    "hinge_load",
    "is_inside_sole",
    "is_tareable",
    "lag_s",
    "on_one_time_base",
    "over_cycles",
    "predicted_reaction",
    "pressure_point",
    "rms_difference",
    "segment_rate",
    "shank_mounting",
    "shoe_contact",
    "shoe_pose",
    "stretches",
    "tare",
    "unloaded",
    "work_j",
]
