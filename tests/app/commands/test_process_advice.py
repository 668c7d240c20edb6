"""Who follows the advice of `telemotion process` by its own means gets what the sound recording gives."""

import json
import re
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet
import pytest
from typer.testing import CliRunner

from app.cli import cli
from app.errors import InvalidInput
from estimators import rotation

DATA = Path(__file__).parents[2] / "data" / "broad" / "fast_combined_15s.npz"
SOUND = {"gyroscope": "rad/s", "accelerometer": "m/s^2", "magnetometer": "uT"}
KEYS = dict(zip(SOUND, ("gyroscope_radps", "accelerometer_mps2", "magnetometer_ut"), strict=True))


def processed(folder: Path, table: dict[str, np.ndarray], mapping: dict, *options: str):
    """Run the command on a table with one sensor."""
    with np.load(DATA) as content:
        time_s = np.arange(len(content["movement"])) / float(content["sampling_rate_hz"])
    names = ["t", *(f"{quantity}_{axis}" for quantity in SOUND for axis in "xyz")]
    rows = np.column_stack([time_s, *(table[quantity] for quantity in SOUND)])
    np.savetxt(folder / "box.csv", rows, fmt="%.9g", delimiter=",", header=",".join(names), comments="")
    (folder / "mapping.json").write_text(json.dumps(mapping))
    arguments = ["process", str(folder / "box.csv"), "--mapping", str(folder / "mapping.json")]
    arguments += ["--pipeline", "orientation", "--orientation", "vqf", "--out", str(folder / "out"), *options]
    return CliRunner().invoke(cli, arguments)


def declared(**units: str) -> dict:
    signals = [
        {
            "placement": "forearm_right",
            "quantity": quantity,
            "columns": [f"{quantity}_{axis}" for axis in "xyz"],
            "unit": units.get(quantity, unit),
        }
        for quantity, unit in SOUND.items()
    ]
    return {"time_column": "t", "time_unit": "s", "signals": signals}


def corrected(mapping: dict, quantity: str, **changes) -> dict:
    signals = [
        signal | changes if signal["quantity"] == quantity else signal for signal in mapping["signals"]
    ]
    return mapping | {"signals": signals}


def as_advised(words: str, quantity: str) -> list[str]:
    """Return the columns that a person writes who reads `x → -y`."""
    found = dict(re.findall(r"([xyz]) → (-?[xyz])", words))
    return [
        f"{'-' if taken.startswith('-') else ''}{quantity}_{taken[-1]}"
        for taken in (found.get(axis, axis) for axis in "xyz")
    ]


def orientation(folder: Path) -> np.ndarray:
    columns = parquet.read_table(folder / "out" / "frames.parquet").to_pydict()
    return np.stack([np.asarray(columns[f"forearm_right_q_{one}"], float) for one in "wxyz"], axis=1)


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Readings, and what is estimated of them."""
    folder = tmp_path_factory.mktemp("sound")
    with np.load(DATA) as content:
        table = {quantity: content[key].astype(float) for quantity, key in KEYS.items()}
    assert processed(folder, table, declared()).exit_code == 0
    return table, orientation(folder)


def advice(folder: Path, table: dict[str, np.ndarray], mapping: dict) -> str:
    refused = processed(folder, table, mapping)
    assert isinstance(refused.exception, InvalidInput), refused.output
    return str(refused.exception)


def is_right(folder: Path, table: dict[str, np.ndarray], mapping: dict, sound: np.ndarray, *options: str):
    """Assert that nothing is said of it any more, and that the orientation is that of the sound recording."""
    assert not (folder / "out").exists()
    done = processed(folder, table, mapping, *options)
    assert done.exit_code == 0, done.output
    assert "warning" not in done.output
    # A field or gravity may be turned by half a turn as a whole: what counts is what the sensor does.
    apart = np.degrees(rotation.angle_between(orientation(folder), sound))
    assert np.nanmedian(apart) < 1.0


AXES = {
    "x and y exchanged": [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
    "turned a quarter": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
    "in a circle": [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
    "z reversed": [[1, 0, 0], [0, 1, 0], [0, 0, -1]],
    "y and z reversed": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
}


@pytest.mark.parametrize("change", AXES)
@pytest.mark.parametrize("quantity", SOUND)
def test_columns_as_advised(sound, tmp_path, quantity, change):
    table = sound[0] | {quantity: sound[0][quantity] @ np.array(AXES[change], float).T}
    words = advice(tmp_path, table, declared())
    assert f"axes of the {quantity}" in words
    mapping = corrected(declared(), quantity, columns=as_advised(words, quantity))
    is_right(tmp_path, table, mapping, sound[1])


@pytest.mark.parametrize(
    ("quantity", "wrong", "said", "unit"),
    [
        ("gyroscope", np.degrees, "declare degrees/s", "deg/s"),
        ("accelerometer", lambda values: values / 9.80665, "This looks like g", "g"),
        ("accelerometer", lambda values: values / 9.80665e-3, "mg", "mg"),
        ("magnetometer", lambda values: 1e-6 * values, "", "T"),
        ("magnetometer", lambda values: 1e-2 * values, "", "G"),
    ],
)
def test_the_unit_as_advised(sound, tmp_path, quantity, wrong, said, unit):
    table = sound[0] | {quantity: wrong(sound[0][quantity])}
    words = advice(tmp_path, table, declared())
    assert said in words or unit in words, words
    is_right(tmp_path, table, corrected(declared(), quantity, unit=unit), sound[1])


def test_rad_per_second_as_advised(sound, tmp_path):
    assert "Declare rad/s" in advice(tmp_path, sound[0], declared(gyroscope="deg/s"))
    is_right(tmp_path, sound[0], declared(), sound[1])


def test_the_sign_and_the_hemisphere_as_advised(sound, tmp_path):
    """The hemisphere stands first: who turns the sign in the south turns everything upside down."""
    table = sound[0] | {"accelerometer": -sound[0]["accelerometer"]}
    words = advice(tmp_path, table, declared())
    assert words.index("--hemisphere") > words.index("south of the equator") < words.index("other sign")
    is_right(tmp_path, table, corrected(declared(), "accelerometer", sign=-1), sound[1])


def test_a_recording_of_the_south_as_advised(sound, tmp_path):
    """The field points up there: mirrored at the horizon, by the orientation that is known."""
    turned, field = sound[1], sound[0]["magnetometer"]
    count = min(len(turned), len(field))
    level = rotation.rotate(turned[:count], field[:count])
    southern = rotation.rotate(rotation.conjugate(turned[:count]), level * np.array([1.0, 1.0, -1.0]))
    table = sound[0] | {"magnetometer": np.vstack((southern, field[count:]))}
    assert "south of the equator" in advice(tmp_path, table, declared())
    is_right(tmp_path, table, declared(), sound[1], "--hemisphere", "south")
