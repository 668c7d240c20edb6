"""Names, order and signs of the angles of the leg; the kernel and its twin share them."""

from typing import Final, Literal, NamedTuple

from estimators.conventions import SIDES

LegJoint = Literal["pelvis_thigh", "thigh_shank", "shank_foot"]


class Joint(NamedTuple):
    """One joint of the leg.

    Attributes
    ----------
    parent, child : str
        Segments, `{side}` where they have one.
    parts : tuple of str
        Sequence and meaning of its three angles.
    signs : tuple of float
        Of the first two angles against R = Ry(forward) Rx(across) Rz(turn) about our axes, right leg; the third is the
        turn.
    """

    parent: str
    child: str
    parts: tuple[str, str, str]
    signs: tuple[float, float]


JOINTS: Final[dict[LegJoint, Joint]] = {
    "pelvis_thigh": Joint(
        "pelvis", "thigh_{side}", ("zxy_flexion", "zxy_abduction", "zxy_internal_rotation"), (-1.0, -1.0)
    ),
    "thigh_shank": Joint(
        "thigh_{side}", "shank_{side}", ("zxy_flexion", "zxy_abduction", "zxy_internal_rotation"), (1.0, -1.0)
    ),
    "shank_foot": Joint(
        "shank_{side}", "foot_{side}", ("zxy_flexion", "zxy_inversion", "zxy_internal_rotation"), (-1.0, 1.0)
    ),
}

LEG_ANGLES: Final[tuple[str, ...]] = tuple(
    f"{name}_{side}_{part}" for side in SIDES for name, joint in JOINTS.items() for part in joint.parts
)
"""Column names of all angles that a leg has, three a joint."""


def lower_segment(angle: str) -> str:
    """Return the segment below the joint of a leg's angle, without its side: `shank` of a knee's; empty for others."""
    joint = next((joint for name, joint in JOINTS.items() if angle.startswith(f"{name}_")), None)
    return "" if joint is None else joint.child.removesuffix("_{side}")
