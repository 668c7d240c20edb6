"""Single sensors of a recording: a case each in a grid, turned as it was measured; where they were nobody measured.

They are drawn instead of the body: they need not have been worn at all.
"""

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import viser
from numpy.typing import NDArray

from app.viewer.layers import palette
from app.viewer.layers.palette import Rgb
from app.viewer.layers.words import Words
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames
from estimators.sentences import say

Float32 = NDArray[np.float32]

HEIGHT_M: Final = 1.15
"""Of the middle of the grid above the floor."""
_APART_M: Final = 0.3
_CASE: Final[Rgb] = (236, 232, 226)
_LABEL_BELOW_M: Final = 0.1
_LABEL_SCALE: Final = 1.3
_LOST: Final = np.uint8(OrientationFlag.INVALID)


@dataclass(frozen=True)
class SensorTrack:
    """Single sensors over K ticks.

    Attributes
    ----------
    wxyz : ndarray of float32, shape (K, N, 4)
        Orientation in the room.
    lost : ndarray of bool, shape (K, N)
        The sensor gives nothing now; the rotation is the last one known.
    """

    names: tuple[str, ...]
    wxyz: Float32
    lost: NDArray[np.bool_]

    @property
    def place_m(self) -> Float32:
        """Where each is drawn, shape (N, 3), row by row from the upper left."""
        columns = math.ceil(math.sqrt(len(self.names)))
        row, column = np.divmod(np.arange(len(self.names)), columns)
        across = column - (columns - 1) / 2.0
        up = row.max() / 2.0 - row
        return np.stack([np.zeros(len(row)), _APART_M * across, HEIGHT_M + _APART_M * up], axis=1).astype(
            np.float32
        )

    @property
    def size_m(self) -> float:
        """Extent of the grid, with room for words."""
        return _APART_M * (math.ceil(math.sqrt(len(self.names))) + 1.0)


def sensors_of(frames: Frames) -> SensorTrack | None:
    """Return the single sensors in frames; None when they are of a body, a walk or a source."""
    layout = frames.layout
    if layout.points or layout.angles or layout.scalars:
        return None
    turn = frames.q_room_segment
    known = np.isfinite(turn).all(axis=2)
    # What is not known yet, or no longer, stays as it was last.
    last = np.maximum.accumulate(np.where(known, np.arange(frames.tick_count)[:, None], 0), axis=0)
    held = np.take_along_axis(turn, last[..., None], axis=0)
    held = np.where(np.isfinite(held), held, (1.0, 0.0, 0.0, 0.0))
    return SensorTrack(
        names=layout.segments,
        wxyz=held.astype(np.float32),
        lost=np.asarray(~known | ((frames.segment_flags & _LOST) != 0)),
    )


class SensorLayer:
    """The nodes of single sensors in one scene.

    Parameters
    ----------
    words : callable(sentence)
        In the language of the page.
    """

    def __init__(self, server: viser.ViserServer, track: SensorTrack, words: Words) -> None:
        self.names = track.names
        self._frames: list[Any] = []
        self._cases: list[Any] = []
        for number, (name, place) in enumerate(zip(track.names, track.place_m, strict=True)):
            path = f"/sensors/sensor{number}"
            self._frames.append(
                server.scene.add_frame(path, axes_length=0.08, axes_radius=0.0025, position=place)
            )
            self._cases.append(
                server.scene.add_box(f"{path}/case", color=_CASE, dimensions=(0.06, 0.042, 0.016))
            )
            server.scene.add_label(
                f"/sensors/name{number}",
                words(say("viewer.sensor", place=name)),
                position=place - np.array([0.0, 0.0, _LABEL_BELOW_M], dtype=np.float32),
                font_screen_scale=_LABEL_SCALE,
                anchor="top-center",
            )

    def show(self, track: SensorTrack, tick: int) -> None:
        """Show one tick."""
        for number, frame in enumerate(self._frames):
            frame.wxyz = track.wxyz[tick, number]
            colour = palette.LOST if track.lost[tick, number] else _CASE
            if tuple(self._cases[number].color) != colour:
                self._cases[number].color = colour
