"""Alternative joint-angle sequences: scipy as judge, the ISB angles as anchor, clinical signs, singularities."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.arm import frames_in_sequence, segments_from_angles, sequence_names
from estimators.arm.published import (
    JOINTS,
    SEQUENCES,
    SINGULAR_MARGIN_RAD,
    STANDARD_SEQUENCE,
    angles_in_sequence,
    elbow_angles,
    elbow_from_angles,
    mirrored,
    shoulder_angles,
    shoulder_from_angles,
    singular_distances,
    wrist_angles,
)
from estimators.errors import SetupError, ShapeError

TO_ISB = Rotation.from_matrix([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
"""Our axes (x forward, y left, z up) to the ISB's (X forward, Y up, Z right)."""
SIGN = {
    "thorax_humerus": {"x": -1, "y": 1, "z": 1},
    "humerus_forearm": {"x": -1, "y": 1, "z": 1},
    "forearm_hand": {"x": 1, "y": 1, "z": 1},
}


def allowed(joint):
    return [s for s in SEQUENCES if s != "yxy" or joint == "thorax_humerus"]


CASES = [(joint, sequence) for joint in JOINTS for sequence in allowed(joint)]


@pytest.fixture
def random_rotations():
    return rotation.normalize(np.random.default_rng(60).normal(size=(3000, 4)))


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("joint", "sequence"), CASES)
def test_angles_rebuild_the_rotation_about_the_isb_axes(random_rotations, joint, sequence, side):
    found = angles_in_sequence(random_rotations, joint, side, sequence)
    turned = found.angle_rad * [SIGN[joint][axis] for axis in sequence]
    rebuilt = TO_ISB.inv() * Rotation.from_euler(sequence.upper(), turned) * TO_ISB
    given = rotation.to_scipy(mirrored(random_rotations) if side == "left" else random_rotations)
    # Matrices to angles loses half the digits near a pole of the middle angle: 1e-8.
    assert (rebuilt.inv() * given).magnitude().max() < 1e-7
    if sequence != "yxy":
        np.testing.assert_allclose(
            turned, (TO_ISB * given * TO_ISB.inv()).as_euler(sequence.upper()), atol=1e-7
        )


@pytest.mark.parametrize("side", ["left", "right"])
def test_standard_sequences_are_the_stored_angles(random_rotations, side):
    for joint, angles in (
        ("thorax_humerus", shoulder_angles),
        ("humerus_forearm", elbow_angles),
        ("forearm_hand", wrist_angles),
    ):
        found = angles_in_sequence(random_rotations, joint, side)
        expected = angles(random_rotations, side)
        np.testing.assert_allclose(np.sin(0.5 * (found.angle_rad - expected)), 0.0, atol=1e-7)
        assert found.names[0].startswith(f"{joint}_{side}_{STANDARD_SEQUENCE[joint]}_")
    assert sequence_names("thorax_humerus", "right", "yxy")[1] == "thorax_humerus_right_yxy_elevation"


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("sequence", ["xzy", "zxy", "xyz", "zyx", "yxz", "yzx"])
def test_clinical_movements_have_clinical_signs(sequence, side):
    """One movement at a time: 40 degrees of it come out as 40 of the angle of that name and nothing else."""
    forty, quarter = np.radians(40), np.pi / 2
    movements = {
        "abduction": shoulder_from_angles(0.0, forty, 0.0, side),
        "flexion": shoulder_from_angles(quarter, forty, -quarter, side),
        "internal_rotation": shoulder_from_angles(0.0, 0.0, forty, side),
    }
    for meaning, q in movements.items():
        found = angles_in_sequence(q, "thorax_humerus", side, sequence)
        expected = [40.0 * name.endswith(meaning) for name in found.names]
        np.testing.assert_allclose(np.degrees(found.angle_rad), expected, atol=1e-9, err_msg=meaning)
    bent = angles_in_sequence(elbow_from_angles(forty, 0.0, 0.0, side), "humerus_forearm", side, sequence)
    assert np.degrees(bent.angle_rad[sequence.index("z")]) == pytest.approx(40)
    assert bent.names[sequence.index("y")] == f"humerus_forearm_{side}_{sequence}_pronation"


def test_a_hanging_arm_is_singular_in_yxy_and_not_in_the_others():
    hanging = shoulder_from_angles(0.5, np.radians(2.0), -0.2, "right")
    standard = angles_in_sequence(hanging, "thorax_humerus", "right")
    assert standard.is_singular
    assert np.degrees(standard.singular_distance_rad) == pytest.approx(2.0)
    for sequence in ("xzy", "zxy"):
        other = angles_in_sequence(hanging, "thorax_humerus", "right", sequence)
        assert not other.is_singular
        assert np.degrees(other.singular_distance_rad) > 85
    # Raised to the side X-Z-Y is sound and Z-X-Y is singular; raised to the front the other way round.
    side, front = (
        shoulder_from_angles(0, np.pi / 2, 0, "left"),
        shoulder_from_angles(np.pi / 2, np.pi / 2, 0, "left"),
    )
    for q, sound, singular in ((side, "xzy", "zxy"), (front, "zxy", "xzy")):
        assert not angles_in_sequence(q, "thorax_humerus", "left", sound).is_singular
        assert angles_in_sequence(q, "thorax_humerus", "left", singular).is_singular


@pytest.mark.parametrize(("joint", "sequence"), CASES)
def test_the_distance_is_the_smallest_turn_to_the_singularity(joint, sequence):
    """Turning the child by less, in any of many directions, never arrives; by just that, in one direction, it does."""
    rng = np.random.default_rng(61)
    q = rotation.normalize(rng.normal(size=4))
    found = angles_in_sequence(q, joint, "right", sequence)
    distance = float(found.singular_distance_rad)
    directions = rng.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    short = rotation.multiply(rotation.exp(0.9 * distance * directions), q)
    assert (
        angles_in_sequence(short, joint, "right", sequence).singular_distance_rad.min() >= 0.0999 * distance
    )
    full = rotation.multiply(rotation.exp(distance * directions), q)
    # 4000 directions over the sphere: the best lies within some 3 degrees of the right one.
    assert angles_in_sequence(full, joint, "right", sequence).singular_distance_rad.min() < 0.1 * max(
        distance, 0.1
    )


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_at_the_singularity_itself_the_angles_still_rebuild_the_rotation(sequence):
    middle = 0.0 if sequence == "yxy" else np.pi / 2
    exact = Rotation.from_euler(sequence.upper(), [0.4, middle, 0.9])
    q = rotation.from_scipy(TO_ISB.inv() * exact * TO_ISB)
    found = angles_in_sequence(q, "thorax_humerus", "right", sequence)
    turned = found.angle_rad * [SIGN["thorax_humerus"][axis] for axis in sequence]
    rebuilt = Rotation.from_euler(sequence.upper(), turned)
    assert (rebuilt.inv() * exact).magnitude() < 1e-7
    assert found.is_singular


def test_stored_frames_give_curves_without_jumps():
    ticks = 400
    turning = np.linspace(0, 3.5 * np.pi, ticks)
    posture = {
        "thorax_humerus_left_yxy_plane_of_elevation": np.full(ticks, 0.7),
        "thorax_humerus_left_yxy_elevation": np.full(ticks, 0.3),
        "thorax_humerus_left_yxy_axial_rotation": turning,
        "trunk_lean_forward_rad": np.linspace(0, 0.5, ticks),
    }
    segments = segments_from_angles(posture, ("left",))
    names = ("sternum", "upper_arm_left", "forearm_left", "hand_left")
    q = np.stack([segments[name] for name in names], axis=1)
    q[50:60, 1] = np.nan
    found = frames_in_sequence(q, names, "thorax_humerus", "left", "xzy")
    assert np.isnan(found.angle_rad[50:60]).all()
    seen = found.angle_rad[np.isfinite(found.angle_rad[:, 0])]
    assert np.abs(np.diff(seen, axis=0)).max() < 0.4
    assert np.ptp(seen[:, 2]) > 3 * np.pi
    assert not found.is_singular[50:60].any()
    distances = singular_distances(q, names)
    assert set(distances) == {"thorax_humerus_left", "humerus_forearm_left", "forearm_hand_left"}
    np.testing.assert_allclose(distances["thorax_humerus_left"][:50], 0.3, atol=1e-9)
    assert distances["thorax_humerus_left"][0] > SINGULAR_MARGIN_RAD
    # Without a sternum sensor the thorax is upright.
    alone = frames_in_sequence(q[:, 1:], names[1:], "thorax_humerus", "left", "xzy")
    assert np.abs(alone.angle_rad[0] - found.angle_rad[0]).max() < 1e-12


def test_what_cannot_be_told_is_refused_in_words(random_rotations):
    with pytest.raises(SetupError, match="no sequence"):
        angles_in_sequence(random_rotations, "thorax_humerus", "left", "yzy")
    with pytest.raises(SetupError, match="for the shoulder"):
        angles_in_sequence(random_rotations, "humerus_forearm", "left", "yxy")
    with pytest.raises(SetupError, match="no joint"):
        angles_in_sequence(random_rotations, "knee", "left")
    with pytest.raises(SetupError, match="no joint"):
        frames_in_sequence(np.zeros((2, 1, 4)), ("sternum",), "knee", "left")
    with pytest.raises(ShapeError, match="no forearm_left and no hand_left"):
        frames_in_sequence(np.zeros((2, 1, 4)), ("sternum",), "forearm_hand", "left")
    with pytest.raises(ShapeError, match="1 segments"):
        frames_in_sequence(np.zeros((2, 3, 4)), ("sternum",), "forearm_hand", "left")
