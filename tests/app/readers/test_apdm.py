"""Recordings as APDM's software exports them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app import readers
from app.errors import RecordingFormatError
from estimators.recording import Recording, SensorSignals
from estimators.simulation import SimulatedSession
from tests.said import codes

DATA = Path(__file__).parents[2] / "data" / "tables" / "opensense_imu.csv"
LABEL_OF = {"pelvis": "Lumbar", "sternum": "Sternum", "forearm": "Wrist"}


def label_of(placement: str) -> str:
    part, _, side = placement.rpartition("_")
    if side not in ("left", "right"):
        return LABEL_OF.get(placement, placement.title())
    return f"{side.title()} {LABEL_OF.get(part, part.replace('_', ' ').title())}"


def apdm(path: Path, recording: Recording, units: tuple[str, str, str] = ("m/s^2", "rad/s", "uT")) -> Path:
    first = next(iter(recording.sensors.values()))
    names, unit_row, columns = ["Time"], ["s"], [first.time_s[:, np.newaxis]]
    for placement, sensor in recording.sensors.items():
        quantities = [
            ("Acceleration", sensor.accelerometer_mps2),
            ("Angular Velocity", sensor.gyroscope_radps),
        ]
        if sensor.magnetometer_t is not None:
            quantities.append(("Magnetic Field", 1e6 * sensor.magnetometer_t))
        for (quantity, values), unit in zip(quantities, units, strict=False):
            names += [f"{label_of(placement)}/{quantity}/{axis}" for axis in "XYZ"]
            unit_row += [unit] * 3
            columns.append(values)
        if sensor.temperature_degc is not None:
            names.append(f"{label_of(placement)}/Temperature/Scalar")
            unit_row.append("deg C")
            columns.append(sensor.temperature_degc[:, np.newaxis])
    rows = np.concatenate(columns, axis=1)
    blank = "," * (len(names) - 3)
    head = [f"Test Name:,Arm,{blank}", f"Sample Rate:,{recording.nominal_rate_hz},Hz{blank}", ",".join(names)]
    lines = [",".join("" if np.isnan(value) else f"{value:.9g}" for value in row) for row in rows]
    path.write_text("\n".join([*head, ",".join(unit_row), *lines]) + "\n")
    return path


def example(folder: Path, simulated: SimulatedSession) -> Path:
    """Write the file of `test_same_numbers.py`: processed and uploaded, it gives the same numbers."""
    return apdm(folder / "arm.csv", simulated.recording)


def made(temperature: bool = True) -> Recording:
    rng = np.random.default_rng(1)
    sensors = {
        name: SensorSignals(
            np.arange(200) / 128.0,
            rng.normal(0.0, 1.0, (200, 3)),
            rng.normal((0.0, 0.0, 9.8), 1.0, (200, 3)),
            rng.normal((2e-5, 0.0, -4e-5), 1e-6, (200, 3)),
            temperature_degc=np.linspace(21.0, 25.0, 200) if temperature else None,
        )
        for name in ("pelvis", "forearm_left", "thigh_right")
    }
    return Recording(sensors, 128.0)


def test_a_file_of_the_maker_is_read_as_it_stands() -> None:
    assert readers.guess(DATA) == "apdm"
    found = readers.read(DATA)
    assert list(found.sensors) == ["static", "upper", "middle", "lower"]
    assert found.nominal_rate_hz == pytest.approx(128.0)
    seen = readers.preview_text(DATA.name, readers.start_of(DATA))
    assert (seen.format, seen.pipeline, seen.guess) == ("apdm", "orientation", None)
    lines = DATA.read_text().splitlines()
    first = dict(zip(lines[2].split(","), lines[4].split(","), strict=True))
    upper = found.sensors["upper"]
    assert upper.gyroscope_radps[0, 1] == float(first["Upper/Angular Velocity/Y"])
    assert upper.accelerometer_mps2[0, 2] == float(first["Upper/Acceleration/Z"])
    assert upper.magnetometer_t[0, 0] == pytest.approx(1e-6 * float(first["Upper/Magnetic Field/X"]))
    assert upper.temperature_degc[0] == float(first["Upper/Temperature/Scalar"])


def test_labels_of_the_maker_are_placements(tmp_path: Path) -> None:
    recording = made()
    found = readers.read(apdm(tmp_path / "a.csv", recording))
    assert list(found.sensors) == list(recording.sensors)
    for name, sensor in recording.sensors.items():
        np.testing.assert_allclose(found.sensors[name].gyroscope_radps, sensor.gyroscope_radps, rtol=1e-7)
        np.testing.assert_allclose(
            found.sensors[name].magnetometer_t, sensor.magnetometer_t, rtol=1e-6, atol=1e-14
        )
        np.testing.assert_allclose(found.sensors[name].temperature_degc, sensor.temperature_degc, rtol=1e-7)


def test_other_units_are_read_and_wrong_ones_refused(tmp_path: Path) -> None:
    recording = made(temperature=False)
    scaled = {
        name: replace(sensor, accelerometer_mps2=sensor.accelerometer_mps2 / 9.80665)
        for name, sensor in recording.sensors.items()
    }
    in_g = apdm(tmp_path / "g.csv", replace(recording, sensors=scaled), ("g", "rad/s", "uT"))
    np.testing.assert_allclose(
        readers.read(in_g).sensors["pelvis"].accelerometer_mps2,
        recording.sensors["pelvis"].accelerometer_mps2,
        rtol=1e-7,
    )
    with pytest.raises(RecordingFormatError) as refused:
        readers.read(apdm(tmp_path / "x.csv", recording, ("furlong", "rad/s", "uT")))
    assert codes([refused.value.message]) == ["mapping.unit"]
    with pytest.raises(RecordingFormatError):
        readers.read(apdm(tmp_path / "y.csv", recording, ("g", "rad/s", "uT")))


def test_a_sensor_without_a_channel_is_refused_by_its_name(tmp_path: Path) -> None:
    path = apdm(tmp_path / "a.csv", made())
    path.write_text(path.read_text().replace("Lumbar/Acceleration/Z", "Lumbar/Acceleration/W"))
    with pytest.raises(RecordingFormatError, match="Lumbar/Acceleration/Z"):
        readers.read(path)
    path.write_text(path.read_text().replace("Time,", "When,"))
    with pytest.raises(RecordingFormatError, match="Time"):
        readers.read(path, "apdm")


def test_every_axis_has_the_unit_that_stands_below_its_name(tmp_path: Path) -> None:
    recording = made(temperature=False)
    path = apdm(tmp_path / "a.csv", recording)
    path.write_text(path.read_text().replace("rad/s,rad/s,rad/s", "rad/s,deg/s,rad/s", 1))
    found = readers.read(path).sensors["pelvis"].gyroscope_radps
    np.testing.assert_allclose(
        found, recording.sensors["pelvis"].gyroscope_radps * np.array([1.0, np.pi / 180.0, 1.0]), rtol=1e-7
    )
    path.write_text(path.read_text().replace("rad/s,deg/s,rad/s", "rad/s,rad/s,furlong", 1))
    with pytest.raises(RecordingFormatError, match="furlong"):
        readers.read(path)


def test_a_temperature_in_another_unit_is_refused(tmp_path: Path) -> None:
    path = apdm(tmp_path / "a.csv", made())
    path.write_text(path.read_text().replace("deg C", "deg F"))
    with pytest.raises(RecordingFormatError, match="Lumbar/Temperature/Scalar deg C"):
        readers.read(path)


@pytest.mark.parametrize("without", ["pelvis", "thigh_right"])
def test_magnetometers_are_stored_whichever_sensor_has_none(tmp_path: Path, without: str) -> None:
    recording = made(temperature=False)
    sensors = dict(recording.sensors)
    sensors[without] = replace(sensors[without], magnetometer_t=None)
    read = readers.read(apdm(tmp_path / "a.csv", replace(recording, sensors=sensors)))
    stored = readers.packets_of(read).as_stored().sensors
    for name, sensor in read.sensors.items():
        if name == without:
            assert stored[name].magnetometer_t is None
        else:
            np.testing.assert_allclose(stored[name].magnetometer_t, sensor.magnetometer_t, rtol=1e-6)


def test_a_session_stores_temperature_where_all_sensors_have_it(tmp_path: Path) -> None:
    found = readers.read(apdm(tmp_path / "a.csv", made()))
    stored = readers.packets_of(found).as_stored()
    for name, sensor in found.sensors.items():
        np.testing.assert_allclose(stored.sensors[name].temperature_degc, sensor.temperature_degc, rtol=1e-6)
        np.testing.assert_allclose(stored.sensors[name].magnetometer_t, sensor.magnetometer_t, rtol=1e-6)
    found.sensors["pelvis"].temperature_degc[3] = np.nan
    without = readers.packets_of(found).as_stored()
    assert all(sensor.temperature_degc is None for sensor in without.sensors.values())
    np.testing.assert_array_equal(
        without.sensors["pelvis"].magnetometer_t, stored.sensors["pelvis"].magnetometer_t
    )
