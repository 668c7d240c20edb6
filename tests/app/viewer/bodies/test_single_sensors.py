"""Single sensors in the 3D view: cases that turn as measured, and no person."""

import numpy as np
import pytest
import viser

from app.viewer.layers.single_sensors import HEIGHT_M, SensorTrack, sensors_of
from app.viewer.pose import track_from_frames
from app.viewer.scene import BodyScene
from estimators import pipelines
from estimators.body import BodyDimensions
from estimators.conventions import GRAVITY_MPS2
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import ImuChunk

NAMES = ("static", "upper", "middle")


@pytest.fixture(scope="module")
def frames() -> Frames:
    ticks = 300
    accelerometer = np.zeros((3, ticks, 3))
    # The second lies on its side, x up.
    accelerometer[[0, 2], :, 2] = accelerometer[1, :, 0] = GRAVITY_MPS2
    gyroscope = np.random.default_rng(0).normal(0.0, 1e-3, (3, ticks, 3))
    quality = np.zeros((3, ticks), dtype=np.uint8)
    chunk = ImuChunk(0, 0.01, gyroscope, accelerometer, None, quality)
    return pipelines.create(SessionSetup("orientation", NAMES, 100.0)).step(chunk)


def test_they_turn_as_measured_and_hold_what_was_last_known(frames: Frames) -> None:
    track = sensors_of(frames)
    assert track is not None
    assert track.names == NAMES
    np.testing.assert_allclose(track.wxyz[-1], frames.q_room_segment[-1], atol=1e-6)
    frames.q_room_segment[200:250, 1] = np.nan
    held = sensors_of(frames)
    assert held is not None
    np.testing.assert_array_equal(held.wxyz[249, 1], held.wxyz[199, 1])
    assert held.lost[200:250, 1].all()
    assert not held.lost[250:, 1].any()


@pytest.mark.parametrize("count", [1, 2, 4, 7, 17])
def test_none_hides_another(count: int) -> None:
    names = tuple(f"s{number}" for number in range(count))
    track = SensorTrack(names, np.zeros((1, count, 4), np.float32), np.zeros((1, count), bool))
    place = track.place_m
    apart = np.linalg.norm(place[:, None] - place[None], axis=2)[~np.eye(count, dtype=bool)]
    assert count == 1 or apart.min() > 0.25
    assert place[:, 2].mean() == pytest.approx(HEIGHT_M, abs=0.16)
    assert np.ptp(place[:, 1]) < track.size_m
    assert place[:, 2].min() > 0.2


def test_the_scene_shows_them_and_no_person(frames: Frames) -> None:
    body = BodyDimensions()
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        scene = BodyScene(server, body, frozenset())
        scene.draw(track_from_frames(frames, body), frames.tick_count - 1)
        nodes = server.scene._handle_from_node_name
        assert nodes["/patient"].visible is False
        assert nodes["/sensors/name0"].text == "Static"
        np.testing.assert_allclose(nodes["/sensors/sensor1"].wxyz, frames.q_room_segment[-1, 1], atol=1e-6)
    finally:
        server.stop()


def test_frames_of_a_body_have_none() -> None:
    setup = SessionSetup("arm", ("upper_arm_right", "forearm_right"), 100.0)
    quality = np.zeros((2, 5), dtype=np.uint8)
    still = np.zeros((2, 5, 3))
    still[..., 2] = GRAVITY_MPS2
    chunk = ImuChunk(0, 0.01, np.zeros((2, 5, 3)), still, None, quality)
    assert sensors_of(pipelines.create(setup).step(chunk)) is None
