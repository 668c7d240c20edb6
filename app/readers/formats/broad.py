"""Trials of the BROAD benchmark (`.mat` or `.hdf5`): one sensor and optical truth, for single-sensor work."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from app.errors import RecordingFormatError
from app.readers.contract import Reader, Source
from app.readers.mat import load_mat
from app.readers.units import check_accelerometer, check_gyroscope, check_magnetometer
from app.readers.unpacked import check_hdf5
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import Sentence, say

if TYPE_CHECKING:
    import h5py

_NAMES = ["imu_gyr", "imu_acc", "imu_mag", "opt_quat", "movement", "sampling_rate"]
_HDF5 = b"\x89HDF"
_OF_APDM = frozenset(
    {"Sensors", "MonitorLabelList", "CaseIdList", "FileFormatVersion", "File_Format_Version"}
)


def read_broad(path: Path) -> Recording:
    """Read one trial.

    Returns
    -------
    Recording
        One sensor named `imu`; `reference` holds `q_earth_sensor` (optical, NaN in its gaps) and
        `is_movement`, the samples that count in a score.

    Raises
    ------
    RecordingFormatError
        Not a trial of this set.
    """
    content = _hdf5(path) if _is_hdf5(path) else load_mat(path, _NAMES)
    missing = [name for name in _NAMES if name not in content]
    if missing:
        raise RecordingFormatError(say("file.not_this_kind", missing=missing, kind="broad"))
    try:
        gyroscope = _table(content["imu_gyr"], 3)
        accelerometer = _table(content["imu_acc"], 3)
        field_t = _table(content["imu_mag"], 3) * 1e-6
        optical = _table(content["opt_quat"], 4)
        rate_hz = float(np.asarray(content["sampling_rate"]).reshape(-1)[0])
        movement = np.asarray(content["movement"]).reshape(-1).astype(bool)
    except (ValueError, TypeError) as error:
        raise RecordingFormatError(say("file.arrays_not_this_kind", kind="broad")) from error
    samples = gyroscope.shape[0]
    if not (accelerometer.shape[0] == field_t.shape[0] == optical.shape[0] == movement.size == samples):
        raise RecordingFormatError(say("file.array_lengths"))
    if not 1.0 <= rate_hz <= 10_000.0:
        raise RecordingFormatError(say("file.rate_impossible", rate_hz=rate_hz))
    check_gyroscope(gyroscope, "rad/s", "imu")
    check_accelerometer(accelerometer, 1.0 / rate_hz, "m/s^2", "imu")
    check_magnetometer(field_t, "T", "imu")
    return Recording(
        {"imu": SensorSignals(np.arange(samples) / rate_hz, gyroscope, accelerometer, field_t)},
        rate_hz,
        origin="BROAD trial",
        metadata={"format": "broad", "trial": path.stem},
        reference={"q_earth_sensor": optical, "is_movement": movement},
    )


def _table(values: Any, width: int) -> Float:
    table = np.asarray(values, dtype=np.float64)
    if table.ndim != 2 or table.shape[1] != width:
        raise ValueError(f"shape {table.shape}")
    return table


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) == _HDF5


def _hdf5(path: Path) -> dict[str, Any]:
    try:
        import h5py

        with h5py.File(path, "r") as file:
            if _NAMES[0] not in file:
                raise RecordingFormatError(_other(file))
            check_hdf5(file, _NAMES)
            content = {name: file[name][()] for name in _NAMES if name in file}
            for name in _NAMES:
                if name in file.attrs:
                    content[name] = file.attrs[name]
    except (OSError, RuntimeError, KeyError) as error:
        raise RecordingFormatError(say("file.hdf5_unreadable")) from error
    return content


def _other(file: "h5py.File") -> Sentence:
    """Return what an HDF5 is that is no trial of this set, and what to export instead."""
    if _OF_APDM & {*file, *file.attrs}:
        return say("file.hdf5_of_sensors")
    return say("file.hdf5_unknown", names=[str(name)[:60] for name in list(file)[:6]])


def _instead(start: bytes) -> Sentence | None:
    """Return what an HDF5 is instead of a trial, by the names in its first bytes: a damaged one is not opened."""
    if _NAMES[0].encode() in start:
        return None
    is_of_sensors = any(name.encode() in start for name in _OF_APDM)
    return say("file.hdf5_of_sensors") if is_of_sensors else say("table.not_text")


class BroadReader(Reader):
    """A trial of the BROAD benchmark."""

    title = "BROAD trial (.mat, .hdf5)"
    description = "One sensor with its optical truth"
    endings = frozenset({".mat", ".hdf5"})
    pipeline = "orientation"
    placements = ("imu",)

    def recognises(self, source: Source) -> bool:
        """By its first bytes, or the names of its variables."""
        return source.start.startswith(_HDF5) or "imu_gyr" in source.variables

    def against(self, source: Source) -> Sentence | None:
        """Return which other HDF5 it is, by the names in it."""
        return _instead(source.start) if source.start.startswith(_HDF5) else None

    def read(self, source: Source) -> Recording:
        """Read one trial."""
        return read_broad(source.path)
