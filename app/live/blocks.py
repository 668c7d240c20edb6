"""Frames as the binary blocks of `app.live.messages`, and the layout message that names their columns."""

import struct
import time
from typing import Final

import numpy as np

from app.live.messages import LayoutMessage
from app.recordings.schemas import FrameLayoutOut
from estimators.pipelines._contract import FrameLayout, Frames

MAGIC: Final = b"TMF1"
_HEADER: Final = struct.Struct("<4sIIIddd")


class PublishedFrames:
    """Frames with the moment they were given to the bus.

    Parameters
    ----------
    frames : Frames
    published_at_s : float
        Server time since the epoch.
    """

    def __init__(self, frames: Frames, published_at_s: float) -> None:
        self.frames = frames
        self.published_at_s = published_at_s
        self._block: bytes | None = None

    @property
    def block(self) -> bytes:
        """The frames as a binary block, made once for all who watch."""
        if self._block is None:
            self._block = encode_block(self.frames, self.published_at_s)
        return self._block


def column_names(layout: FrameLayout) -> list[str]:
    """Return the columns of a block in order."""
    return [
        *layout.angles,
        *(f"{angle}.sigma" for angle in layout.angles),
        *layout.scalars,
        *(f"{point}.{axis}" for point in layout.points for axis in "xyz"),
        *(f"{segment}.flags" for segment in layout.segments),
        *(f"{angle}.flags" for angle in layout.angles),
    ]


def encode_block(frames: Frames, published_at_s: float | None = None) -> bytes:
    """Return frames as one binary block.

    Parameters
    ----------
    frames : Frames
    published_at_s : float, optional
        By default the present.
    """
    layout = frames.layout
    ticks, angles, scalars = frames.angle_rad.shape[0], len(layout.angles), len(layout.scalars)
    points, segments = 3 * len(layout.points), len(layout.segments)
    width = 3 * angles + scalars + points + segments
    block = bytearray(_HEADER.size + 4 * ticks * width)
    _HEADER.pack_into(
        block,
        0,
        MAGIC,
        ticks,
        width,
        frames.first_tick % 2**32,
        frames.first_tick * frames.time_step_s,
        frames.time_step_s,
        time.time() if published_at_s is None else published_at_s,
    )
    rows = np.frombuffer(block, "<f4", offset=_HEADER.size).reshape(ticks, width)
    rows[:, :angles] = frames.angle_rad
    rows[:, angles : 2 * angles] = frames.angle_sigma_rad
    start = 2 * angles + scalars
    rows[:, 2 * angles : start] = frames.scalar
    # Not -1: a stretch without ticks has columns all the same.
    rows[:, start : start + points] = frames.point_room_m.reshape(ticks, points)
    rows[:, start + points : width - angles] = frames.segment_flags
    rows[:, width - angles :] = frames.angle_flags
    return bytes(block)


def layout_message(
    session_id: str, layout: FrameLayout, rate_hz: float, delay_ticks: float = 0
) -> LayoutMessage:
    """Return the message that names the columns."""
    return LayoutMessage(
        session_id=session_id,
        layout=FrameLayoutOut(
            segments=list(layout.segments),
            points=list(layout.points),
            angles=list(layout.angles),
            scalars=list(layout.scalars),
        ),
        columns=column_names(layout),
        rate_hz=rate_hz,
        delay_s=delay_ticks / rate_hz,
    )
