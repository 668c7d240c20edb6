"""A fused marker in the 3D view: what is drawn of it, and who may open it."""

import numpy as np
import pytest
import viser

from app.recordings.marker_motion import Motion
from app.recordings.markers import COLUMNS
from app.viewer.camera import around
from app.viewer.layers import palette
from app.viewer.layers.markers import markers_of
from app.viewer.pose import track_from_markers
from app.viewer.scene import BodyScene
from estimators.body import BodyDimensions


def moved(rate_hz: float = 100.0, length_m: float = 0.6, height_m: float = 1.0) -> Motion:
    """Return eight seconds to and fro, two metres off the zero of the laboratory, unseen from 3 to 4.5 s."""
    time_s = 2.0 + np.arange(round(8.0 * rate_hz)) / rate_hz
    values = np.zeros((len(time_s), len(COLUMNS)), dtype=np.float32)
    x = 2.0 + 0.5 * length_m * np.sin(0.9 * time_s)
    place = np.column_stack([x, np.full_like(x, -1.0), height_m + 0.1 * np.cos(time_s)])
    hidden = (time_s >= 5.0) & (time_s < 6.5)
    seen = np.where(hidden[:, None] | (np.arange(len(x)) % 4 != 1)[:, None], np.nan, place)
    for axis, letter in enumerate("xyz"):
        values[:, COLUMNS.index(f"position_{letter}_m")] = place[:, axis] - 0.03
        values[:, COLUMNS.index(f"marker_{letter}_m")] = place[:, axis]
        values[:, COLUMNS.index(f"measured_{letter}_m")] = seen[:, axis]
        values[:, COLUMNS.index(f"position_sigma_{letter}_m")] = np.where(hidden, 0.02, 0.0005)
    values[:, COLUMNS.index("q_room_sensor_w")] = 1.0
    values[:, COLUMNS.index("is_gap")] = hidden
    return Motion(time_s, values)


@pytest.mark.parametrize("rate_hz", [100.0, 240.0])
def test_the_path_lies_in_the_middle_and_keeps_its_frames_and_gaps(rate_hz: float) -> None:
    time_s, track = markers_of(moved(rate_hz))
    assert len(time_s) == len(track)
    # Before and after there is nothing.
    assert not np.isfinite(track.place_m[[0, -1]]).any()
    assert time_s[1] == 2.0
    middle = 0.5 * (np.nanmin(track.place_m, axis=0) + np.nanmax(track.place_m, axis=0))
    np.testing.assert_allclose(middle[:2], 0.0, atol=1e-5)
    assert middle[2] == pytest.approx(track.height_m, abs=1e-3)
    np.testing.assert_array_equal(track.is_gap, (time_s > 4.999) & (time_s < 6.499))
    seen = np.isfinite(track.measured_m).all(axis=1)
    # Thinned ticks miss no frames although only every fourth tick has one.
    assert seen[~track.is_gap][1:-1].mean() > 0.24
    assert not seen[track.is_gap].any()
    assert track.spread_m[track.is_gap].min() == pytest.approx(0.04)
    assert not track.followed_m.any()


def test_a_long_way_is_followed_and_a_high_zero_lies_on_the_floor() -> None:
    _, track = markers_of(moved(length_m=9.0, height_m=-0.4))
    assert np.ptp(track.followed_m[:, 0]) > 5.0
    assert np.nanmin(track.place_m[:, 2]) == pytest.approx(0.0, abs=1e-5)
    away = np.abs(track.place_m[1:-1, :2] - track.followed_m[1:-1])
    assert away.max() < 2.5


@pytest.mark.slow
def test_the_scene_shows_path_frames_and_gaps_and_no_figure() -> None:
    time_s, markers = markers_of(moved())
    track = track_from_markers(time_s, markers)
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        scene = BodyScene(server, BodyDimensions(), frozenset())

        def node(name: str):  # type: ignore[no-untyped-def]
            return server.scene.get_handle_by_name(f"/markers/{name}")

        scene.draw(track, int(np.searchsorted(time_s, 4.0)))
        assert not server.scene.get_handle_by_name("/patient").visible
        # The whole way is drawn thinly, the last seconds thickly.
        assert node("path/seen").visible
        assert node("path/filled").visible
        assert node("frames").visible
        assert node("tail/seen").visible
        assert not node("tail/filled").visible
        assert not node("doubt").visible
        assert tuple(node("marker").color) == palette.FRAME
        scene.draw(track, int(np.searchsorted(time_s, 6.0)))
        assert tuple(node("marker").color) == palette.FILLED
        assert node("tail/filled").visible
        assert node("doubt").visible
        filled = node("path/filled").points
        x = filled[:, :, 0]
        inside = markers.place_m[markers.is_gap, 0]
        assert x.min() > inside.min() - 0.02
        assert x.max() < inside.max() + 0.02
        scene.draw(track, 0)
        assert not node("module").visible
        assert not node("marker").visible
    finally:
        server.stop()


def test_the_camera_has_all_of_it_in_the_picture() -> None:
    for aspect in (0.6, 1.4):
        camera = around("start", 1.0, 0.6, aspect)
        assert camera.look_at_m == (0.0, 0.0, 1.0)
        distance = np.linalg.norm(np.subtract(camera.position_m, camera.look_at_m))
        assert 2.0 * distance * np.tan(np.radians(16.0)) * min(aspect, 1.0) > 0.6
    near, far = (around(name, 1.0, 2.0, 1.0) for name in ("arm", "top"))
    assert np.linalg.norm(np.subtract(near.position_m, near.look_at_m)) < np.linalg.norm(
        np.subtract(far.position_m, far.look_at_m)
    )
