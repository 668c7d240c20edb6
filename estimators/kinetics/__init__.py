"""Forces under the foot and what they ask of its joints, from an instrumented shoe.

::

    shoe = analyse_shoe(recording.sensors["heel_left"], recording.sensors["forefoot_left"])
    shoe.reaction.cop_m, shoe.reaction.force_n
"""

from estimators.kinetics._analysis import ShoeKinetics, ShoeParameters, analyse_shoe
from estimators.kinetics._contact import ContactParameters, ShoeContact, stretches
from estimators.kinetics._cycles import ForcePeaks, force_peaks
from estimators.kinetics._ground_reaction import LEAST_LOAD_N, GroundReaction, ShoeLoads, ground_reaction
from estimators.kinetics._joint_loads import FootSegment, JointLoad
from estimators.kinetics._load_cell import LoadCellCalibration, clipped_at
from estimators.kinetics._shoe_geometry import ShoeGeometry
from estimators.kinetics._shoe_pose import ShoePose

__all__ = [
    "LEAST_LOAD_N",
    "ContactParameters",
    "FootSegment",
    "ForcePeaks",
    "GroundReaction",
    "JointLoad",
    "LoadCellCalibration",
    "ShoeContact",
    "ShoeGeometry",
    "ShoeKinetics",
    "ShoeLoads",
    "ShoeParameters",
    "ShoePose",
    "analyse_shoe",
    "clipped_at",
    "force_peaks",
    "ground_reaction",
    "stretches",
]
