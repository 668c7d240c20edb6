"""Frames as bytes: what a session shows, stored so finely that a replay cannot be distinguished from it.

Each column is rounded to steps of a power of two that are chosen for it in every chunk:

- angles, lengths and orientations to 2^-14 and 2^-15 (60 and 30 millionths), and finer where their sigma asks for
  it: what is read back differs from what was written by less than a tenth of its sigma, however small that is;
- sigmas to a 500th of the least one, other numbers to 22 bits of the largest, so whole numbers stay whole;
- a column that this cannot hold (infinite, huge, or with a sigma of zero) is stored exactly.

Nothing clips. `signals.frame_kernel` holds the rules and the format; `frames-float32-shuffle-zstd/1`, which was written
before, is still read.
"""

from collections.abc import Sequence
from functools import lru_cache
from operator import attrgetter
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.recordings.signals import codecs
from app.recordings.signals import frame_kernel as kernel
from app.recordings.signals.bit_columns import room_words
from estimators.pipelines._contract import FrameLayout, Frames
from estimators.sentences import say

FRAMES_CODEC: Final = "frames-steps-rice/1"
FLOAT32_FRAMES_CODEC: Final = "frames-float32-shuffle-zstd/1"
_FIELDS: Final = {
    name: attrgetter(name)
    for name in (
        "q_room_segment",
        "point_room_m",
        "angle_rad",
        "angle_sigma_rad",
        "scalar",
        "segment_sigma_rad",
        "point_sigma_m",
    )
}
_FLAGS: Final = attrgetter("segment_flags"), attrgetter("angle_flags")


class Columns(NamedTuple):
    """The columns of one layout as they are stored.

    Attributes
    ----------
    kinds : ndarray of uint8, shape (C,)
        What each column holds, by place and by the unit in its name.
    pairs : ndarray of int64, shape (C,)
        Column of its sigma, -1 without.
    parts : dict
        By field of `Frames`: its columns, and its shape after the ticks.
    """

    kinds: NDArray[np.uint8]
    pairs: NDArray[np.int64]
    parts: dict[str, tuple[slice, tuple[int, ...]]]


@lru_cache(maxsize=256)
def columns_of(layout: FrameLayout, has_segment_sigma: bool, has_point_sigma: bool = False) -> Columns:
    """Return the columns of a layout; sigmas of segments and points are stored where a method gives them."""
    angles, scalars = len(layout.angles), layout.scalars
    fields: list[tuple[str, tuple[int, ...], int]] = [
        ("q_room_segment", (len(layout.segments), 4), kernel.COMPONENT),
        ("point_room_m", (len(layout.points), 3), kernel.METRE),
        ("angle_rad", (angles,), kernel.RADIAN),
        ("angle_sigma_rad", (angles,), kernel.SIGMA_RADIAN),
        ("scalar", (len(scalars),), kernel.OTHER),
    ]
    if has_segment_sigma:
        fields.append(("segment_sigma_rad", (len(layout.segments), 3), kernel.SIGMA_RADIAN))
    if has_point_sigma:
        fields.append(("point_sigma_m", (len(layout.points), 3), kernel.SIGMA_METRE))
    kinds: list[int] = []
    parts: dict[str, tuple[slice, tuple[int, ...]]] = {}
    for name, shape, kind in fields:
        start = len(kinds)
        kinds += [kind] * int(np.prod(shape))
        parts[name] = slice(start, len(kinds)), shape
    pairs = np.full(len(kinds), -1)
    first_angle, first_scalar = parts["angle_rad"][0].start, parts["scalar"][0].start
    pairs[first_angle : first_angle + angles] = np.arange(first_angle + angles, first_angle + 2 * angles)
    for number, name in enumerate(scalars):
        kinds[first_scalar + number] = _kind_of(name)
        sigma = f"{name.removesuffix('_rad')}_sigma_rad"
        if name.endswith("_rad") and sigma in scalars:
            pairs[first_scalar + number] = first_scalar + scalars.index(sigma)
    return Columns(np.array(kinds, np.uint8), pairs, parts)


def _kind_of(scalar: str) -> int:
    for suffix, kind in (
        ("_sigma_rad", kernel.SIGMA_RADIAN),
        ("_sigma_m", kernel.SIGMA_METRE),
        ("_rad", kernel.RADIAN),
        ("_m", kernel.METRE),
        ("_mps", kernel.METRE),
    ):
        if scalar.endswith(suffix):
            return kind
    return kernel.OTHER


def pack(parts: Sequence[Frames], stride: int = 1) -> tuple[bytes, int, dict[str, Any]]:
    """Return frames of consecutive ticks as bytes, how many they are, and what `unpack` needs besides.

    Parameters
    ----------
    parts : sequence of Frames
        At least one, of one layout, each beginning where the one before ends.
    stride : int
        Only ticks whose number it divides are stored; at least one must be among the parts. Flags of the others are
        joined into the stored tick before them, or after them at the start, so that no gap is lost.
    """
    first = parts[0]
    ticks = sum(map(len, map(_FLAGS[0], parts)))
    has_sigma = has_point_sigma = has_slipped = False
    for part in parts:
        # Looked at no longer than needed: most live frames have none.
        if part.segment_sigma_rad is not None and not has_sigma:
            has_sigma = bool(np.isfinite(part.segment_sigma_rad).any())
        if part.point_sigma_m is not None and not has_point_sigma:
            has_point_sigma = bool(np.isfinite(part.point_sigma_m).any())
        if part.slipped is not None:
            has_slipped = True
    columns = columns_of(first.layout, has_sigma, has_point_sigma)
    lead = -first.first_tick % stride
    rows = -(-(ticks - lead) // stride)
    table = np.empty((rows, len(columns.kinds)))
    for name, (place, shape) in columns.parts.items():
        values = list(map(_FIELDS[name], parts))
        if name in ("segment_sigma_rad", "point_sigma_m"):
            values = [
                np.full((len(part.segment_flags), *shape), np.nan) if value is None else value
                for part, value in zip(parts, values, strict=True)
            ]
        if stride > 1:
            values = [
                value[-part.first_tick % stride :: stride] for part, value in zip(parts, values, strict=True)
            ]
        np.concatenate(values, out=table[:, place].reshape(rows, *shape))
    segments, whole = len(first.layout.segments), len(first.layout.segments) + len(first.layout.angles)
    flags = np.empty((ticks, whole + has_slipped * (whole + len(first.layout.points))), np.uint8)
    np.concatenate(list(map(_FLAGS[0], parts)), out=flags[:, :segments])
    np.concatenate(list(map(_FLAGS[1], parts)), out=flags[:, segments:whole])
    if has_slipped:
        slipped = [np.concatenate(part.slipped_parts, axis=1) for part in parts]
        np.concatenate(slipped, out=flags[:, whole:], casting="unsafe")
    if stride > 1:
        flags = np.bitwise_or.reduceat(flags, [0, *range(lead + stride, ticks, stride)], axis=0)
    words = np.empty(room_words(len(table), table.shape[1] + flags.shape[1]), np.uint32)
    used = kernel.pack_frames(words, table, table.view(np.uint64), columns.kinds, columns.pairs, flags)
    scale = {
        "first_tick": first.first_tick + lead,
        "time_step_s": first.time_step_s,
        "floats": table.shape[1],
        "flags": flags.shape[1],
    }
    if has_sigma:
        scale["segment_sigma"] = True
    if has_point_sigma:
        scale["point_sigma"] = True
    if has_slipped:
        scale["slipped"] = True
    if stride > 1:
        scale["stride"] = stride
    return words[:used].tobytes(), len(table), scale


def stride_of(scale: dict[str, Any]) -> int:
    """Return how many ticks of the session lie from one frame of a chunk to the next."""
    return int(scale.get("stride", 1))


def unpack(codec: str, data: bytes, scale: dict[str, Any], ticks: int, layout: FrameLayout) -> Frames:
    """Restore frames; of a chunk with a stride they have the ticks of that coarser grid.

    Raises
    ------
    DamagedChunkError
        When the codec is unknown or the bytes are not those of such frames.
    """
    columns = columns_of(layout, bool(scale.get("segment_sigma")), bool(scale.get("point_sigma")))
    segments, stride = len(layout.segments), stride_of(scale)
    ticks //= stride
    whole, has_slipped = segments + len(layout.angles), bool(scale.get("slipped"))
    shapes = (
        (ticks, len(columns.kinds)),
        (ticks, whole + has_slipped * (whole + len(layout.points))),
    )
    if (shapes[0][1], shapes[1][1]) != (scale["floats"], scale["flags"]):
        raise codecs.DamagedChunkError(say("stored.layout"))
    if codec == FRAMES_CODEC:
        table, flags = np.empty(shapes[0]), np.empty(shapes[1], np.uint8)
        # A copy, because compiled code takes no read-only memory where it declares writable.
        words = np.frombuffer(data, np.uint32, len(data) // 4).copy()
        if len(data) % 4 or not kernel.unpack_frames(words, table, table.view(np.uint64), flags):
            raise codecs.DamagedChunkError(say("stored.cut_off"))
    elif codec == FLOAT32_FRAMES_CODEC:
        split = scale["head_bytes"]
        table = codecs.decode_floats(data[:split], *shapes[0]).astype(np.float64)
        flags = codecs.decode_flags(data[split:], *shapes[1])
    else:
        raise codecs.DamagedChunkError(say("stored.codec", codec=codec))
    values = {name: table[:, place].reshape(ticks, *shape) for name, (place, shape) in columns.parts.items()}
    return Frames(
        layout=layout,
        first_tick=scale["first_tick"] // stride,
        time_step_s=scale["time_step_s"] * stride,
        segment_flags=flags[:, :segments],
        angle_flags=flags[:, segments:whole],
        slipped=flags[:, whole:] != 0 if has_slipped else None,
        **values,
    )
