"""Frames as the binary blocks of `app.live.messages`, and the layout message that names their columns."""

import struct
import time
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from app.live.messages import LayoutMessage
from app.recordings.schemas import FrameLayoutOut
from estimators.pipelines._contract import FrameLayout, Frames

MAGIC: Final = b"TMF1"
_HEADER: Final = struct.Struct("<4sIIIddd")


@dataclass(frozen=True)
class PublishedFrames(Frames):
    """Frames with the moment they were given to the bus.

    Attributes
    ----------
    published_at_s : float
        Server time since the epoch.
    """

    published_at_s: float = 0.0

    @cached_property
    def block(self) -> bytes:
        """The frames as a binary block, made once for all who watch."""
        return encode_block(self)


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


def encode_block(frames: Frames) -> bytes:
    """Return frames as one binary block.

    Parameters
    ----------
    frames : Frames
        `PublishedFrames` carry their own time of publication; others get the present.
    """
    ticks = frames.tick_count
    rows = np.concatenate(
        [
            frames.angle_rad,
            frames.angle_sigma_rad,
            frames.scalar,
            # Not -1: a stretch without ticks has columns all the same.
            frames.point_room_m.reshape(ticks, 3 * len(frames.layout.points)),
            frames.segment_flags,
            frames.angle_flags,
        ],
        axis=1,
    ).astype("<f4")
    published = frames.published_at_s if isinstance(frames, PublishedFrames) else time.time()
    header = _HEADER.pack(
        MAGIC,
        ticks,
        rows.shape[1],
        frames.first_tick % 2**32,
        frames.first_tick * frames.time_step_s,
        frames.time_step_s,
        published,
    )
    return header + rows.tobytes()


def layout_message(
    session_id: str, layout: FrameLayout, rate_hz: float, delay_ticks: int = 0
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
