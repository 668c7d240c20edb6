"""What is shown of a table before it is read: the same as is read, in sentences, and as a person changes it."""

import numpy as np
import pytest

from app import readers
from app.errors import RecordingFormatError
from app.readers.tables.look import look_at
from app.readers.tables.schemas import CsvMapping, GuessedMapping
from tests.app.readers.odd_fields import field_tables
from tests.app.readers.odd_tables import ALL, FORCE, GYROSCOPE, NINE, PLAIN, TIME_S, odd_tables, rows_of, text
from tests.said import codes, refuses, sentence

ODD = odd_tables() | field_tables()
SIX = ",".join(["time_s", *NINE[:6]])


def seen(content, change=None, hemisphere="north", name="table.csv", **asked):
    found = readers.preview_text(name, content[: readers.HEAD_BYTES], **asked)
    mapping = GuessedMapping.model_validate(found.guess.mapping)
    if change:
        change(mapping)
    return look_at(found.head, found.guess, mapping if change else None, hemisphere), mapping


@pytest.mark.slow
@pytest.mark.parametrize("name", ODD)
def test_the_curves_are_what_will_be_read(tmp_path, name):
    odd = ODD[name]
    options = dict(zip(odd.options[::2], odd.options[1::2], strict=True))
    rate = options.get("--rate")
    look, mapping = seen(
        odd.content, name=odd.name, pipeline=options.get("--pipeline"), rate_hz=rate and float(rate)
    )
    assert look.missing == look.doubts == ()
    path = tmp_path / odd.name
    path.write_bytes(odd.content)
    read = readers.read(path, "csv", CsvMapping.model_validate(mapping.model_dump())).sensors
    assert {one.where for one in look.sensors} == set(read)
    for one in look.sensors:
        shown, whole = one.signals, read[one.where]
        assert shown.time_s[-1] - shown.time_s[0] > 1.0
        # Sensors whose stamps differ are read on one time; between two samples lies a line.
        for quantity in ("gyroscope_radps", "accelerometer_mps2"):
            for axis in range(3):
                values, all_ = getattr(shown, quantity)[:, axis], getattr(whole, quantity)[:, axis]
                there, known = np.isfinite(values), np.isfinite(all_)
                expected = np.interp(shown.time_s[there], whole.time_s[known], all_[known])
                # The repairs of a whole file look farther than its first seconds.
                assert np.median(np.abs(values[there] - expected)) < 1e-4


def test_a_sentence_names_place_units_columns_and_clock():
    header = ",".join(
        ["t [ms]", *(f"left wrist {q} {a} [{u}]" for q, u in (("gyr", "deg/s"), ("acc", "g")) for a in "xyz")]
    )
    rows = rows_of(np.degrees(GYROSCOPE), FORCE / 9.80665, time_s=1e3 * TIME_S)
    look, _ = seen(text([header], rows).encode())
    (one,) = look.sensors
    assert one.sentence == (
        "Left forearm: gyroscope in °/s (left wrist gyr x, …y, …z) and accelerometer in g (left wrist acc x, …y, …z);"
        " 100 samples a second by the column t [ms]."
    )
    assert codes(look.assumed) == ["guess.sign_assumed"]


def test_what_a_person_changes_is_no_longer_assumed_and_the_curves_follow():
    content = text([SIX], rows_of(np.degrees(GYROSCOPE), FORCE)).encode()
    look, _ = seen(content)
    assert "guess.unit_from_numbers" in codes(look.assumed)

    def other(mapping):
        gyroscope, force = mapping.signals
        gyroscope.unit = "rad/s"
        gyroscope.columns = [NINE[1], f"-{NINE[0]}", NINE[2]]
        force.sign = -1

    changed, _ = seen(content, other)
    assert [
        one.parameters["columns"] for one in changed.assumed if one.code == "guess.unit_from_numbers"
    ] == [NINE[3:6]]
    assert sentence(changed.assumed, "guess.turned").parameters["quantity"] == "accelerometer"
    assert "rad/s (gyr_y, −gyr_x, gyr_z)" in changed.sensors[0].sentence
    before, after = look.sensors[0].signals, changed.sensors[0].signals
    np.testing.assert_allclose(after.accelerometer_mps2, -before.accelerometer_mps2)
    np.testing.assert_allclose(
        after.gyroscope_radps[:, 1], -np.degrees(before.gyroscope_radps[:, 0]), rtol=1e-9
    )


def test_a_unit_that_cannot_be_is_doubted_before_anything_is_sent():
    def wrong(mapping):
        mapping.signals[1].unit = "g"

    look, _ = seen(text([SIX], rows_of(GYROSCOPE, FORCE)).encode(), wrong)
    assert codes(look.doubts) == ["signal.no_gravity", "file.looks_like_unit"]
    assert look.sensors[0].signals is not None


def test_what_is_the_same_of_many_sensors_is_said_once():
    names = [f"{place}_{one}" for place in ("sternum", "pelvis", "head", "hand_left") for one in NINE[:6]]
    parts = [part for at in range(4) for part in (GYROSCOPE[at : at + 1400], FORCE[at : at + 1400])]
    content = text([",".join(["time_s", *names])], rows_of(*parts, time_s=TIME_S[:1400])).encode()
    look, _ = seen(content)
    assert codes(look.assumed) == [
        "guess.units_assumed",
        "guess.units_from_numbers",
        "guess.sign_assumed",
    ]
    assert look.assumed[0].parameters == {"count": 4, "quantity": "gyroscope", "unit": "rad/s"}

    def one_changed(mapping):
        next(one for one in mapping.signals if one.quantity == "gyroscope").unit = "deg/s"

    changed, _ = seen(content, one_changed)
    assert sentence(changed.assumed, "guess.units_assumed").parameters["count"] == 3


def test_what_is_missing_is_asked_until_it_is_said():
    content = text([",".join(NINE[:6])], rows_of(GYROSCOPE, FORCE, time_s=None)).encode()
    look, _ = seen(content)
    assert codes(look.missing) == ["guess.no_time"]
    assert look.sensors[0].signals is None

    def timed(mapping):
        mapping.rate_hz = 100.0

    timed_look, _ = seen(content, timed)
    assert timed_look.missing == ()
    assert sentence(timed_look.assumed, "guess.rows_counted").parameters == {"rate_hz": 100.0}
    assert timed_look.sensors[0].sentence.code == "guess.sensor_of_rows"
    assert timed_look.sensors[0].signals.time_s[100] == pytest.approx(1.0)


def test_a_rate_of_a_line_above_the_table_is_said_to_come_from_there():
    head = ["// Sample rate: 100 Hz", ",".join(NINE[:6])]
    look, _ = seen(text(head, rows_of(GYROSCOPE, FORCE, time_s=None)).encode())
    assert sentence(look.assumed, "guess.rate_of_line").parameters == {"rate_hz": 100.0}


@pytest.mark.parametrize("hemisphere", ["north", "south", "unknown"])
def test_the_hemisphere_is_said_where_a_field_is_measured(hemisphere):
    look, _ = seen(text([PLAIN], rows_of(*ALL)).encode(), hemisphere=hemisphere)
    assert f"guess.hemisphere_{hemisphere}" in codes(look.assumed)


def test_a_column_that_does_not_advance_is_doubted_not_refused():
    content = text([SIX], rows_of(GYROSCOPE, FORCE)).encode()

    def stuck(mapping):
        mapping.time_column = "acc_x"

    look, _ = seen(content, stuck)
    assert "time.does_not_advance" in codes(look.doubts)
    assert look.sensors[0].signals is None


def test_sensors_whose_rows_come_later_are_named_without_curves():
    """A file that holds one device after the other: the beginning has rows of the first alone."""
    rows = [[*row, "a"] for row in rows_of(GYROSCOPE, FORCE)]
    content = text([f"{SIX},device"], rows).encode()

    def later(mapping):
        for one in list(mapping.signals):
            mapping.signals.append(one.model_copy(update={"sensor": "b", "rows": {"device": "b"}}))

    look, _ = seen(content, later)
    assert [one.signals is None for one in look.sensors] == [False, True]
    assert look.doubts == ()


def test_a_column_that_would_be_text_and_numbers_is_refused_in_words(tmp_path):
    content = text([SIX], rows_of(GYROSCOPE, FORCE)).encode()

    def confused(mapping):
        mapping.time_column, mapping.time_unit = "gyr_x", "clock"

    look, mapping = seen(content, confused)
    assert codes(look.doubts) == ["mapping.text_and_signal"]
    (tmp_path / "table.csv").write_bytes(content)
    with refuses("mapping.text_and_signal", error=RecordingFormatError, columns=["gyr_x"]):
        readers.read(tmp_path / "table.csv", "csv", CsvMapping.model_validate(mapping.model_dump()))
