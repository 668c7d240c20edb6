"""The centre of mass of a body with worn sensors: a ball, how well it is known, and the plumb line to the floor."""

from typing import Final

import numpy as np
import viser
from numpy.typing import NDArray

from app.viewer.figure.proportions import hip_height_m
from app.viewer.layers import palette
from estimators.balance import MASS_POINT, MASS_SCALARS
from estimators.body import BodyDimensions
from estimators.pipelines import Frames

Float32 = NDArray[np.float32]

_MASS: Final = (40, 44, 52)
"""As on walks."""
_BALL_M: Final = 0.032
_SEEN_LEAST_M: Final = 0.034
_SEEN_MOST_M: Final = 0.25
"""A ball of two sigma within the first is hidden by the centre's own, beyond the second nothing is known."""
_EPSILON_M: Final = 5e-4
_FIRST_SIGMA: Final = len(MASS_SCALARS) // 2


def mass_of(frames: Frames, body: BodyDimensions) -> tuple[Float32 | None, Float32 | None]:
    """Return centre of mass (K, 3) and two sigma (K,) of frames for drawing; None where the sensors do not tell it."""
    layout = frames.layout
    if MASS_POINT not in layout.points or MASS_SCALARS[0] not in layout.scalars:
        return None, None
    place = frames.point_room_m[:, layout.points.index(MASS_POINT)].astype(np.float32)
    first = layout.scalars.index(MASS_SCALARS[_FIRST_SIGMA])
    spread = 2.0 * frames.scalar[:, first : first + 3].max(axis=1)
    # The hips of the figure stand where its legs put them.
    place[:, 2] += hip_height_m(body) - frames.point_room_m[:, layout.points.index("pelvis"), 2]
    return place, np.nan_to_num(spread).astype(np.float32)


class MassNode:
    """The nodes of one centre of mass."""

    def __init__(self, server: viser.ViserServer) -> None:
        scene = server.scene
        self._root = scene.add_frame("/mass", show_axes=False, visible=False)
        scene.add_icosphere("/mass/ball", radius=_BALL_M, color=_MASS, cast_shadow=False)
        self._doubt = scene.add_icosphere(
            "/mass/doubt",
            radius=1.0,
            color=palette.HALO,
            opacity=0.3,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._line = scene.add_line_segments(
            "/mass/line",
            np.zeros((1, 2, 3), dtype=np.float32),
            colors=_MASS,
            thickness=2.5,
            thickness_units="screen",
        )
        self._floor = scene.add_icosphere(
            "/mass/floor", radius=0.025, color=_MASS, cast_shadow=False, scale=(1.0, 1.0, 0.2)
        )
        self._shown = np.full(3, np.nan, dtype=np.float32)

    def show(self, place_m: Float32, spread_m: float) -> None:
        """Show a place, or nothing while it is not known."""
        known = bool(np.isfinite(place_m).all())
        if self._root.visible != known:
            self._root.visible = known
        if not known or np.abs(place_m - self._shown).max() < _EPSILON_M:
            return
        self._shown = place_m.copy()
        self._root.position = tuple(float(v) for v in place_m)
        down = np.array([0.0, 0.0, -float(place_m[2])], dtype=np.float32)
        self._line.points = np.stack([np.zeros(3, dtype=np.float32), down])[None]
        self._floor.position = (0.0, 0.0, 0.004 - float(place_m[2]))
        seen = _SEEN_LEAST_M < spread_m < _SEEN_MOST_M
        if self._doubt.visible != seen:
            self._doubt.visible = seen
        if seen:
            self._doubt.scale = spread_m
