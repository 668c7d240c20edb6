"""Files of a few kilobytes that would unpack to gigabytes are refused before anything of it is in memory."""

import struct
import tracemalloc
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from app import readers
from app.errors import RecordingFormatError
from app.readers.unpacked import check_mat
from tests.said import codes

GIB = 1 << 30


def bomb(path: Path, unpacked_bytes: int, *, stated_bytes: int | None = None, mark: bytes = b"IM") -> Path:
    """A `.mat` file with one variable of zeros that is packed a thousand times smaller."""
    packer = zlib.compressobj(9)
    # 48 bytes: array flags, dimensions, the name `t`, and the tag of the numbers.
    numbers = unpacked_bytes - 56
    head = struct.pack("<II", 14, unpacked_bytes - 8 if stated_bytes is None else stated_bytes)
    head += struct.pack("<IIIIIIii", 6, 8, 6, 0, 5, 8, numbers // 8, 1)
    head += struct.pack("<HH4s", 1, 1, b"t\0\0\0") + struct.pack("<II", 9, numbers)
    data = packer.compress(head)
    zeros = bytes(1 << 20)
    for _ in range(unpacked_bytes >> 20):
        data += packer.compress(zeros)
    data += packer.flush()
    header = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H2s", 0x0100, mark)
    path.write_bytes(header + struct.pack("<II", 15, len(data)) + data)
    return path


@pytest.mark.slow
@pytest.mark.parametrize("stated_bytes", [None, 1000])
def test_a_mat_bomb_is_refused_with_both_sizes(tmp_path: Path, stated_bytes: int | None) -> None:
    path = bomb(tmp_path / "bomb.mat", GIB + (8 << 20), stated_bytes=stated_bytes)
    assert path.stat().st_size < 2 << 20
    tracemalloc.start()
    try:
        with pytest.raises(
            RecordingFormatError, match=r"has 1\.0 MiB and unpacks to more than 1024 MiB"
        ) as found:
            readers.read(path, "qmt_mat")
        assert tracemalloc.get_traced_memory()[1] < 8 << 20
    finally:
        tracemalloc.stop()
    assert found.value.details["limit_bytes"] == GIB


@pytest.mark.parametrize("mark", [b"XX", b"im", b"II", b"MM", b"IX", b"\0\0", b"  "])
def test_a_mat_file_of_no_known_byte_order_is_not_read(tmp_path: Path, mark: bytes) -> None:
    path = bomb(tmp_path / "bomb.mat", 96 << 20, mark=mark)
    tracemalloc.start()
    try:
        with pytest.raises(RecordingFormatError) as found:
            readers.read(path, "qmt_mat")
        assert tracemalloc.get_traced_memory()[1] < 8 << 20
    finally:
        tracemalloc.stop()
    assert codes(found.value.sentence) == ["mat.unreadable"]


def test_a_mat_file_of_the_other_byte_order_is_measured(tmp_path: Path) -> None:
    path = tmp_path / "sound.mat"
    data = zlib.compress(bytes(20_000))
    header = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack(">H2s", 0x0100, b"MI")
    path.write_bytes(header + struct.pack(">II", 15, len(data)) + data)
    with pytest.raises(RecordingFormatError, match="unpacks to more than"):
        check_mat(path, 10_000)


def test_a_sound_compressed_mat_file_is_counted_rightly(tmp_path: Path) -> None:
    path = tmp_path / "sound.mat"
    scipy.io.savemat(path, {"a": np.zeros(1000), "b": np.ones((50, 2))}, do_compression=True)
    check_mat(path, 10_000)
    with pytest.raises(RecordingFormatError):
        check_mat(path, 8_000)


def broad(path: Path, **options: object) -> Path:
    with h5py.File(path, "w") as file:
        for name in ("imu_gyr", "imu_acc", "imu_mag", "opt_quat", "movement", "sampling_rate"):
            file.create_dataset(name, (100, 3), **({"dtype": "f8"} | options))
    return path


def test_an_hdf5_file_that_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.hdf5"
    with h5py.File(path, "w") as file:
        file.create_dataset("imu_gyr", (1 << 27, 3), dtype="f8", chunks=(1 << 16, 3), compression="gzip")
    assert path.stat().st_size < 1 << 20
    with pytest.raises(RecordingFormatError, match="unpacks to more than"):
        readers.read(path, "broad")


def test_an_hdf5_file_with_one_huge_chunk_is_refused(tmp_path: Path) -> None:
    path = broad(tmp_path / "chunk.hdf5", maxshape=(None, 3), chunks=(1 << 25, 3), dtype="f8")
    with pytest.raises(RecordingFormatError, match="unpacks to more than"):
        readers.read(path, "broad")


def test_an_hdf5_file_cannot_read_other_files(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_bytes(bytes(2400))
    path = broad(tmp_path / "outside.hdf5", external=[(str(secret), 0, 2400)], dtype="f8")
    with pytest.raises(RecordingFormatError, match="must be in the file itself"):
        readers.read(path, "broad")
    other = tmp_path / "linked.hdf5"
    with h5py.File(other, "w") as file:
        file["imu_gyr"] = h5py.ExternalLink(str(broad(tmp_path / "inside.hdf5")), "imu_gyr")
    with pytest.raises(RecordingFormatError, match="must be in the file itself"):
        readers.read(other, "broad")
