"""`telemotion process` refuses readings that cannot be right, unless told to go on."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from app.cli import cli
from app.errors import ImplausibleReadings, InvalidInput

DATA = Path(__file__).parents[2] / "data" / "broad" / "fast_combined_15s.npz"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A real recording as CSV, and its mapping."""
    folder = tmp_path_factory.mktemp("process")
    content = np.load(DATA)
    rate_hz = float(content["sampling_rate_hz"])
    names = ("gyroscope_radps", "accelerometer_mps2", "magnetometer_ut")
    time_s = np.arange(len(content[names[0]])) / rate_hz
    columns = ["t", *(f"{kind}{axis}" for kind in "gam" for axis in "xyz")]
    table = np.column_stack([time_s, *(content[name] for name in names)])
    np.savetxt(folder / "box.csv", table, delimiter=",", header=",".join(columns), comments="")
    return folder / "box.csv", folder / "mapping.json"


def mapping(rate_unit: str, axes: str = "xyz") -> str:
    signals = [
        {
            "placement": "forearm_right",
            "quantity": quantity,
            "columns": [f"{kind}{a}" for a in order],
            "unit": unit,
        }
        for kind, quantity, unit, order in (
            ("g", "gyroscope", rate_unit, axes),
            ("a", "accelerometer", "m/s^2", "xyz"),
            ("m", "magnetometer", "uT", "xyz"),
        )
    ]
    return json.dumps({"time_column": "t", "time_unit": "s", "signals": signals})


def run(files: tuple[Path, Path], out: Path, words: str, *more: str):
    files[1].write_text(words)
    arguments = [
        "process",
        str(files[0]),
        "--mapping",
        str(files[1]),
        "--pipeline",
        "orientation",
        "--out",
        str(out),
    ]
    return CliRunner().invoke(cli, [*arguments, *more])


def test_sound_readings_are_estimated(files, tmp_path):
    assert run(files, tmp_path / "out", mapping("rad/s")).exit_code == 0
    assert (tmp_path / "out" / "frames.parquet").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (mapping("deg/s"), "converted twice"),
        (mapping("rad/s", "yxz"), "the axes of the gyroscope do not fit"),
    ],
)
def test_wrong_units_and_axes_are_refused_in_words(files, tmp_path, words, told):
    refused = run(files, tmp_path / "out", words)
    assert isinstance(refused.exception, InvalidInput)
    assert told in str(refused.exception)
    assert "--force" in str(refused.exception)
    assert not (tmp_path / "out").exists()
    forced = run(files, tmp_path / "out", words, "--force")
    assert forced.exit_code == 0
    assert told in forced.stderr


def test_an_unknown_hemisphere_is_refused(files, tmp_path):
    refused = run(files, tmp_path / "out", mapping("rad/s"), "--hemisphere", "east")
    assert refused.exit_code == 2
    assert "north, south or unknown" in refused.output
    assert not (tmp_path / "out").exists()


def test_force_reaches_what_the_reader_refuses(files, tmp_path):
    """Metres per second squared declared as g: ten times gravity, which the reader itself refuses."""
    source, words = files[0], mapping("rad/s").replace("m/s^2", "g")
    refused = run(files, tmp_path / "out", words)
    assert refused.exit_code != 0
    assert isinstance(refused.exception, ImplausibleReadings)
    accepted = run((source, files[1]), tmp_path / "out", words, "--force")
    assert accepted.exit_code == 0, accepted.output
    assert "warning" in accepted.output
    assert (tmp_path / "out" / "frames.parquet").exists()
