"""Tables of the archive, read back as a spreadsheet reads them."""

import csv
import io
import json
import zipfile
from typing import Any

import pytest
from sqlalchemy import Engine, update

from app.accounts.models import Account
from app.assessment.exports.meanings import OF_REPETITION, OF_STRIDE
from app.assessment.exports.spreadsheet import csv_bytes, strides_sheet
from app.database.unit_of_work import unit_of_work
from app.exercises.models import Exercise
from app.kinds.walk.schemas import FootStride, StrideOut
from estimators.measures import measures_of
from tests.app.viewer.stored_reaches import Recorded, compared_reaches, store


@pytest.fixture
def recorded(world: Any, engine: Engine) -> Recorded:
    with unit_of_work(engine) as session:
        session.execute(
            update(Exercise)
            .where(Exercise.id == world.exercise_id)
            .values(name="=cmd|' /C calc'!A0 Übung; \"Łódź\",\n links")
        )
        return store(
            session,
            world.clinic_id,
            world.patient_id,
            world.exercise_id,
            world.accounts["therapist"],
            compared_reaches(),
        )


def archive_of(client: Any, world: Any) -> zipfile.ZipFile:
    answer = client.get(f"/api/patients/{world.patient_id}/export")
    assert answer.status_code == 200
    return zipfile.ZipFile(io.BytesIO(answer.content))


def rows_of(content: bytes, delimiter: str) -> list[list[str]]:
    """As a spreadsheet does: the mark says UTF-8, and is no letter."""
    assert content.startswith(b"\xef\xbb\xbf")
    text = content.decode("utf-8-sig")
    assert "\ufeff" not in text
    return list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))


def named(archive: zipfile.ZipFile, end: str) -> str:
    (name,) = [name for name in archive.namelist() if name.endswith(end)]
    return name


@pytest.mark.slow
@pytest.mark.parametrize(("locale", "delimiter", "point"), [("en", ",", "."), ("de", ";", ",")])
def test_a_session_has_a_table_with_a_row_a_repetition(
    engine: Engine, world: Any, recorded: Recorded, therapist: Any, locale: str, delimiter: str, point: str
) -> None:
    with unit_of_work(engine) as session:
        session.get_one(Account, world.accounts["therapist"]).locale = locale
    archive = archive_of(therapist, world)
    heading, *rows = rows_of(archive.read(named(archive, "/measures.csv")), delimiter)
    (compared,) = json.loads(archive.read(named(archive, "comparisons.json")))
    assert len(rows) == len(compared["repetitions"]) > 1
    assert {len(row) for row in rows} == {len(heading)}
    assert len(set(heading)) == len(heading)
    for row, found in zip(rows, compared["repetitions"], strict=True):
        cells = dict(zip(heading, row, strict=True))
        assert cells["repetition"] == str(found["repetition"]["number"])
        assert cells["is_kept"] == str(int(found["repetition"]["is_kept"]))
        (elbow,) = [
            one for one in found["measures"] if one["measure"].endswith("flexion") and one["group"] == "range"
        ][:1]
        column = elbow["measure"].replace(":", "_") + "_deg"
        assert float(cells[column].replace(point, ".")) == pytest.approx(elbow["value"], rel=1e-8)
        assert float(cells[f"{column}_sigma"].replace(point, ".")) == pytest.approx(
            elbow["uncertainty"], rel=1e-8
        )
        # No program takes a name for a formula, nor a line break in it for another row.
        assert cells["exercise"] == "'=cmd|' /C calc'!A0 Übung; \"Łódź\", links"
    said, *meanings = rows_of(archive.read(named(archive, "/measures-columns.csv")), delimiter)
    assert said == ["name", "unit", "meaning"]
    assert [name for name, _, _ in meanings] == heading
    assert all(meaning for _, _, meaning in meanings)
    assert {unit for name, unit, _ in meanings if name.endswith("_deg")} == {"deg"}


def test_numbers_are_numbers_and_what_was_not_measured_is_empty() -> None:
    cells = [
        0.1,
        -2.5,
        1e-7,
        12345678.9,
        7,
        True,
        None,
        float("nan"),
        float("inf"),
        "-",
        "@SUM(1)",
        "+1",
        "a\tb",
    ]
    for comma, delimiter in ((False, ","), (True, ";")):
        _, row = rows_of(
            csv_bytes([str(n) for n in range(len(cells))], [cells], decimal_comma=comma), delimiter
        )
        wanted = ["0.1", "-2.5", "1e-07", "12345678.9", "7", "1", "", "", ""]
        if comma:
            wanted = [one.replace(".", ",") for one in wanted]
        assert row == [*wanted, "'-", "'@SUM(1)", "'+1", "a b"]


def test_every_measure_of_a_repetition_and_number_of_a_stride_has_a_meaning() -> None:
    assert set(measures_of("repetition")) == set(OF_REPETITION)
    numbers = set(StrideOut.model_fields)
    assert numbers == set(OF_STRIDE)


def test_a_walk_has_a_row_a_stride() -> None:
    plain = dict.fromkeys(StrideOut.model_fields)
    strides = [
        FootStride.model_validate(
            {**plain, "side": side, "number": 1, "bout": 1, "length_m": 0.9, "is_counted": side == "left"}
            | {"is_initiation": False, "is_termination": False}
        )
        for side in ("left", "right")
    ]
    sheet = strides_sheet(strides)
    cells = [(row["foot"], row["length_m"], row["is_counted"], row["swing_s"]) for row in sheet.rows]
    assert cells == [("left", 0.9, True, None), ("right", 0.9, False, None)]
    units = {column.name: column.unit for column in sheet.columns}
    assert (units["length_m"], units["peak_speed_mps"], units["toe_out_rad"], units["foot"]) == (
        "m",
        "m/s",
        "rad",
        "",
    )
