"""Feet of a walk in the scene: shoes, the prints they leave, mass and pressure with their paths, base of support."""

from itertools import pairwise
from typing import Any, Final

import numpy as np
import viser
from numpy.typing import NDArray

from app.viewer.layers import palette
from app.viewer.layers.feet import FeetTrack, Footprint, support_outline
from app.viewer.layers.nodes import FLOOR, SCALES
from app.viewer.layers.palette import Rgb
from estimators.conventions import Side

Float32 = NDArray[np.float32]

SHOES: Final[dict[str, Rgb]] = {"left": (15, 102, 116), "right": (180, 83, 31)}
"""The colours of the map of footprints."""
_MASS: Final[Rgb] = (40, 44, 52)
_PRESSURE: Final[Rgb] = (91, 78, 163)
_GOING: Final[Rgb] = (214, 158, 46)
_SUPPORT: Final[Rgb] = (63, 122, 47)
_PRINTS_SHOWN: Final = 60
_PATH_TICKS: Final = 420
_PATH_POINTS: Final = 140
_ABOVE_FLOOR_M: Final = 0.004
_METRES_PER_NEWTON: Final = 0.001
# Outline of a left shoe seen from above, x to the toes, y to the left, counter-clockwise from the heel.
_OUTLINE: Final = np.array(
    [
        (-0.055, 0.000),
        (-0.045, -0.026),
        (-0.012, -0.034),
        (0.040, -0.028),
        (0.085, -0.034),
        (0.130, -0.048),
        (0.180, -0.046),
        (0.208, -0.020),
        (0.210, 0.008),
        (0.190, 0.036),
        (0.145, 0.051),
        (0.100, 0.045),
        (0.050, 0.037),
        (-0.012, 0.036),
        (-0.045, 0.026),
    ]
)
# Height of each ring of the shoe, and how much of length (from the heel) and width is left there.
_RINGS: Final = (
    (0.000, 0.97, 0.92),
    (0.012, 1.00, 1.00),
    (0.030, 0.99, 0.97),
    (0.048, 0.90, 0.82),
    (0.062, 0.68, 0.70),
    (0.085, 0.46, 0.66),
    (0.098, 0.42, 0.58),
)


class FeetLayer:
    """The nodes of a walk; everything hangs below one root, so that the picture goes along with the walker.

    Parameters
    ----------
    track : FeetTrack
        The first one that is shown: tells which feet are worn, and whether forces are known.
    """

    def __init__(self, server: viser.ViserServer, track: FeetTrack) -> None:
        scene = server.scene
        self.sides = track.sides
        self.has_balance = track.mass_m is not None
        self._root = scene.add_frame("/walk", show_axes=False)
        self._floor_m = np.zeros(2)
        self._server = server
        self._shoes: list[Any] = []
        self._prints: list[list[Any]] = []
        for side in track.sides:
            vertices, faces = shoe_mesh(side)
            self._shoes.append(
                scene.add_mesh_simple(
                    f"/walk/shoe_{side}",
                    vertices,
                    faces,
                    color=SHOES[side],
                    cast_shadow=True,
                    receive_shadow=False,
                )
            )
            flat, triangles = _flat_sole(side)
            self._prints.append(
                [
                    scene.add_mesh_simple(
                        f"/walk/print_{side}{number}",
                        flat,
                        triangles,
                        color=SHOES[side],
                        opacity=0.45,
                        side="double",
                        cast_shadow=False,
                        visible=False,
                    )
                    for number in range(_PRINTS_SHOWN // len(track.sides))
                ]
            )
        self._shown: list[list[Footprint]] = [[] for _ in track.sides]
        self._lost = np.zeros(len(track.sides), dtype=bool)
        self._balance = _Balance(server) if self.has_balance else None
        self._forces = _Forces(server, track.sides) if track.force_n is not None else None

    def show(self, track: FeetTrack, tick: int) -> None:
        """Show one tick."""
        self._follow(track.followed_m[tick])
        for foot, shoe in enumerate(self._shoes):
            shoe.position = track.place_m[tick, foot]
            shoe.wxyz = track.wxyz[tick, foot]
            if track.lost[tick, foot] != self._lost[foot]:
                self._lost[foot] = track.lost[tick, foot]
                shoe.color = palette.LOST if self._lost[foot] else SHOES[self.sides[foot]]
        self._leave_prints(track, tick)
        if self._balance is not None:
            self._balance.show(track, tick)
        if self._forces is not None:
            self._forces.show(track, tick)

    def _follow(self, middle_m: Float32) -> None:
        """Keep the walker in the middle: the walk goes back below, and the floor with it."""
        self._root.position = (-float(middle_m[0]), -float(middle_m[1]), 0.0)
        # The grid repeats every metre.
        shift = -np.mod(middle_m.astype(np.float64), 1.0)
        if np.abs(shift - self._floor_m).max() > 1e-3:
            self._floor_m = shift
            for name in (FLOOR, *SCALES):
                node = self._server.scene.get_handle_by_name(name)
                if node is not None:
                    node.position = (float(shift[0]), float(shift[1]), 0.0)

    def _leave_prints(self, track: FeetTrack, tick: int) -> None:
        for foot, pool in enumerate(self._prints):
            known = [one for one in track.prints if one.foot == foot and one.tick <= tick]
            wanted = known[-len(pool) :]
            if wanted == self._shown[foot]:
                continue
            for number, node in enumerate(pool):
                one = wanted[number] if number < len(wanted) else None
                if node.visible != (one is not None):
                    node.visible = one is not None
                if one is not None:
                    node.position = (one.place_m[0], one.place_m[1], one.place_m[2] + _ABOVE_FLOOR_M)
                    node.wxyz = (np.cos(0.5 * one.heading_rad), 0.0, 0.0, np.sin(0.5 * one.heading_rad))
            self._shown[foot] = wanted


class _Balance:
    """Centre of mass with its plumb line and path, pressure with its path, base of support."""

    def __init__(self, server: viser.ViserServer) -> None:
        scene = server.scene

        def ball(name: str, radius_m: float, colour: Rgb) -> Any:
            # Without a shadow: a shadow far from its foot would be taken for a place on the floor.
            return scene.add_icosphere(
                f"/walk/{name}", radius=radius_m, color=colour, subdivisions=3, cast_shadow=False
            )

        self._mass = ball("mass", 0.045, _MASS)
        self._pressure = ball("pressure", 0.018, _PRESSURE)
        self._going = ball("going", 0.018, _GOING)

        def line(name: str, colour: Rgb, thickness: float) -> Any:
            nothing = np.zeros((1, 2, 3), dtype=np.float32)
            return scene.add_line_segments(
                f"/walk/{name}", nothing, colors=colour, thickness=thickness, thickness_units="screen"
            )

        self._plumb = line("plumb", _MASS, 1.5)
        self._mass_path = line("mass_path", _MASS, 4.0)
        self._pressure_path = line("pressure_path", _PRESSURE, 2.0)
        self._support = line("support", _SUPPORT, 3.0)

    def show(self, track: FeetTrack, tick: int) -> None:
        """Show one tick."""
        if track.mass_m is None or track.pressure_m is None or track.going_m is None:
            return
        mass = track.mass_m[tick]
        for node, place in (
            (self._mass, mass),
            (self._pressure, track.pressure_m[tick]),
            (self._going, track.going_m[tick]),
        ):
            # What is not known is not shown: nothing stands still where it last was.
            if _shown(node, place):
                node.position = place
        if _shown(self._plumb, mass):
            below = np.array([mass[0], mass[1], _ABOVE_FLOOR_M], dtype=np.float32)
            self._plumb.points = np.stack([mass, below])[None]
        first = max(0, tick - _PATH_TICKS)
        every = max(1, (tick - first) // _PATH_POINTS)
        past = slice(first, tick + 1, every)
        trails = (track.mass_m[past], track.pressure_m[past]) if track.trails_m is None else track.trails_m
        for node, path in zip((self._mass_path, self._pressure_path), trails, strict=True):
            points = path[np.isfinite(path).all(axis=1)]
            points[:, 2] = 1.5 * _ABOVE_FLOOR_M
            if len(points) > 1:
                node.points = np.stack([points[:-1], points[1:]], axis=1)
        outline = support_outline(track, tick)
        if self._support.visible != (len(outline) > 2):
            self._support.visible = len(outline) > 2
        if len(outline) > 2:
            loop = np.column_stack([outline, np.full(len(outline), _ABOVE_FLOOR_M)]).astype(np.float32)
            self._support.points = np.stack([loop, np.roll(loop, -1, axis=0)], axis=1)


class _Forces:
    """The ground's force on each foot as an arrow from its pressure centre."""

    def __init__(self, server: viser.ViserServer, sides: tuple[Side, ...]) -> None:
        nothing = np.zeros((3, 2, 3), dtype=np.float32)
        self._arrows = [
            server.scene.add_line_segments(
                f"/walk/force_{side}",
                nothing,
                colors=SHOES[side],
                thickness=4.0,
                thickness_units="screen",
                visible=False,
            )
            for side in sides
        ]

    def show(self, track: FeetTrack, tick: int) -> None:
        """Show one tick."""
        if track.force_n is None or track.pressed_m is None:
            return
        for arrow, force, start in zip(self._arrows, track.force_n[tick], track.pressed_m[tick], strict=True):
            if not _shown(arrow, np.concatenate([force, start])):
                continue
            along = force * _METRES_PER_NEWTON
            end = start + along
            size = max(float(np.linalg.norm(along)), 1e-6)
            # The barbs lie in the plane that is seen from the side.
            barb = min(0.06, 0.3 * size) * along / size
            across = np.array([0.35 * barb[2], 0.0, -0.35 * barb[0]], dtype=np.float32)
            tips = np.stack([end - barb + across, end - barb - across])
            arrow.points = np.stack(
                [np.stack([start, end]), np.stack([end, tips[0]]), np.stack([end, tips[1]])]
            ).astype(np.float32)


def _shown(node: Any, values: NDArray[np.floating]) -> bool:
    """Show a node where its values are known, else hide it."""
    is_known = bool(np.isfinite(values).all())
    if node.visible != is_known:
        node.visible = is_known
    return is_known


def shoe_mesh(side: str) -> tuple[Float32, NDArray[np.uint32]]:
    """Return the mesh of a shoe: rings of its outline, laid over each other and closed above and below."""
    outline = _sided(side)
    heel = outline[:, 0].min()
    rings = [
        np.column_stack(
            [heel + (outline[:, 0] - heel) * along, outline[:, 1] * across, np.full(len(outline), z)]
        )
        for z, along, across in _RINGS
    ]
    count = len(outline)
    vertices = np.concatenate([*rings, rings[0].mean(axis=0)[None], rings[-1].mean(axis=0)[None]])
    faces = []
    for lower, upper in pairwise(range(len(rings))):
        for k in range(count):
            after = (k + 1) % count
            a, b = lower * count + k, lower * count + after
            c, d = upper * count + k, upper * count + after
            faces += [(a, b, d), (a, d, c)]
    below, above, top = len(vertices) - 2, len(vertices) - 1, (len(rings) - 1) * count
    for k in range(count):
        after = (k + 1) % count
        faces += [(below, after, k), (above, top + k, top + after)]
    return vertices.astype(np.float32), np.array(faces, dtype=np.uint32)


def _flat_sole(side: str) -> tuple[Float32, NDArray[np.uint32]]:
    outline = _sided(side)
    flat = np.column_stack([outline, np.zeros(len(outline))])
    vertices = np.concatenate([flat, flat.mean(axis=0)[None]])
    count = len(outline)
    return vertices.astype(np.float32), np.array(
        [(count, k, (k + 1) % count) for k in range(count)], dtype=np.uint32
    )


def _sided(side: str) -> NDArray[np.float64]:
    """Return the outline of a side, counter-clockwise."""
    return _OUTLINE if side == "left" else (_OUTLINE * [1.0, -1.0])[::-1]
