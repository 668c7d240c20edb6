"""Points of C3D files: Intel, DEC and MIPS, real and integer storage. Strict: what is not whole is refused.

The binary layout is that of the C3D user guide (c3d.org): a header block, a parameter section of groups, and frames of
points followed by analogue samples, which are passed over.
"""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from estimators.recording import Float
from estimators.sentences import say

_BLOCK: Final = 512
_KEY: Final = 0x50
_INTEL, _DEC, _MIPS = 84, 85, 86
MAX_POINTS: Final = 1000
MAX_POINT_VALUES: Final = 100_000_000
_METRES: Final = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
_BROKEN: Final = say("c3d.damaged")


@dataclass(frozen=True)
class C3dPoints:
    """What a C3D file holds of points.

    Attributes
    ----------
    position_m : ndarray, shape (N, P, 3)
        Axes of the laboratory as the file has them; NaN where a point was not seen.
    """

    labels: tuple[str, ...]
    rate_hz: float
    position_m: Float


def read_c3d(path: Path) -> C3dPoints:
    """Read the points of a C3D file.

    Raises
    ------
    RecordingFormatError
        No C3D file, one without points or unit, or one that is damaged or cut off.
    """
    raw = path.read_bytes()
    if len(raw) < 2 * _BLOCK or raw[1] != _KEY:
        raise RecordingFormatError(say("c3d.not_c3d"))
    begin = (raw[0] - 1) * _BLOCK
    if begin < _BLOCK or begin + 4 > len(raw):
        raise RecordingFormatError(_BROKEN)
    processor = raw[begin + 3]
    if processor not in (_INTEL, _DEC, _MIPS):
        raise RecordingFormatError(say("c3d.processor", processor=processor))
    order = ">" if processor == _MIPS else "<"
    groups = _parameters(raw[begin : begin + max(1, raw[begin + 2]) * _BLOCK], processor, order)
    point = groups.get("POINT", {})
    count, analogue, first, last = struct.unpack_from(order + "4H", raw, 2)
    scale = _number(point, "SCALE", _floats(raw[12:16], processor)[0])
    block = int(_number(point, "DATA_START", struct.unpack_from(order + "H", raw, 16)[0])) & 0xFFFF
    rate_hz = _number(point, "RATE", _floats(raw[20:24], processor)[0])
    if not 1 <= count <= MAX_POINTS:
        raise RecordingFormatError(say("c3d.points", points=count, most=MAX_POINTS))
    if not 1.0 <= rate_hz <= 10_000.0:
        raise RecordingFormatError(say("c3d.rate", rate_hz=rate_hz))
    unit = str((point.get("UNITS") or [""])[0]).strip().lower()
    if unit not in _METRES:
        raise RecordingFormatError(
            say("c3d.unit", unit=unit, units=list(_METRES))
            if unit
            else say("c3d.no_unit", units=list(_METRES))
        )
    frames = _frame_count(groups, first, last)
    position = _points(raw, max(block - 1, 0) * _BLOCK, frames, count, analogue, scale, processor)
    return C3dPoints(_labels(point, count), rate_hz, position * _METRES[unit])


def _parameters(section: bytes, processor: int, order: str) -> dict[str, dict[str, list[Any]]]:
    """Read the groups: name of the group to names and values of its parameters."""
    names: dict[int, str] = {}
    found: dict[int, dict[str, list[Any]]] = {}
    at = 4
    try:
        while at < len(section):
            length, group = (
                abs(struct.unpack_from("b", section, at)[0]),
                struct.unpack_from("b", section, at + 1)[0],
            )
            if length == 0 or group == 0:
                break
            name = section[at + 2 : at + 2 + length].decode("ascii", "replace").strip().upper()
            step_at = at + 2 + length
            step = struct.unpack_from(order + "H", section, step_at)[0]
            if group < 0:
                names[-group] = name
            else:
                found.setdefault(group, {})[name] = _value(section, step_at + 2, processor, order)
            if step == 0:
                break
            at = step_at + step
    except (struct.error, IndexError, ValueError) as error:
        raise RecordingFormatError(_BROKEN) from error
    return {names.get(number, str(number)): values for number, values in found.items()}


def _value(section: bytes, at: int, processor: int, order: str) -> list[Any]:
    kind, dimensions = struct.unpack_from("bB", section, at)
    sizes = list(section[at + 2 : at + 2 + dimensions])
    if len(sizes) != dimensions or kind not in (-1, 1, 2, 4):
        raise ValueError
    count = int(np.prod(sizes, dtype=np.int64)) if sizes else 1
    start = at + 2 + dimensions
    data = section[start : start + count * abs(kind)]
    if len(data) != count * abs(kind):
        raise ValueError
    if kind == -1:
        width = sizes[0] if sizes else 1
        pieces = [data[i : i + width] for i in range(0, len(data), width)] if width else []
        return [piece.decode("utf-8", "replace").strip("\x00 ") for piece in pieces]
    if kind == 4:
        return list(_floats(data, processor).tolist())
    if kind == 2:
        return list(np.frombuffer(data, order + "i2").tolist())
    return list(data)


def _floats(data: bytes, processor: int) -> NDArray[np.float64]:
    if processor == _DEC:
        # A VAX float has its halves the other way round and an exponent that is two higher.
        words = np.frombuffer(data, "<u2").reshape(-1, 2)[:, ::-1]
        return np.ascontiguousarray(words).view("<f4").ravel().astype(np.float64) / 4.0
    return np.frombuffer(data, ">f4" if processor == _MIPS else "<f4").astype(np.float64)


def _number(group: dict[str, list[Any]], name: str, otherwise: float) -> float:
    values = group.get(name)
    return float(values[0]) if values and isinstance(values[0], int | float) else float(otherwise)


def _labels(point: dict[str, list[Any]], count: int) -> tuple[str, ...]:
    """Return a name for each point: long lists continue in LABELS2 and so on; a nameless one is numbered."""
    names: list[str] = []
    for number in range(1, 10):
        names += [str(name) for name in point.get(f"LABELS{number if number > 1 else ''}", [])]
    names = (names + [""] * count)[:count]
    return tuple(name or f"point {number + 1}" for number, name in enumerate(names))


def _frame_count(groups: dict[str, dict[str, list[Any]]], first: int, last: int) -> int:
    """Return the frames of the file: the header counts to 65535 only, longer ones tell elsewhere."""
    trial, point = groups.get("TRIAL", {}), groups.get("POINT", {})
    ends = [trial.get("ACTUAL_START_FIELD"), trial.get("ACTUAL_END_FIELD")]
    if all(end is not None and len(end) >= 2 for end in ends):
        low, high = ((int(end[0]) & 0xFFFF) + ((int(end[1]) & 0xFFFF) << 16) for end in ends if end)
        counted = high - low + 1
    else:
        counted = last - first + 1
        if last == 0xFFFF:
            stated = _number(point, "FRAMES", counted)
            counted = int(_number(point, "LONG_FRAMES", stated + 65536 if stated < 0 else stated))
    if counted < 1:
        raise RecordingFormatError(say("c3d.no_frames"))
    return counted


def _points(
    raw: bytes, start: int, frames: int, count: int, analogue: int, scale: float, processor: int
) -> Float:
    order, is_real = ">" if processor == _MIPS else "<", scale < 0.0
    width = 4 * count + analogue
    size = frames * width * (4 if is_real else 2)
    if frames * count * 4 > MAX_POINT_VALUES:
        raise RecordingFormatError(say("file.too_long"))
    if start < _BLOCK or start + size > len(raw):
        raise RecordingFormatError(say("c3d.cut_off", frames=frames))
    data = raw[start : start + size]
    if is_real:
        table = _floats(data, processor).reshape(frames, width)[:, : 4 * count].reshape(frames, count, 4)
        seen = table[..., 3] >= 0.0
        position = table[..., :3]
    else:
        words = np.frombuffer(data, order + "i2").reshape(frames, width)[:, : 4 * count]
        table = words.reshape(frames, count, 4).astype(np.float64)
        seen = table[..., 3] >= 0.0
        position = table[..., :3] * abs(scale)
    # Some programs write lost points as zeros without saying so: a marker is never exactly at the origin.
    seen &= np.isfinite(position).all(axis=-1) & (position != 0.0).any(axis=-1)
    return np.where(seen[..., None], position, np.nan)
