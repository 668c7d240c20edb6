"""Marker files: C3D of an independent writer, other number formats, CSV, and what is refused in words."""

import struct
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.errors import RecordingFormatError
from app.readers import read_c3d, read_markers
from app.readers.markers.schemas import MarkerUploadIn

C3D = Path(__file__).parents[2] / "data" / "markers" / "three_points.c3d"


def declared(**changes: Any) -> MarkerUploadIn:
    return MarkerUploadIn(**{"segment": "hand_right", "format": "csv", **changes})


def test_a_c3d_file_of_another_program_is_read() -> None:
    points = read_c3d(C3D)
    t = np.arange(60) / 100.0
    assert points.labels == ("HAND1", "HAND2", "HAND3")
    assert points.rate_hz == 100.0
    expected = np.column_stack([np.sin(t), 0.5 * t, np.ones_like(t)])
    np.testing.assert_allclose(points.position_m[:, 0], expected, atol=1e-6)
    hidden = np.isnan(points.position_m[:, 1]).all(axis=1)
    assert np.flatnonzero(hidden).tolist() == list(range(20, 30))


def written(order: str, processor: int, is_real: bool, frames: int = 4) -> bytes:
    """Return a C3D file with one point, as the format's description has it."""

    def real(value: float) -> bytes:
        if processor != 85:
            return struct.pack(order + "f", value)
        raw = struct.pack("<f", value * 4.0)
        return raw[2:] + raw[:2]

    def parameter(group: int, name: str, kind: int, sizes: list[int], data: bytes) -> bytes:
        rest = struct.pack("bB", kind, len(sizes)) + bytes(sizes) + data + b"\x00"
        return (
            struct.pack("bb", len(name), group)
            + name.encode()
            + struct.pack(order + "H", len(rest) + 2)
            + rest
        )

    scale = -1.0 if is_real else 0.1
    section = bytes([0, 0, 1, processor])
    section += struct.pack("bb", 5, -1) + b"POINT" + struct.pack(order + "H", 3) + b"\x00"
    section += parameter(1, "UNITS", -1, [2], b"mm") + parameter(1, "LABELS", -1, [4, 1], b"TOE ")
    section += parameter(1, "SCALE", 4, [], real(scale)) + parameter(1, "RATE", 4, [], real(50.0))
    head = struct.pack("BB", 2, 0x50) + struct.pack(order + "5H", 1, 0, 1, frames, 0)
    head += real(scale) + struct.pack(order + "2H", 3, 0) + real(50.0)
    data = b""
    for k in range(frames):
        values = (10.0 * k, -20.0, 30.0, -1.0 if k == 2 else 0.0)
        if is_real:
            data += b"".join(real(v) for v in values)
        else:
            data += struct.pack(
                order + "4h", *(round(v / (scale if i < 3 else 1)) for i, v in enumerate(values))
            )
    return head.ljust(512, b"\x00") + section.ljust(512, b"\x00") + data


@pytest.mark.parametrize(("order", "processor"), [("<", 84), ("<", 85), (">", 86)])
@pytest.mark.parametrize("is_real", [True, False])
def test_every_number_format_is_read(tmp_path: Path, order: str, processor: int, is_real: bool) -> None:
    path = tmp_path / "a.c3d"
    path.write_bytes(written(order, processor, is_real))
    points = read_c3d(path)
    assert points.labels == ("TOE",)
    assert points.rate_hz == 50.0
    np.testing.assert_allclose(points.position_m[[0, 1, 3], 0, 0], [0.0, 0.01, 0.03], atol=1e-7)
    np.testing.assert_allclose(points.position_m[0, 0], [0.0, -0.02, 0.03], atol=1e-7)
    assert np.isnan(points.position_m[2]).all()


def test_damaged_c3d_files_are_refused(tmp_path: Path) -> None:
    raw = C3D.read_bytes()
    path = tmp_path / "a.c3d"
    for content, words in (
        (raw[:-600], "cut off"),
        (b"no" + raw[2:], "not a C3D file"),
        (raw.replace(b"mm", b"ft", 1), "in ft"),
        (raw[:100], "not a C3D file"),
    ):
        path.write_bytes(content)
        with pytest.raises(RecordingFormatError, match=words):
            read_c3d(path)
    # Whatever bytes are wrong: points, or words; nothing else and nothing endless.
    rng = np.random.default_rng(2)
    for _ in range(200):
        wrong = bytearray(raw)
        for at in rng.integers(0, 1400, 3):
            wrong[at] = int(rng.integers(256))
        path.write_bytes(bytes(wrong))
        with suppress(RecordingFormatError):
            assert read_c3d(path).position_m.ndim == 3


def test_csv_in_millimetres_with_y_up(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = ["time_s,TOE_x,TOE_y,TOE_z"] + [f"{5 + k / 100:.2f},{100 * k},1500,-30" for k in range(20)]
    rows[4] = "5.03,,,"
    path.write_text("\n".join(rows))
    tracks = read_markers(path, declared(up="y"))
    assert tracks.names == ("TOE",)
    np.testing.assert_allclose(np.diff(tracks.time_s), 0.01, atol=1e-9)
    np.testing.assert_allclose(tracks.position_m[1, 0], [0.1, 0.03, 1.5])
    assert np.isnan(tracks.of("TOE")[3]).all()
    with pytest.raises(RecordingFormatError, match="no marker HEEL; it has TOE"):
        tracks.of("HEEL")


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_every_turn_keeps_hands_and_points_up(tmp_path: Path, up: str) -> None:
    path = tmp_path / "a.csv"
    axis = "xyz".index(up[-1])
    vector = np.zeros(3)
    vector[axis] = -1.0 if up[0] == "-" else 1.0
    bases = [vector, *np.eye(3)]
    rows = ["A_x,A_y,A_z"] + [",".join(f"{v:g}" for v in b) for b in bases]
    path.write_text("\n".join(rows))
    found = read_markers(path, declared(up=up, unit="m", rate_hz=100.0)).of("A")
    np.testing.assert_allclose(found[0], [0.0, 0.0, 1.0])
    assert np.linalg.det(found[1:].T) == pytest.approx(1.0)


def test_csv_that_cannot_be_right_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time_s,TOE_x,TOE_y\n0,1,2\n1,2,3\n")
    with pytest.raises(RecordingFormatError, match="NAME_x, NAME_y and NAME_z"):
        read_markers(path, declared())
    path.write_text("TOE_x,TOE_y,TOE_z\n1500,2,3\n1500,2,3\n")
    with pytest.raises(RecordingFormatError, match="no column time_s"):
        read_markers(path, declared())
    with pytest.raises(RecordingFormatError, match="look like mm or cm"):
        read_markers(path, declared(unit="m", rate_hz=100.0))
