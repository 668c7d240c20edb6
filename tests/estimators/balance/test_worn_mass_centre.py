"""Centre of mass from worn sensors: against closed forms, its plain twin, and drawn errors."""

import numpy as np
import pytest

from estimators import rotation
from estimators.balance import BodySegments, WornBodyParameters, WornMassCentre, has_mass_centre
from estimators.balance.mass_centre._segments import PAIRED, SEGMENTS
from estimators.balance.published import body_segments, mean_segments, segmental_mass_centre
from estimators.body import BodyDimensions
from estimators.conventions import PLACEMENTS
from estimators.errors import SetupError, ShapeError

LEGS = ("thigh_left", "thigh_right", "shank_left", "shank_right")
BODY = BodyDimensions(stature_m=1.82, upper_arm_m=0.31, forearm_m=0.27, trunk_m=0.53)


def poses(ticks, seed=0, most_rad=1.0):
    rng = np.random.default_rng(seed)
    return rotation.exp(most_rad * rng.uniform(-1, 1, (ticks, len(PLACEMENTS), 3)))


@pytest.mark.parametrize(
    "worn",
    [
        PLACEMENTS,
        ("sternum", *LEGS),
        ("pelvis", "thigh_right", "thigh_left"),
        (*LEGS, "head", "pelvis", "hand_left"),
    ],
)
def test_it_equals_the_chain_of_the_whole_body(worn):
    q = poses(40)[:, [PLACEMENTS.index(name) for name in worn]]
    segments = body_segments("woman", {"shank_left": 0.03})
    model = WornMassCentre(worn, BODY, segments)
    found = model.evaluate(q)
    twin = segmental_mass_centre({name: q[:, i] for i, name in enumerate(worn)}, segments, BODY)
    assert model.assumed == twin.assumed
    np.testing.assert_allclose(found.from_hip_m, twin.position_m - twin.joints_m["hip"], atol=1e-12)
    np.testing.assert_allclose(found.scalar[:, 2], twin.position_m[:, 2], atol=1e-12)
    ankles = 0.5 * (twin.joints_m["ankle_left"] + twin.joints_m["ankle_right"])
    facing = rotation.rotate(
        q[:, worn.index("pelvis" if "pelvis" in worn else "sternum")], np.array([1.0, 0, 0])
    )[:, :2]
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    away = (twin.position_m - ankles)[:, :2]
    np.testing.assert_allclose(found.scalar[:, 0], np.sum(facing * away, axis=1), atol=1e-12)
    left = np.stack([-facing[:, 1], facing[:, 0]], axis=1)
    np.testing.assert_allclose(found.scalar[:, 1], np.sum(left * away, axis=1), atol=1e-12)


def test_a_posed_body_has_the_centre_that_a_ruler_gives():
    # All mass in the thighs, the trunk and the shanks in parts that can be added by hand.
    share = dict.fromkeys(SEGMENTS, 0.0) | {"upper_trunk": 0.5, "thigh": 0.2, "shank": 0.05}
    segments = BodySegments(share, dict.fromkeys(SEGMENTS, 0.5), (1.0, 0.0, 0.0))
    body = BodyDimensions(stature_m=2.0, trunk_m=0.6)
    worn = ("pelvis", "sternum", *LEGS)
    level = rotation.about_y(-np.pi / 2)  # the knee forward: hangs along -z, so -z turns to x
    q = np.tile(rotation.identity(), (3, len(worn), 1))
    q[1, [2, 3]] = level  # sitting
    q[2, 1] = rotation.about_y(
        np.pi / 2
    )  # bowing, hips still upright: trunk_share puts all of it into the thorax
    model = WornMassCentre(worn, body, segments)
    found = model.evaluate(q)
    thigh, shank, ankle = 0.49, 0.492, 0.078
    hip = thigh + shank + ankle
    standing = 0.5 * (hip + 0.3) + 0.4 * (hip - thigh / 2) + 0.1 * (hip - thigh - shank / 2)
    low = shank + ankle
    sitting = 0.5 * (low + 0.3) + 0.4 * low + 0.1 * (low - shank / 2)
    bowing = 0.5 * hip + 0.4 * (hip - thigh / 2) + 0.1 * (hip - thigh - shank / 2)
    np.testing.assert_allclose(found.scalar[:, 2], [standing, sitting, bowing], atol=1e-12)
    # Sitting, the ankles are a thigh's length ahead of the hips.
    np.testing.assert_allclose(
        found.scalar[:, 0], [0.0, 0.4 * thigh / 2 + 0.1 * thigh - thigh, 0.5 * 0.3], atol=1e-12
    )
    np.testing.assert_allclose(found.scalar[:, 1], 0.0, atol=1e-12)


def test_sigma_is_the_spread_of_drawn_errors():
    rng = np.random.default_rng(8)
    worn, draws = ("sternum", "pelvis", "upper_arm_left", *LEGS), 20_000
    q = poses(1, seed=3, most_rad=0.7)[:, [PLACEMENTS.index(name) for name in worn]]
    sigma = rng.uniform(0.01, 0.06, (1, len(worn), 3))
    parameters = WornBodyParameters(lever_share=1e-9)
    said = WornMassCentre(worn, BODY, parameters=parameters).evaluate(q, sigma).scalar[0, 3:]
    # Sensors err about the room's axes; what has none is turned against what it moves with.
    every = rotation.multiply(rotation.exp(sigma * rng.normal(size=(draws, len(worn), 3))), q)
    given = {name: every[:, i] for i, name in enumerate(worn)}
    for name, stand_in, part in (
        ("head", "sternum", "head"),
        ("shoulder_left", "sternum", "shoulder"),
        ("shoulder_right", "sternum", "shoulder"),
        ("upper_arm_right", "sternum", "upper_arm"),
        ("forearm_left", "upper_arm_left", "forearm"),
        ("forearm_right", "upper_arm_right", "forearm"),
        ("hand_left", "forearm_left", "hand"),
        ("hand_right", "forearm_right", "hand"),
    ):
        turn = parameters.assumed_rad[part] * rng.normal(size=(draws, 3))
        given[name] = rotation.multiply(given[stand_in], rotation.exp(turn))
    twin = segmental_mass_centre(given, mean_segments(), BODY)
    ankles = 0.5 * (twin.joints_m["ankle_left"] + twin.joints_m["ankle_right"])
    facing = rotation.rotate(q[0, 1], np.array([1.0, 0, 0]))[:2]
    c, s = facing / np.linalg.norm(facing)
    away = (twin.position_m - ankles) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    drawn = np.array([away[:, 0].std(), away[:, 1].std(), twin.position_m[:, 2].std()])
    # To first order: an arm that may be turned by half a radian has a second.
    np.testing.assert_allclose(said, drawn, rtol=0.12)


def test_more_sensors_say_more():
    few = WornMassCentre(("sternum", "thigh_left", "thigh_right"), BODY)
    some = WornMassCentre(("sternum", *LEGS), BODY)
    all_of_them = WornMassCentre(PLACEMENTS, BODY)
    sigmas = []
    for model in (few, some, all_of_them):
        count = len(model.placements)
        q = np.tile(rotation.identity(), (1, count, 1))
        sigmas.append(model.evaluate(q, np.full((1, count, 3), 0.02)).scalar[0, 3:])
    assert (sigmas[0][:2] > sigmas[1][:2]).all()
    assert (sigmas[1][:2] > sigmas[2][:2]).all()
    assert 0.003 < sigmas[2].max() < 0.03
    assert all_of_them.assumed == ()
    assert few.assumed == tuple(name for name in PLACEMENTS if name not in few.placements)


def test_unknown_orientations_give_unknown_places():
    model = WornMassCentre(("sternum", *LEGS))
    q = np.tile(rotation.identity(), (2, 5, 1))
    q[1, 2] = np.nan
    found = model.evaluate(q)
    assert np.isfinite(found.scalar[0, :3]).all()
    assert np.isnan(found.scalar[0, 3:]).all()
    assert np.isnan(found.scalar[1]).all()


def test_what_cannot_work_is_said():
    assert not has_mass_centre(("sternum", "upper_arm_left"))
    assert not has_mass_centre(LEGS)
    assert has_mass_centre(("sternum", "thigh_right", "thigh_left"))
    with pytest.raises(SetupError, match="both thighs"):
        WornMassCentre(("sternum", "thigh_left"))
    with pytest.raises(SetupError, match="different ones"):
        WornMassCentre(("sternum", "sternum", "thigh_left", "thigh_right"))
    with pytest.raises(ShapeError):
        WornMassCentre(("sternum", *LEGS)).evaluate(np.zeros((4, 3, 4)))


def test_the_mean_table_makes_one_body():
    segments = mean_segments()
    assert sum(segments.masses().values()) == pytest.approx(1.0, abs=1e-12)
    assert sum(segments.trunk_share) == pytest.approx(1.0, abs=1e-12)
    woman, man = body_segments("woman"), body_segments("man")
    for name in (*SEGMENTS, *PAIRED):
        low, high = sorted((woman.centre_share[name], man.centre_share[name]))
        assert low <= segments.centre_share[name] <= high
