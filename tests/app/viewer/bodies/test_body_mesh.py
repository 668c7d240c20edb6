"""The figure: closed surfaces, outward, of the right size, left and right mirrored, no gaps at the joints."""

import numpy as np
import pytest

from app.viewer.figure.body_mesh import MATERIALS, Piece, build_figure
from app.viewer.figure.proportions import hip_height_m, leg_lengths_m, neck_height_m
from app.viewer.pose import PARENT
from estimators.body import BodyDimensions, body_from_stature

SMALL = BodyDimensions(
    stature_m=1.20, upper_arm_m=0.21, forearm_m=0.17, hand_m=0.13, shoulder_width_m=0.25, trunk_m=0.35
)
BODIES = [BodyDimensions(), SMALL, body_from_stature(1.95)]


@pytest.fixture(params=BODIES, ids=["default", "child", "tall"])
def body(request: pytest.FixtureRequest) -> BodyDimensions:
    """Three people."""
    dimensions: BodyDimensions = request.param
    return dimensions


def piece(body: BodyDimensions, segment: str, material: str) -> Piece:
    """Pick one piece."""
    return next(p for p in build_figure(body) if (p.segment, p.material) == (segment, material))


def test_every_surface_is_closed_and_faces_outward(body: BodyDimensions) -> None:
    """Each directed edge has its reverse equally often, and the volume is positive."""
    for part in build_figure(body):
        faces = part.mesh.faces.astype(np.int64)
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        forward = np.sort(edges[:, 0] * 10**7 + edges[:, 1])
        backward = np.sort(edges[:, 1] * 10**7 + edges[:, 0])
        assert np.array_equal(forward, backward), (part.segment, part.material)
        assert part.mesh.volume_m3 > 0.0, (part.segment, part.material)
        assert np.isfinite(part.mesh.vertices_m).all()


def test_normals_point_away_from_the_bone(body: BodyDimensions) -> None:
    """On a limb nearly every face looks away from the axis through its joints; ends and dents are few."""
    for segment, material in (
        ("forearm_right", "skin"),
        ("thigh_left", "trousers"),
        ("upper_arm_left", "skin"),
    ):
        mesh = piece(body, segment, material).mesh
        a, b, c = (mesh.vertices_m[mesh.faces[:, i]] for i in range(3))
        normal, middle = np.cross(b - a, c - a), (a + b + c) / 3.0
        along = np.einsum("ni,ni->n", normal[:, :2], middle[:, :2])
        assert (along > 0).mean() > 0.97


def test_left_is_right_in_a_mirror(body: BodyDimensions) -> None:
    """Same triangles, y negated."""
    for part in build_figure(body):
        if not part.segment.endswith("_left"):
            continue
        if part.material == "band":
            continue
        other = piece(body, part.segment.replace("left", "right"), part.material)
        np.testing.assert_array_equal(
            other.mesh.vertices_m, part.mesh.vertices_m * np.array([1, -1, 1], np.float32)
        )
        assert other.mesh.volume_m3 == pytest.approx(part.mesh.volume_m3, rel=1e-5)


def test_sizes_follow_the_dimensions(body: BodyDimensions) -> None:
    """Crown at stature, soles on the floor, arms and hands as long as measured (within one grid cell)."""
    cell = 0.02
    head = piece(body, "head", "hair").mesh.vertices_m
    assert hip_height_m(body) + neck_height_m(body) + head[:, 2].max() == pytest.approx(
        body.stature_m, abs=cell
    )
    thigh, shank, _ = leg_lengths_m(body)
    sole = hip_height_m(body) - thigh - shank + piece(body, "foot_left", "shoe").mesh.vertices_m[:, 2].min()
    assert sole == pytest.approx(0.0, abs=0.004)
    hand = piece(body, "hand_right", "skin").mesh.vertices_m
    assert -hand[:, 2].min() == pytest.approx(body.hand_m, abs=0.06 * body.hand_m)
    for segment, length in (("upper_arm_right", body.upper_arm_m), ("forearm_right", body.forearm_m)):
        low = -piece(body, segment, "skin").mesh.vertices_m[:, 2].min()
        assert length < low < length + 0.05


def test_palm_is_flat_and_the_thumb_points_outward(body: BodyDimensions) -> None:
    """With palms forward the thumbs are lateral: that is how turning the forearm is seen."""
    left = piece(body, "hand_left", "skin").mesh.vertices_m
    assert left[:, 1].max() > 1.5 * -left[:, 1].min()
    palm = left[(left[:, 2] > -0.50 * body.hand_m) & (left[:, 2] < -0.30 * body.hand_m)]
    assert np.ptp(palm[:, 1]) > 2.0 * np.ptp(palm[palm[:, 1] < 0][:, 0])


@pytest.mark.parametrize(
    ("upper", "lower", "length"), [("upper_arm", "forearm", "upper_arm_m"), ("forearm", "hand", "forearm_m")]
)
def test_no_gap_at_a_bent_joint(body: BodyDimensions, upper: str, lower: str, length: str) -> None:
    """Around the joint both pieces reach past it, so bending opens no gap."""
    joint = np.array([0.0, 0.0, -getattr(body, length)])
    above = piece(body, f"{upper}_left", "skin").mesh.vertices_m - joint
    below = piece(body, f"{lower}_left", "skin").mesh.vertices_m
    overlap_above = -above[:, 2].min()
    overlap_below = below[:, 2].max()
    least = 0.012 * body.stature_m / 1.70
    assert overlap_above > least
    assert overlap_below > least


def test_pieces_belong_to_known_segments_and_materials() -> None:
    """Everything can be coloured and hung on a frame."""
    pieces = build_figure(BodyDimensions())
    assert {p.segment for p in pieces} == set(PARENT)
    assert {p.material for p in pieces} == set(MATERIALS)
    size = sum(p.mesh.vertices_m.nbytes + p.mesh.faces.nbytes for p in pieces)
    assert size < 1_500_000  # what a phone must fetch before it sees anything
