"""A fused marker in the scene: its path, filled gaps in another colour and broken, the frames of the cameras."""

from typing import Any, Final

import numpy as np
import viser
from numpy.typing import NDArray

from app.viewer.layers import palette
from app.viewer.layers.markers import MarkerTrack
from app.viewer.layers.nodes import FLOOR, SCALES
from estimators import rotation

Float32 = NDArray[np.float32]

_BLOCK_S: Final = 10.0
"""The thin path reaches from one of these before to one after the present."""
_TAIL_S: Final = 4.0
_PATH_RATE_HZ: Final = 30.0
_CASE: Final = (236, 232, 226)
_MARKER_M: Final = 0.0125
_DOUBT_LEAST_M: Final = 0.004
_DOUBT_MOST_M: Final = 0.6
_NOTHING: Final = np.zeros((1, 2, 3), dtype=np.float32)


class MarkersLayer:
    """The nodes of one fused marker; they hang below one root, so that the picture can go along."""

    def __init__(self, server: viser.ViserServer) -> None:
        scene = server.scene
        self._server = server
        self._root = scene.add_frame("/markers", show_axes=False)
        self._path = _Path(server, "/markers/path", 2.0)
        self._tail = _Path(server, "/markers/tail", 5.0)
        self._frames = scene.add_point_cloud(
            "/markers/frames",
            np.zeros((1, 3), dtype=np.float32),
            palette.FRAME,
            point_size=0.004,
            point_shape="circle",
            point_shading="flat",
            visible=False,
        )
        self._module = scene.add_frame("/markers/module", axes_length=0.07, axes_radius=0.0025)
        self._case = scene.add_box("/markers/module/case", color=_CASE, dimensions=(0.05, 0.036, 0.014))
        self._marker = scene.add_icosphere(
            "/markers/marker", radius=_MARKER_M, color=palette.FRAME, cast_shadow=False
        )
        self._arm = scene.add_line_segments(
            "/markers/arm", _NOTHING, colors=palette.LOST, thickness=2.0, thickness_units="screen"
        )
        self._doubt = scene.add_icosphere(
            "/markers/doubt",
            radius=1.0,
            color=palette.HALO,
            opacity=0.35,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._block: int | None = None
        self._floor_m = np.zeros(2)
        self._is_gap = False

    def show(self, track: MarkerTrack, time_s: NDArray[np.float64], tick: int) -> None:
        """Show one tick.

        Parameters
        ----------
        time_s : ndarray, shape (K,)
            Session time of its ticks.
        """
        self._follow(track.followed_m[tick])
        now_s = float(time_s[tick])
        step_s = float(time_s[1] - time_s[0])
        stride = max(1, round(1.0 / (_PATH_RATE_HZ * step_s)))
        block = int(now_s // _BLOCK_S)
        if block != self._block:
            self._block = block
            ends = np.searchsorted(time_s, [(block - 1) * _BLOCK_S, (block + 2) * _BLOCK_S])
            self._path.show(track, int(ends[0]), int(ends[1]), stride)
            seen = track.measured_m[ends[0] : ends[1]]
            seen = seen[np.isfinite(seen).all(axis=1)][:: 2 * stride]
            if len(seen):
                self._frames.points = seen
            _set_visible(self._frames, bool(len(seen)))
        first = int(np.searchsorted(time_s, now_s - _TAIL_S))
        self._tail.show(track, first, tick + 1, stride)
        self._show_module(track, tick)

    def _show_module(self, track: MarkerTrack, tick: int) -> None:
        place, module, spread = track.place_m[tick], track.module_m[tick], float(track.spread_m[tick])
        known = bool(np.isfinite(place).all() and np.isfinite(module).all())
        for node in (self._module, self._marker, self._arm):
            _set_visible(node, known)
        _set_visible(self._doubt, known and spread > _DOUBT_LEAST_M)
        if not known:
            return
        self._module.position, self._module.wxyz = module, rotation.normalize(track.wxyz[tick].astype(float))
        self._marker.position = place
        self._arm.points = np.stack([module, place])[None]
        is_gap = bool(track.is_gap[tick])
        if is_gap != self._is_gap:
            self._is_gap = is_gap
            self._marker.color = palette.FILLED if is_gap else palette.FRAME
        if self._doubt.visible:
            self._doubt.position, self._doubt.scale = place, min(spread, _DOUBT_MOST_M)

    def _follow(self, middle_m: Float32) -> None:
        """Keep the marker in the middle of a long way; the grid repeats every metre."""
        shift = -np.mod(middle_m.astype(np.float64), 1.0)
        self._root.position = (-float(middle_m[0]), -float(middle_m[1]), 0.0)
        if np.abs(shift - self._floor_m).max() > 1e-3:
            self._floor_m = shift
            for name in (FLOOR, *SCALES):
                node = self._server.scene.get_handle_by_name(name)
                if node is not None:
                    node.position = (float(shift[0]), float(shift[1]), 0.0)


class _Path:
    """A path: whole where the cameras saw the marker, broken and in another colour where the sensor filled it."""

    def __init__(self, server: viser.ViserServer, name: str, thickness: float) -> None:
        self._lines = [
            server.scene.add_line_segments(
                f"{name}/{part}",
                _NOTHING,
                colors=colour,
                thickness=thickness,
                thickness_units="screen",
                visible=False,
            )
            for part, colour in (("seen", palette.TRAIL), ("filled", palette.FILLED))
        ]

    def show(self, track: MarkerTrack, first: int, stop: int, stride: int) -> None:
        """Draw the ticks `[first, stop)`."""
        # Always the same ticks, so that the strokes of a gap stand still.
        rows = np.arange(-(-first // stride) * stride, stop, stride)
        points, is_gap = track.place_m[rows], track.is_gap[rows]
        pairs = np.stack([points[:-1], points[1:]], axis=1) if len(rows) > 1 else _NOTHING[:0]
        sound = np.isfinite(pairs).all(axis=(1, 2))
        filled = is_gap[:-1] | is_gap[1:] if len(rows) > 1 else np.zeros(0, dtype=np.bool_)
        stroke = (rows[: len(pairs)] // stride) % 4 < 3
        for line, chosen in zip(self._lines, (sound & ~filled, sound & filled & stroke), strict=True):
            part = pairs[chosen]
            if len(part):
                line.points = part
            _set_visible(line, bool(len(part)))


def _set_visible(node: Any, on: bool) -> None:
    if node.visible != on:
        node.visible = on
