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
HEADER_BYTES: Final = _HEADER.size


class PublishedBlock:
    """A block that was made for all who watch, in a frame of a WebSocket from the server.

    Parameters
    ----------
    block : bytes
    """

    def __init__(self, block: bytes) -> None:
        self.block = block
        self.frame = server_frame_head(len(block)) + block


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
        self._frame: bytes | None = None

    @property
    def block(self) -> bytes:
        """The frames as a binary block, made once for all who watch."""
        if self._block is None:
            self._block = encode_block(self.frames, self.published_at_s)
        return self._block

    @property
    def frame(self) -> bytes:
        """The block in a frame of a WebSocket from the server, made once for all who watch."""
        if self._frame is None:
            self._frame = server_frame_head(len(self.block)) + self.block
        return self._frame


def server_frame_head(size: int) -> bytes:
    """Return what stands before a binary message of `size` bytes that a server sends whole (RFC 6455, 5.2)."""
    if size < 126:
        return bytes((0x82, size))
    if size < 1 << 16:
        return b"\x82\x7e" + size.to_bytes(2, "big")
    return b"\x82\x7f" + size.to_bytes(8, "big")


def block_header(
    ticks: int, columns: int, first_tick: int, time_step_s: float, published_at_s: float
) -> bytes:
    """Return the header of a block; see `app.live.messages`."""
    return _HEADER.pack(
        MAGIC, ticks, columns, first_tick % 2**32, first_tick * time_step_s, time_step_s, published_at_s
    )


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
    at_s = time.time() if published_at_s is None else published_at_s
    block[: _HEADER.size] = block_header(ticks, width, frames.first_tick, frames.time_step_s, at_s)
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
