"""What a notebook needs: three lines from a file to a table, wherever it lies."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import telemotion
from app.errors import InvalidInput
from estimators.rotation import angle_between
from tests.app.readers.odd_tables import odd_tables


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "turned.csv"
    path.write_bytes(odd_tables()["blanks in names"].content)
    return path


def test_a_file_becomes_a_table_in_three_lines(file):
    read = telemotion.read(file)
    processed = telemotion.process(read)
    table = processed.table()
    assert read.kind == "orientation"
    assert table.num_rows == processed.frames.tick_count > 1000
    q = np.stack([table[f"imu_q_{axis}"].to_numpy() for axis in "wxyz"], axis=1)
    np.testing.assert_array_equal(q, processed.frames.q_room_segment[:, 0])
    assert table.schema.field("time_s").metadata[b"unit"] == b"s"


def test_smoothing_is_another_estimate_of_the_same_movement(file):
    read = telemotion.read(file)
    live, smooth = telemotion.process(read), telemotion.smooth(read)
    assert smooth.setup.orientation == "telemotion_smoother"
    apart = angle_between(live.frames.q_room_segment[500:, 0], smooth.frames.q_room_segment[500:, 0])
    assert 0.0 < np.degrees(np.median(apart)) < 10.0


def test_what_is_assumed_stands_in_the_notes(file):
    read = telemotion.read(file)
    assert read.notes
    assert set(read.notes) <= set(telemotion.process(read).notes)


def test_a_table_that_says_too_little_is_refused_with_what_to_give(tmp_path):
    path = tmp_path / "no_time.csv"
    path.write_text("gx,gy,gz,ax,ay,az\n" + "0.1,0.2,0.3,0.1,0.2,9.8\n" * 300)
    with pytest.raises(InvalidInput, match="rate_hz"):
        telemotion.read(path)
    with pytest.raises(InvalidInput, match="no file"):
        telemotion.read(tmp_path / "absent.csv")


@pytest.mark.parametrize("first", ["", "import app; "], ids=["beside it", "after it"])
def test_it_works_in_a_folder_that_has_an_app_of_its_own(first, tmp_path):
    (tmp_path / "app.py").write_text("name = 'mine'\n")
    done = subprocess.run(
        [sys.executable, "-c", f"{first}import telemotion; print(len(telemotion.__all__))"],
        cwd=tmp_path,
        env={"PYTHONPATH": f":{Path(telemotion.__file__).parents[1]}"},
        capture_output=True,
        text=True,
        check=False,
    )
    if first:
        assert "import telemotion first" in done.stderr
    else:
        assert done.stdout.strip() == str(len(telemotion.__all__)), done.stderr
