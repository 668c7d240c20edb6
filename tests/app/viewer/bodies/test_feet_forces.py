"""Forces of two shoes in the live 3D view: arrows, what is not known hidden, paths that go on."""

import numpy as np
import pytest

from app.viewer.layers import feet_layer
from app.viewer.layers.feet import FeetTrack, feet_of
from app.viewer.layers.feet_live import LiveCourse
from estimators.conventions import SHOE_PLACEMENTS
from estimators.pipelines import Frames, SessionSetup, create

TICKS = 12


@pytest.fixture
def frames() -> Frames:
    """Return frames of two shoes that stand; both feet carry, and the right one's cells fail at tick 8."""
    layout = create(SessionSetup("gait", SHOE_PLACEMENTS, 100.0)).layout
    points = np.zeros((TICKS, len(layout.points), 3))
    scalar = np.full((TICKS, len(layout.scalars)), np.nan)

    def put(name: str, place: tuple[float, float, float], last: int = TICKS) -> None:
        points[:, layout.points.index(name)] = np.nan
        points[:last, layout.points.index(name)] = place

    put("foot_left", (0.0, 0.1, 0.0))
    put("foot_right", (0.0, -0.1, 0.0))
    put("pressure_left", (0.1, 0.1, 0.0))
    put("pressure_right", (0.1, -0.1, 0.0), 8)
    put("centre_of_pressure", (0.1, 0.0, 0.0), 8)
    put("centre_of_mass", (0.1, 0.0, 0.9), 10)
    put("extrapolated_centre", (0.1, 0.0, 0.0), 10)
    for side, last in (("left", TICKS), ("right", 8)):
        scalar[:, layout.scalars.index(f"foot_{side}_stance")] = 1.0
        for axis, newton in zip("xyz", (10.0, 0.0, 400.0), strict=True):
            scalar[:last, layout.scalars.index(f"foot_{side}_force_{axis}_n")] = newton
    identity = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (TICKS, 2, 4)).copy()
    nothing = np.empty((TICKS, 0))
    flags = np.zeros((TICKS, 2), dtype=np.uint8)
    return Frames(
        layout, 0, 0.01, identity, points, nothing, nothing, scalar, flags, np.empty((TICKS, 0), np.uint8)
    )


def track_of(frames: Frames) -> FeetTrack:
    track = feet_of(frames)
    assert track is not None
    return LiveCourse().turned(track)


def test_feet_in_one_room_are_not_turned(frames: Frames) -> None:
    track = track_of(frames)
    assert track.is_in_room
    np.testing.assert_allclose(track.place_m[:, 1], [[0.0, -0.1, 0.0]] * TICKS)
    assert [one.place_m for one in track.prints] == [
        pytest.approx((0.0, 0.1, 0.0)),
        pytest.approx((0.0, -0.1, 0.0)),
    ]
    assert track.trails_m is not None
    mass, pressure = track.trails_m
    assert np.isfinite(mass).all()
    assert len(pressure) < len(mass)


class Server:
    """Keeps what would be sent."""

    def __init__(self) -> None:
        self.nodes: dict[str, Server] = {}
        self.scene, self.visible, self.points, self.position = self, True, None, None

    def __getattr__(self, name: str):
        if not name.startswith("add_"):
            raise AttributeError(name)

        def add(path: str, *values: object, visible: bool = True, **more: object) -> Server:
            node = Server()
            node.visible = visible
            self.nodes[path] = node
            return node

        return add

    def get_handle_by_name(self, name: str) -> None:
        return None


def test_arrows_stand_on_the_pressure_and_what_is_not_known_is_hidden(frames: Frames) -> None:
    server, track = Server(), track_of(frames)
    layer = feet_layer.FeetLayer(server, track)  # type: ignore[arg-type]
    layer.show(track, 5)
    arrow = server.nodes["/walk/force_left"]
    np.testing.assert_allclose(arrow.points[0], [[0.1, 0.1, 0.0], [0.11, 0.1, 0.4]], atol=1e-6)
    assert server.nodes["/walk/force_right"].visible
    assert server.nodes["/walk/pressure"].visible
    layer.show(track, 9)
    assert not server.nodes["/walk/force_right"].visible
    assert not server.nodes["/walk/pressure"].visible
    assert server.nodes["/walk/force_left"].visible
    assert server.nodes["/walk/mass"].visible
    layer.show(track, 11)
    assert not server.nodes["/walk/mass"].visible
    assert not server.nodes["/walk/plumb"].visible
