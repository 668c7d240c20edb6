"""Joint angles in any sequence, and how far a joint is from the singularity of its sequence.

The stored angles follow the ISB (`_joint_angles`). Their shoulder sequence, Y-X-Y, is singular where the arm
hangs; a Cardan sequence such as X-Z-Y or Z-X-Y is not, at the price of another singularity with the arm raised
sideways or forward. Everything here is a pure function of stored orientations.

About the ISB axes (X forward, Y up, Z to the right, left sides mirrored) each joint turns with these signs:

=================  ==============================  ==================  =================================
joint              X                               Y                   Z
=================  ==============================  ==================  =================================
thorax to humerus  - is abduction                  + internal          + is flexion
humerus, forearm   - is carrying (valgus)          + is pronation      + is flexion
forearm to hand    + toward the little finger      + as in pronation   + is flexion (toward the palm)
=================  ==============================  ==================  =================================
"""

from typing import Final, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.arm._angle_kernel import SINGULAR_MARGIN_RAD
from estimators.arm._joint_angles import mirrored
from estimators.arm._names import Joint
from estimators.conventions import SIDES, Side
from estimators.errors import SetupError, ShapeError

Float = NDArray[np.float64]
Sequence = Literal["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "yxy"]

JOINTS: Final[tuple[Joint, ...]] = get_args(Joint)
SEQUENCES: Final[tuple[Sequence, ...]] = get_args(Sequence)
STANDARD_SEQUENCE: Final[dict[Joint, Sequence]] = {
    "thorax_humerus": "yxy",
    "humerus_forearm": "zxy",
    "forearm_hand": "zxy",
}
"""What the ISB recommends and the pipelines store. `yxy` is for the shoulder alone."""

_MEANING: Final[dict[Joint, dict[str, tuple[str, float]]]] = {
    "thorax_humerus": {"x": ("abduction", -1.0), "y": ("internal_rotation", 1.0), "z": ("flexion", 1.0)},
    "humerus_forearm": {"x": ("carrying", -1.0), "y": ("pronation", 1.0), "z": ("flexion", 1.0)},
    "forearm_hand": {"x": ("deviation", 1.0), "y": ("rotation", 1.0), "z": ("flexion", 1.0)},
}
# ISB X, Y, Z in our axes: x, z, -y.
_ISB_FROM_OURS: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
PARENT_CHILD: Final[dict[Joint, tuple[str, str]]] = {
    "thorax_humerus": ("sternum", "upper_arm_{side}"),
    "humerus_forearm": ("upper_arm_{side}", "forearm_{side}"),
    "forearm_hand": ("forearm_{side}", "hand_{side}"),
}
"""Segments of each joint; without a sternum sensor the thorax is taken as upright."""


class SequenceAngles(NamedTuple):
    """One joint in one sequence.

    Attributes
    ----------
    names : tuple of str
        Column names, joint, side, sequence and meaning, in the order of the sequence.
    angle_rad : ndarray, shape (..., 3)
    singular_distance_rad : ndarray, shape (...)
        The smallest turn of the child that makes first and last angle inseparable.
    is_singular : ndarray of bool, shape (...)
        Nearer than 10 degrees: an orientation error comes out more than fivefold.
    """

    names: tuple[str, str, str]
    angle_rad: Float
    singular_distance_rad: Float
    is_singular: NDArray[np.bool_]


def sequence_names(joint: Joint, side: Side, sequence: Sequence) -> tuple[str, str, str]:
    """Return the column names of a joint in a sequence, e.g. `thorax_humerus_left_xzy_abduction`."""
    _check(joint, sequence)
    parts = ["plane_of_elevation", "elevation", "axial_rotation"]
    if sequence != "yxy":
        parts = [_MEANING[joint][axis][0] for axis in sequence]
    first, second, third = (f"{joint}_{side}_{sequence}_{part}" for part in parts)
    return first, second, third


def angles_in_sequence(
    q_parent_child: ArrayLike,
    joint: Joint,
    side: Side,
    sequence: Sequence | None = None,
    *,
    continuous: bool = False,
) -> SequenceAngles:
    """Return a joint's angles in a sequence.

    Parameters
    ----------
    q_parent_child : array_like, shape (..., 4)
        For instance `q_thorax_humerus`; NaN gives NaN.
    sequence : Sequence, optional
        About the ISB axes, each turned with the one before; the standard one of the joint by default.
    continuous : bool
        Unwrap along the first axis, consecutive ticks; jumps remain where the sequence is singular.

    Returns
    -------
    SequenceAngles
        All angles are zero in the anatomical position. Middle angle of three different axes within
        +-90 degrees; elevation 0 to 180 degrees.

    Raises
    ------
    SetupError
        For an unknown joint or sequence.

    Notes
    -----
    The last angle is found from what the first leaves, so that the three always rebuild the rotation, at a
    singularity too.
    """
    chosen = STANDARD_SEQUENCE.get(joint, "yxy") if sequence is None else sequence
    names = sequence_names(joint, side, chosen)
    q = np.asarray(q_parent_child, dtype=np.float64)
    ours = rotation.to_matrix(mirrored(q) if side == "left" else q)
    m = _ISB_FROM_OURS @ ours @ _ISB_FROM_OURS.T
    first_axis, second_axis, last_axis = ("xyz".index(axis) for axis in chosen)
    signs = np.array([_MEANING[joint][axis][1] for axis in chosen])
    if first_axis != last_axis:
        angle = _cardan(m, first_axis, second_axis, last_axis) * signs
        distance = 0.5 * np.pi - np.abs(angle[..., 1])
    else:
        # Elevation counts as positive: a turn with a negative sign about the middle axis has its other branch.
        angle = _euler(m, first_axis, second_axis, signs[1]) * signs
        distance = np.minimum(angle[..., 1], np.pi - angle[..., 1])
    if continuous:
        angle = _unwrapped(angle)
    with np.errstate(invalid="ignore"):
        is_singular = distance < SINGULAR_MARGIN_RAD
    return SequenceAngles(names, angle, np.asarray(distance), np.asarray(is_singular))


def _check(joint: Joint, sequence: Sequence) -> None:
    if joint not in JOINTS:
        raise SetupError(f"no joint {joint!r}; known are {', '.join(JOINTS)}")
    if sequence not in SEQUENCES:
        raise SetupError(f"no sequence {sequence!r}; known are {', '.join(SEQUENCES)}")
    if sequence == "yxy" and joint != "thorax_humerus":
        raise SetupError(f"the sequence yxy is for the shoulder; {joint} takes three different axes")


def _parity(i: int, j: int) -> float:
    return 1.0 if (j - i) % 3 == 1 else -1.0


def _cardan(m: Float, i: int, j: int, k: int) -> Float:
    """Angles of R = Ri(a) Rj(b) Rk(c), three different axes."""
    e = _parity(i, j)
    a = np.arctan2(-e * m[..., j, k], m[..., k, k])
    b = np.arctan2(e * m[..., i, k], np.hypot(m[..., i, i], m[..., i, j]))
    return np.stack((a, b, _last(m, a, i, j, k, e)), axis=-1)


def _euler(m: Float, i: int, j: int, sign: float) -> Float:
    """Angles of R = Ri(a) Rj(b) Ri(c) with `sign * b` not negative."""
    k, e = 3 - i - j, _parity(i, j)
    a = np.arctan2(sign * m[..., j, i], -e * sign * m[..., k, i])
    b = sign * np.arctan2(np.hypot(m[..., j, i], m[..., k, i]), m[..., i, i])
    # What the first angle leaves, Rj(b) Ri(c), has (0, cos c, -e sin c) in row j, columns i, j, k.
    row = _row_after(m, a, i, j, e)
    c = np.arctan2(-e * row[..., k], row[..., j])
    return np.stack((a, b, c), axis=-1)


def _last(m: Float, a: Float, i: int, j: int, k: int, e: float) -> Float:
    # Rj(b) Rk(c) has (e sin c, cos c, 0) in row j, columns i, j, k.
    row = _row_after(m, a, i, j, e)
    return np.asarray(np.arctan2(e * row[..., i], row[..., j]))


def _row_after(m: Float, a: Float, i: int, j: int, e: float) -> Float:
    """Row j of Ri(-a) R: cos(a) of row j and, by the sense of the axes, sin(a) of row k."""
    k = 3 - i - j
    return np.asarray(np.cos(a)[..., None] * m[..., j, :] + e * np.sin(a)[..., None] * m[..., k, :])


def _unwrapped(angle_rad: Float) -> Float:
    """Unwrap first and last angle along axis 0, leaving gaps as they are."""
    result = np.array(angle_rad)
    flat = result.reshape(result.shape[0], int(np.prod(result.shape[1:-1])), 3)
    for column in range(flat.shape[1]):
        seen = np.isfinite(flat[:, column, 0])
        flat[seen, column, 0] = np.unwrap(flat[seen, column, 0])
        flat[seen, column, 2] = np.unwrap(flat[seen, column, 2])
    return result


def frames_in_sequence(
    q_room_segment: ArrayLike,
    segments: tuple[str, ...],
    joint: Joint,
    side: Side,
    sequence: Sequence | None = None,
) -> SequenceAngles:
    """Return a joint of stored frames in a sequence, unwrapped in time.

    Parameters
    ----------
    q_room_segment : array_like, shape (K, G, 4)
        `Frames.q_room_segment`.
    segments : tuple of str
        `Frames.layout.segments`, the G columns.
    joint, side, sequence
        As `angles_in_sequence`.

    Returns
    -------
    SequenceAngles
        Of K ticks.

    Raises
    ------
    ShapeError
        If the segments of the joint were not worn or the columns do not fit.
    """
    q = np.asarray(q_room_segment, dtype=np.float64)
    if q.ndim != 3 or q.shape[1:] != (len(segments), 4):
        raise ShapeError(
            f"orientations have shape {q.shape}; {len(segments)} segments need (ticks, {len(segments)}, 4)"
        )
    _check(joint, sequence or STANDARD_SEQUENCE.get(joint, "yxy"))
    parent, child = (name.format(side=side) for name in PARENT_CHILD[joint])
    missing = [name for name in (parent, child) if name not in segments and name != "sternum"]
    if missing:
        raise ShapeError(f"these frames have no {' and no '.join(missing)}; {joint} cannot be determined")
    q_child = q[:, segments.index(child)]
    if parent in segments:
        q_child = rotation.multiply(rotation.conjugate(q[:, segments.index(parent)]), q_child)
    return angles_in_sequence(q_child, joint, side, sequence, continuous=True)


def singular_distances(q_room_segment: ArrayLike, segments: tuple[str, ...]) -> dict[str, Float]:
    """Return how far every joint of stored frames is from the singularity of its standard sequence.

    Parameters
    ----------
    q_room_segment : array_like, shape (K, G, 4)
    segments : tuple of str
        As `frames_in_sequence`.

    Returns
    -------
    dict of str to ndarray, shape (K,)
        `thorax_humerus_right` and so on, radians: the smallest turn of the child segment that would make first
        and last angle inseparable. Shoulder: elevation from 0 or 180 degrees; elbow: carrying from +-90; wrist:
        deviation from +-90. An orientation error is magnified by 1/sin of it.
    """
    found = {}
    for side in SIDES:
        for joint in JOINTS:
            parent, child = (name.format(side=side) for name in PARENT_CHILD[joint])
            if child in segments and (parent in segments or parent == "sternum"):
                angles = frames_in_sequence(q_room_segment, segments, joint, side)
                found[f"{joint}_{side}"] = angles.singular_distance_rad
    return found
