"""One recording in several tables of one clock, in a zip or as a list of files."""

import io
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from app import readers
from app.cli import cli
from app.errors import RecordingFormatError
from app.readers import members
from app.readers.tables.schemas import CsvMapping
from tests.app.readers.odd_tables import FIELD_UT, FORCE, GYROSCOPE, TIME_S, G, rows_of, text
from tests.said import codes, refuses

HEAD = "Time (s),{0} x ({1}),{0} y ({1}),{0} z ({1})"
LATE_S = TIME_S + 0.004


def between(values: np.ndarray, at_s: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(at_s, TIME_S, values[:, axis]) for axis in range(3)], axis=1)


def packed(tables: dict[str, str], path: Path) -> Path:
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for name, content in tables.items():
            archive.writestr(name, content)
    return path


def phone(time_s: np.ndarray = TIME_S) -> dict[str, str]:
    """As an app for phones writes it: a table a quantity, stamps of its own in each."""
    field_s = LATE_S[::5]
    return {
        "meta/device.csv": '"property","value"\n"deviceModel","x"\n',
        "Accelerometer.csv": text([HEAD.format("Acceleration", "m/s^2")], rows_of(FORCE, time_s=time_s)),
        "Gyroscope.csv": text(
            [HEAD.format("Gyroscope", "rad/s")], rows_of(between(GYROSCOPE, LATE_S), time_s=time_s + 0.004)
        ),
        "Magnetometer.csv": text(
            [HEAD.format("Magnetic field", "µT")],
            rows_of(between(FIELD_UT, field_s), time_s=time_s[::5] + 0.004),
        ),
    }


def example(folder: Path, _: object) -> Path:
    """Write the file of `test_same_numbers.py`: processed and uploaded, it gives the same numbers."""
    return packed(phone(), folder / "phone.zip")


def sensors(shift: int = 0) -> dict[str, str]:
    """A table for each sensor; a counter of 16 bits is their clock, and one of them lost some rows."""
    chosen = np.r_[0:400, 460 : len(TIME_S)]
    names = ["PacketCounter", *(f"{q}_{a}" for q in ("Acc", "Gyr") for a in "XYZ")]

    def table(rows: np.ndarray, turn: slice, *, first: int) -> str:
        count = (65_300 + first + rows) % 65_536
        signals = np.column_stack([FORCE[turn], GYROSCOPE[turn]])
        return text(
            ["// Update Rate: 100.0Hz", "\t".join(names)],
            rows_of(signals, time_s=count, rows=rows),
            "\t",
        )

    every = np.arange(len(TIME_S))
    return {
        "MT_0001-000_forearm_R.txt": table(every, slice(None), first=shift),
        "MT_0001-000_upperarm_R.txt": table(chosen, slice(None, None, -1), first=0),
    }


def test_tables_of_quantities_are_joined_by_their_times(tmp_path: Path) -> None:
    path = packed(phone(), tmp_path / "walk.zip")
    found = readers.read(path)
    (signals,) = found.sensors.values()
    assert {"zip.joined", "table.joined"} <= set(codes(found.notes))
    assert not {"guess.clocks_left", "guess.own_clocks"} & set(codes(found.notes))
    inside = slice(1, -1)
    at_s = LATE_S[0] + signals.time_s[inside]
    np.testing.assert_allclose(signals.gyroscope_radps[inside], between(GYROSCOPE, at_s), atol=1e-5)
    np.testing.assert_allclose(signals.accelerometer_mps2[inside], between(FORCE, at_s), atol=1e-4)
    there = np.isfinite(signals.magnetometer_t[:, 0])
    assert there.mean() > 0.98
    assert (
        np.abs(
            1e6 * signals.magnetometer_t[there] - between(FIELD_UT, LATE_S[0] + signals.time_s[there])
        ).mean()
        < 1.0
    )


@pytest.mark.parametrize("shift", [0, 300])
def test_tables_of_sensors_are_joined_by_their_counter(tmp_path: Path, shift: int) -> None:
    """The second begins on the other side of where the counter begins again, when it is late."""
    path = packed(sensors(shift), tmp_path / "arm.zip")
    found = readers.read(path)
    one, other = found.sensors["forearm_right"], found.sensors["upper_arm_right"]
    late = shift / 100.0
    place = np.rint(100.0 * (one.time_s - late)).astype(int)
    inside = (place >= 0) & (place < len(TIME_S))
    assert inside.sum() == len(TIME_S)
    np.testing.assert_allclose(one.gyroscope_radps[inside], GYROSCOPE, rtol=2e-6, atol=1e-5)
    hole = (other.time_s > 4.01) & (other.time_s < 4.59)
    assert not np.isfinite(other.gyroscope_radps[hole]).any()
    after = (other.time_s > 4.595) & (other.time_s < 14.995)
    np.testing.assert_allclose(other.gyroscope_radps[after], GYROSCOPE[::-1][460:], rtol=2e-6, atol=1e-5)
    assert "time.counter_holes" in codes(found.notes)


def test_a_pause_that_was_cut_out_is_put_back(tmp_path: Path) -> None:
    events = "".join(
        f'"{event}",{inside},{outside}\n'
        for event, inside, outside in (
            ("START", 0, 100),
            ("PAUSE", 7, 107),
            ("START", 7, 127),
            ("PAUSE", 15, 135),
        )
    )
    path = packed(
        phone() | {"meta/time.csv": f'"event","experiment time","system time"\n{events}'}, tmp_path / "a.zip"
    )
    found = readers.read(path)
    (signals,) = found.sensors.values()
    assert {"zip.pauses", "time.pauses"} <= set(codes(found.notes))
    assert signals.time_s[-1] == pytest.approx(34.99, abs=0.01)


def test_accelerations_without_gravity_beside_it_are_left_or_refused(tmp_path: Path) -> None:
    quantities = {
        "Gyroscope": GYROSCOPE,
        "Accelerometer": FORCE - FORCE.mean(axis=0),
        "Gravity": 0 * FORCE + [0, 0, G],
    }
    tables = {
        f"{name}.csv": text(
            ["time,seconds_elapsed,z,y,x"], [[row[0], *row] for row in rows_of(values[:, ::-1])]
        )
        for name, values in quantities.items()
    }
    with refuses("zip.no_gravity", error=RecordingFormatError):
        readers.read(packed(tables, tmp_path / "a.zip"))
    tables["TotalAcceleration.csv"] = text(
        ["time,seconds_elapsed,z,y,x"], [[row[0], *row] for row in rows_of(FORCE[:, ::-1])]
    )
    (signals,) = readers.read(packed(tables, tmp_path / "b.zip")).sensors.values()
    np.testing.assert_allclose(signals.accelerometer_mps2, FORCE, rtol=2e-6, atol=2e-6)


def test_a_list_of_files_is_read_as_their_zip(tmp_path: Path) -> None:
    for name, content in phone().items():
        (tmp_path / Path(name).name).write_text(content)
    files = [str(tmp_path / f"{name}.csv") for name in ("Gyroscope", "Accelerometer")]
    shown = CliRunner().invoke(cli, ["mapping", *files])
    assert shown.exit_code == 0, shown.output
    mapping = CsvMapping.model_validate_json(shown.stdout)
    clocks = {one.quantity: one.time_column for one in mapping.signals}
    assert clocks == {"gyroscope": "Gyroscope Time (s)", "accelerometer": "Accelerometer Time (s)"}
    direct = readers.read(packed(phone(), tmp_path / "walk.zip"), csv=mapping)
    np.testing.assert_allclose(direct.sensors["imu"].gyroscope_radps, between(GYROSCOPE, LATE_S), atol=1e-5)
    twice = CliRunner().invoke(cli, ["mapping", files[0], files[0]])
    assert "given twice" in str(twice.exception)


def locked(path: Path) -> None:
    content = bytearray(packed(phone(), path).read_bytes())
    content[content.rfind(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(content)


def spliced(path: Path) -> None:
    path.write_bytes(packed(phone(), path).read_bytes()[:-40])


@pytest.mark.parametrize(
    ("make", "code"),
    [
        (locked, "zip.locked"),
        (spliced, "zip.damaged"),
        (lambda path: packed({"a.csv": "0," * 40_000_000}, path), "file.unpacks_to_too_much"),
        (lambda path: packed({f"{k}.csv": "1" for k in range(201)}, path), "zip.many"),
        (lambda path: packed({"a/b/c/d.csv": "1"}, path), "zip.nested"),
        (lambda path: packed({"inner.zip": "PK"}, path), "zip.nested"),
        (lambda path: packed({"notes.txt": "nothing to see"}, path), "zip.no_table"),
        (lambda path: packed({}, path), "zip.no_table"),
    ],
)
def test_a_zip_out_of_bounds_is_refused_in_words(tmp_path: Path, make, code: str) -> None:
    path = tmp_path / "a.zip"
    make(path)
    with refuses(code, error=RecordingFormatError):
        readers.read(path, "zipped")


def test_names_of_members_are_no_paths(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    tables = {f"/{tmp_path.name}/{name}": content for name, content in phone().items() if "meta" not in name}
    found = readers.read(packed(tables, inside / "a.zip"))
    assert set(found.sensors) == {"imu"}
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["a.zip", "inside"]


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_no_damage_breaks_more_than_the_reading(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    buffer = io.BytesIO()
    with ZipFile(buffer, "w", ZIP_DEFLATED) as archive:
        for name, content in phone().items():
            archive.writestr(name, content[:3000])
    content = bytearray(buffer.getvalue())
    for _ in range(data.draw(st.integers(1, 6))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("zip") / "a.zip"
    path.write_bytes(content)
    try:
        members.members_of(path)
        readers.read(path, "zipped")
    except RecordingFormatError:
        pass
