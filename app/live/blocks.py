"""Frames as the binary blocks of `app.live.messages`, and the layout message that names their columns."""

import time
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.live.messages import LayoutMessage
from app.network.lean_sockets import LONG, LONGEST_MEDIUM, MEDIUM, WHOLE_BINARY, frame_head
from app.recordings.schemas import FrameLayoutOut
from estimators.pipelines._contract import FrameLayout, Frames

MAGIC: Final = b"TMF1"
_FRAME_HEAD: Final = 4
"""Bytes before a message of 126 to 65535 bytes, as a server sends it whole (RFC 6455, 5.2)."""
_HEAD: Final = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "u1"),
        ("size", ">u2"),
        ("magic", "S4"),
        ("ticks", "<u4"),
        ("columns", "<u4"),
        ("first_tick", "<u4"),
        ("time_s", "<f8"),
        ("time_step_s", "<f8"),
        ("published_at_s", "<f8"),
    ]
)
HEAD_WORDS: Final = _HEAD.itemsize // 4
"""Of a block's head with that of its frame."""
_HEADER_BYTES: Final = _HEAD.itemsize - _FRAME_HEAD
_FRAME_HEADS: Final = {MEDIUM: _FRAME_HEAD, LONG: 10}


class PublishedBlock:
    """A block that was made for all who watch, in a frame of a WebSocket from the server.

    Parameters
    ----------
    written : bytes
        The block, behind the head of `block_heads`.
    """

    def __init__(self, written: bytes) -> None:
        size = len(written) - _FRAME_HEAD
        if not MEDIUM <= size <= LONGEST_MEDIUM:
            written = frame_head(WHOLE_BINARY, size) + written[_FRAME_HEAD:]
        self.frame = written

    @property
    def block(self) -> bytes:
        """The block by itself."""
        return self.frame[_FRAME_HEADS.get(self.frame[1], 2) :]


class PublishedFrames:
    """Frames with the moment they were given to the bus.

    Parameters
    ----------
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
            self._frame = frame_head(WHOLE_BINARY, len(self.block)) + self.block
        return self._frame


def block_heads(
    ticks: NDArray[np.int64],
    columns: int,
    first_ticks: NDArray[np.int64],
    time_step_s: float,
    published_at_s: float,
) -> NDArray[np.uint32]:
    """Return the headers of many blocks, each behind the head of its frame, shape (N, HEAD_WORDS).

    Parameters
    ----------
    ticks, first_ticks : ndarray of int64, shape (N,)
    """
    words = np.empty((len(ticks), HEAD_WORDS), dtype=np.uint32)
    _fill_heads(_heads_of(words), ticks, columns, first_ticks, time_step_s, published_at_s)
    return words


def _heads_of(words: NDArray[Any]) -> NDArray[np.void]:
    """Return memory as heads: `ndarray.view` would ask in Python whether records may lie there."""
    return np.ndarray(words.size // HEAD_WORDS, _HEAD, words.data)


def _fill_heads(
    heads: NDArray[np.void],
    ticks: int | NDArray[np.int64],
    columns: int,
    first_ticks: int | NDArray[np.int64],
    time_step_s: float,
    published_at_s: float,
) -> None:
    heads["opcode"], heads["length"] = WHOLE_BINARY, MEDIUM
    # Shorter and longer blocks get another head of their frame, see `PublishedBlock`.
    heads["size"] = (_HEADER_BYTES + 4 * ticks * columns) & LONGEST_MEDIUM
    heads["magic"], heads["ticks"], heads["columns"] = MAGIC, ticks, columns
    heads["first_tick"] = first_ticks % 2**32
    heads["time_s"], heads["time_step_s"] = first_ticks * time_step_s, time_step_s
    heads["published_at_s"] = published_at_s


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
    published_at_s : float, optional
        By default the present.
    """
    layout = frames.layout
    ticks, angles, scalars = frames.angle_rad.shape[0], len(layout.angles), len(layout.scalars)
    points, segments = 3 * len(layout.points), len(layout.segments)
    width = 3 * angles + scalars + points + segments
    at_s = time.time() if published_at_s is None else published_at_s
    words = np.empty(HEAD_WORDS + ticks * width, "<f4")
    head = _heads_of(words[:HEAD_WORDS])
    _fill_heads(head, ticks, width, frames.first_tick, frames.time_step_s, at_s)
    rows = words[HEAD_WORDS:].reshape(ticks, width)
    rows[:, :angles] = frames.angle_rad
    rows[:, angles : 2 * angles] = frames.angle_sigma_rad
    start = 2 * angles + scalars
    rows[:, 2 * angles : start] = frames.scalar
    # Not -1: a stretch without ticks has columns all the same.
    rows[:, start : start + points] = frames.point_room_m.reshape(ticks, points)
    is_sound = frames.slipped is None
    rows[:, start + points : width - angles] = frames.segment_flags if is_sound else frames.segment_bits
    rows[:, width - angles :] = frames.angle_flags if is_sound else frames.angle_bits
    return words[_FRAME_HEAD // 4 :].tobytes()


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
