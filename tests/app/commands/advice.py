"""Sound readings turned wrong, what `telemotion process` says of them, and whether following it makes them right."""

import json
import re
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet
from typer.testing import CliRunner

from app.cli import cli
from app.errors import InvalidInput
from estimators import rotation

DATA = Path(__file__).parents[2] / "data" / "broad" / "fast_combined_15s.npz"
SOUND = {"gyroscope": "rad/s", "accelerometer": "m/s^2", "magnetometer": "uT"}
KEYS = dict(zip(SOUND, ("gyroscope_radps", "accelerometer_mps2", "magnetometer_ut"), strict=True))


def processed(folder: Path, table: dict[str, np.ndarray], mapping: dict, *options: str):
    """Run the command on a table with one sensor; `time_s` in it stands for that of the sound recording."""
    time_s = table.get("time_s", sampled_at()[: len(table["gyroscope"])])
    names = ["t", *(f"{quantity}_{axis}" for quantity in SOUND for axis in "xyz")]
    rows = np.column_stack([time_s, *(table[quantity] for quantity in SOUND)])
    np.savetxt(folder / "box.csv", rows, fmt="%.9g", delimiter=",", header=",".join(names), comments="")
    (folder / "mapping.json").write_text(json.dumps(mapping))
    arguments = ["process", str(folder / "box.csv"), "--mapping", str(folder / "mapping.json")]
    arguments += ["--pipeline", "orientation", "--orientation", "vqf", "--out", str(folder / "out"), *options]
    return CliRunner().invoke(cli, arguments)


def sampled_at() -> np.ndarray:
    """Return when the samples of the sound recording were measured, s."""
    with np.load(DATA) as content:
        return np.arange(len(content["movement"])) / float(content["sampling_rate_hz"])


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


def sound_recording(folder: Path) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return readings of a sound recording, and the orientation that is estimated of them."""
    with np.load(DATA) as content:
        table = {quantity: content[key].astype(float) for quantity, key in KEYS.items()}
    assert processed(folder, table, declared()).exit_code == 0
    return table, orientation(folder)


def advice(folder: Path, table: dict[str, np.ndarray], mapping: dict) -> str:
    refused = processed(folder, table, mapping)
    assert isinstance(refused.exception, InvalidInput), refused.output
    return str(refused.exception)


def is_right(
    folder: Path,
    table: dict[str, np.ndarray],
    mapping: dict,
    sound: np.ndarray,
    *options: str,
    within_deg: float = 1.0,
):
    """Assert that nothing is said of it any more, and that the orientation is that of the sound recording."""
    assert not (folder / "out").exists()
    done = processed(folder, table, mapping, *options)
    assert done.exit_code == 0, done.output
    assert "warning" not in done.output
    # A field or gravity may be turned by half a turn as a whole: what counts is what the sensor does.
    apart = np.degrees(rotation.angle_between(orientation(folder), sound))
    assert np.nanmedian(apart) < within_deg
