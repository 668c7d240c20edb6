"""Source and sensors of a magnetic session in the 3D view."""

from dataclasses import replace

import numpy as np
import pytest
import viser

from app.viewer.layers.modules import ModuleTrack, distance_words, modules_of
from app.viewer.pose import is_posed, thinned, track_from_frames
from app.viewer.scene import BodyScene
from estimators import pipelines, rotation
from estimators.body import BodyDimensions
from estimators.magnetic import perpendicular_source
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import ImuChunk
from estimators.simulation.coils import fire_bursts, relative_motion, relative_scene


@pytest.fixture(scope="module")
def frames() -> Frames:
    """Eight seconds with a source that fires bursts by itself."""
    scene = relative_scene(perpendicular_source(0.06), relative_motion("flexion", 8.0, 1), 8.0, seed=1)
    field, coil = fire_bursts(scene, 1.3, first_s=2.2, pulse_s=0.08, slot_s=0.2, cycle_s=1.0)[:2]
    state = np.zeros((2, len(field)))
    state[0] = np.where(coil > 0, coil + 0.13, 0.0)
    chunk = ImuChunk(
        0,
        0.01,
        np.stack([scene.source_gyroscope_radps, scene.gyroscope_radps]),
        np.stack([scene.source_accelerometer_mps2, scene.accelerometer_mps2]),
        np.stack([scene.source_ambient_t, field]),
        np.zeros((2, len(field)), dtype=np.uint8),
        coil_state=state,
    )
    return pipelines.create(SessionSetup("relative_pose", ("pelvis", "sternum"), 100.0)).step(chunk)


def test_ellipses_are_those_of_the_covariance(frames: Frames) -> None:
    track = modules_of(frames)
    assert isinstance(track, ModuleTrack)
    known = np.isfinite(track.place_m[:, 1]).all(axis=1)
    assert known.sum() > 300
    assert not track.ellipse_m[~known].any()
    tick = int(np.flatnonzero(known)[-1])
    turn = rotation.to_matrix(track.ellipse_wxyz[tick, 0].astype(float))
    spread = turn @ np.diag((track.ellipse_m[tick, 0].astype(float) / 2.0) ** 2) @ turn.T
    q = rotation.to_matrix(frames.q_room_segment[tick, 0])
    names = frames.layout.scalars
    sigma = np.array([frames.scalar[tick, names.index(f"sternum_{axis}_sigma_m")] for axis in "xyz"])
    shared = np.eye(3)
    for a, b, pair in ((0, 1, "xy"), (0, 2, "xz"), (1, 2, "yz")):
        shared[a, b] = shared[b, a] = frames.scalar[tick, names.index(f"sternum_{pair}_correlation")]
    np.testing.assert_allclose(spread, q @ (shared * np.outer(sigma, sigma)) @ q.T, rtol=1e-3, atol=1e-9)
    assert set(np.unique(track.coil)) == {0, 1, 2, 3}


def test_a_place_that_is_lost_is_not_drawn(frames: Frames) -> None:
    column = frames.layout.scalars.index("sternum_y_sigma_m")
    scalar = frames.scalar.copy()
    scalar[600:, column] = 0.7
    track = modules_of(replace(frames, scalar=scalar))
    assert isinstance(track, ModuleTrack)
    assert np.isfinite(track.place_m[590, 1]).all()
    assert np.isnan(track.place_m[600:, 1]).all()
    assert not track.ellipse_m[600:].any()
    assert np.isfinite(track.place_m[:, 0]).all()


def test_the_scene_shows_modules_and_no_figure(frames: Frames) -> None:
    body = BodyDimensions()
    track = track_from_frames(thinned(frames), body)
    assert is_posed(frames).all()
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        scene = BodyScene(server, body, frozenset({"pelvis", "sternum"}))
        for tick in (0, len(track) // 2, len(track) - 1):
            scene.draw(track, tick)
        nodes = server.scene._handle_from_node_name
        assert nodes["/patient"].visible is False
        assert nodes["/modules/sensor0"].visible is True
        np.testing.assert_allclose(
            nodes["/modules/sensor0"].position, track.modules.place_m[-1, 1], atol=1e-6
        )
        assert nodes["/modules/ellipse0"].visible is True
        assert nodes["/modules/name"].text == "Pelvis: source"
        assert type(nodes["/modules/name"].text) is str, "the wire carries nothing that is only like text"
        apart_m = np.linalg.norm(track.modules.place_m[-1, 1] - track.modules.place_m[-1, 0])
        assert nodes["/modules/name0"].visible is True
        assert f" {100 * apart_m:.0f} cm" in nodes["/modules/name0"].text
        assert nodes["/modules/name0"].position[2] > nodes["/modules/sensor0"].position[2]
    finally:
        server.stop()


def test_a_place_without_the_source_is_not_told_as_measured() -> None:
    assert distance_words("upper_arm_left", 0.4251, is_lone=False) == "Left upper arm: 43 cm"
    assert distance_words("sternum", 0.4251, is_lone=True) == "Chest: about 43 cm"


def test_the_camera_is_told_what_is_mostly_seen(frames: Frames) -> None:
    track = modules_of(frames)
    assert isinstance(track, ModuleTrack)
    place = track.place_m[np.isfinite(track.place_m[:, 1]).all(axis=1), 1]
    assert track.place_m[0, 0, 2] < track.height_m < np.median(place[:, 2])
    assert 0.6 <= track.size_m < 1.6
    nothing = replace(track, place_m=np.full_like(track.place_m, np.nan))
    assert nothing.size_m == 0.6


def test_other_frames_have_no_modules() -> None:
    setup = SessionSetup("orientation", ("pelvis",), 100.0)
    still = np.zeros((1, 5, 3)) + np.array([0.0, 0.0, 9.81])
    chunk = ImuChunk(0, 0.01, np.zeros((1, 5, 3)), still, None, np.zeros((1, 5), dtype=np.uint8))
    assert modules_of(pipelines.create(setup).step(chunk)) is None
