"""Files of the formats that the readers know, written from real excerpts and simulated sessions."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from app import readers
from estimators.simulation import SimulatedSession

DATA = Path(__file__).parents[2] / "data"
FEET = DATA / "feet"
BROAD = DATA / "broad" / "fast_combined_15s.npz"
G = 9.80665


def pyshoe(path, **changes):
    content = np.load(FEET / "pyshoe_walk.npz")
    given = {
        "imu_data": np.concatenate([content["accelerometer_mps2"], content["gyroscope_radps"]], axis=1),
        "timestamps_all": content["time_s"][None, :] + 5.0,
        "gt": content["position_xy_m"] * [1.0, -1.0],
    }
    scipy.io.savemat(path, {k: v for k, v in (given | changes).items() if v is not None})
    return path


def xio(path, edit=lambda rows: None, header=None, count=3000):
    content = np.load(FEET / "xio_short_walk.npz")
    table = np.concatenate(
        [
            content["time_s"][:count, None],
            np.rad2deg(content["gyroscope_radps"][:count]),
            content["accelerometer_mps2"][:count] / G,
        ],
        axis=1,
    )
    edit(table)
    names = (
        ["Time (s)"] + [f"Gyroscope {a} (deg/s)" for a in "XYZ"] + [f"Accelerometer {a} (g)" for a in "XYZ"]
    )
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header or names)
        writer.writerows(table.tolist())
    return path


def gaitmap_rows(side, count=2000):
    content = np.load(FEET / "gaitmap_strides.npz")
    return np.concatenate(
        [
            content[f"accelerometer_{side}_mps2"][:count],
            np.rad2deg(content[f"gyroscope_{side}_radps"][:count]),
        ],
        axis=1,
    )


def gaitmap(folder, truth=True):
    axes = ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
    folder.mkdir(exist_ok=True)
    both = np.concatenate([gaitmap_rows("left"), gaitmap_rows("right")], axis=1)
    with (folder / "imu_sample.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["sensor", *["left_sensor"] * 6, *["right_sensor"] * 6])
        writer.writerow(["axis", *axes, *axes])
        writer.writerows([i, *row] for i, row in enumerate(both.tolist()))
    if truth:
        markers = [f"{side}_{name}" for side in "LR" for name in ("TOE", "FCC", "FM5")]
        with (folder / "mocap_sample.csv").open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["", *[m for m in markers for _ in "xyz"]])
            writer.writerow(["", *"xyz" * 6])
            writer.writerows([i, *range(18)] for i in range(900))
        (folder / "stride_events_sample.csv").write_text(
            "s_id,foot,start,end,ic,tc,min_vel,pre_ic\n0,left,494.0,709.0,657.0,586.0,494.0,438.0\n"
            "1,right,600.0,800.0,757.0,686.0,600.0,500.0\n"
        )
    return folder / "imu_sample.csv"


def as_csv(simulated: SimulatedSession, path: Path) -> dict[str, Any]:
    columns = {"time": next(iter(simulated.recording.sensors.values())).time_s * 1e3}
    signals = []
    for name, s in simulated.recording.sensors.items():
        for quantity, values, unit, factor in (
            ("gyroscope", s.gyroscope_radps, "deg/s", 180 / np.pi),
            ("accelerometer", s.accelerometer_mps2, "m/s^2", 1.0),
            ("magnetometer", s.magnetometer_t, "uT", 1e6),
        ):
            names = [f"{name} {quantity} {axis}" for axis in "xyz"]
            columns.update(zip(names, (values * factor).T, strict=True))
            signals.append({"placement": name, "quantity": quantity, "columns": names, "unit": unit})
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header=",".join(columns), comments="")
    return {"format": "csv", "csv": {"time_column": "time", "time_unit": "ms", "signals": signals}}


def as_whole_body(simulated: SimulatedSession, path: Path) -> dict[str, Any]:
    theirs = {ours: name for name, ours in readers.PLACEMENT_OF.items()}
    content: dict[str, Any] = {"t": next(iter(simulated.recording.sensors.values())).time_s}
    for name, s in simulated.recording.sensors.items():
        content[theirs[name]] = {"acc": s.accelerometer_mps2, "gyr": s.gyroscope_radps}
    scipy.io.savemat(path, content, appendmat=False)
    return {"format": "qmt_mat"}


def broad_content() -> dict[str, Any]:
    with np.load(BROAD) as data:
        return {
            "imu_gyr": data["gyroscope_radps"],
            "imu_acc": data["accelerometer_mps2"],
            "imu_mag": data["magnetometer_ut"],
            "opt_quat": data["q_earth_sensor_optical"],
            "movement": data["movement"].astype(np.uint8),
            "sampling_rate": float(data["sampling_rate_hz"]),
        }
