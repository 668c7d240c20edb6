"""Who follows what is said of dead, clipped, restless and magnetised channels, and of a wrong rate, gets it right."""

import re
from pathlib import Path

import numpy as np
import pytest

from estimators import rotation
from estimators.calibration.field.ellipsoid import fit_sphere
from tests.app.commands.advice import (
    advice,
    corrected,
    declared,
    is_right,
    orientation,
    processed,
    sampled_at,
    sound_recording,
)


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Readings, and what is estimated of them."""
    return sound_recording(tmp_path_factory.mktemp("sound"))


def warned(folder: Path, table: dict[str, np.ndarray], mapping: dict) -> str:
    """Return what is said of a recording that is estimated all the same."""
    done = processed(folder, table, mapping)
    assert done.exit_code == 0, done.output
    for file in (folder / "out").iterdir():
        file.unlink()
    (folder / "out").rmdir()
    words = " ".join(done.output.split())
    assert "warning" in words, words
    return words


@pytest.mark.parametrize("axes", [[0], [1, 2]])
def test_a_gyroscope_with_an_axis_that_never_moves_is_replaced(sound, tmp_path, axes):
    table = sound[0] | {"gyroscope": sound[0]["gyroscope"].copy()}
    table["gyroscope"][:, axes] = 0.0123
    words = advice(tmp_path, table, declared())
    assert f"({' and '.join('xyz'[axis] for axis in axes)})" in words
    assert "Replace the sensor" in words
    is_right(tmp_path, sound[0], declared(), sound[1])


def test_an_accelerometer_that_never_moves_is_replaced(sound, tmp_path):
    table = sound[0] | {"accelerometer": np.tile([0.0, 0.0, 9.81], (len(sound[0]["gyroscope"]), 1))}
    words = advice(tmp_path, table, declared())
    assert "accelerometer never changes" in words
    assert "Replace the sensor" in words
    is_right(tmp_path, sound[0], declared(), sound[1])


@pytest.mark.parametrize(
    ("value", "said"), [(0.0, "leave the compass out"), (21.0, "Declare that there is none")]
)
def test_a_compass_that_never_moves_is_declared_not_to_be_there(sound, tmp_path, value, said):
    table = sound[0] | {"magnetometer": np.full_like(sound[0]["magnetometer"], value)}
    words = advice(tmp_path, table, declared())
    assert said in words
    without = declared()
    without["signals"] = [one for one in without["signals"] if one["quantity"] != "magnetometer"]
    done = processed(tmp_path, sound[0], without)
    assert done.exit_code == 0, done.output
    six = orientation(tmp_path)
    (tmp_path / "out").rename(tmp_path / "six")
    is_right(tmp_path, table, without, six)


def test_a_larger_range_or_a_slower_movement_as_advised(sound, tmp_path):
    level = 0.5 * np.abs(sound[0]["gyroscope"]).max()
    table = sound[0] | {"gyroscope": np.clip(sound[0]["gyroscope"], -level, level)}
    words = warned(tmp_path, table, declared())
    said = re.search(r"gyroscope stops at ([0-9]+)", words)
    assert float(said[1]) == pytest.approx(np.degrees(level), rel=0.01)
    assert "Choose a larger range or move more slowly" in words
    larger = 1.1 * np.abs(sound[0]["gyroscope"]).max()
    is_right(
        tmp_path,
        sound[0] | {"gyroscope": np.clip(sound[0]["gyroscope"], -larger, larger)},
        declared(),
        sound[1],
    )
    for file in (tmp_path / "out").iterdir():
        file.unlink()
    (tmp_path / "out").rmdir()
    # The same way in three times the time: what is added to gravity shrinks with its square.
    up = 9.81 * _up(sound)
    slow = {
        "time_s": 3.0 * sampled_at(),
        "gyroscope": np.clip(sound[0]["gyroscope"] / 3.0, -level, level),
        "accelerometer": up + (sound[0]["accelerometer"] - up) / 9.0,
        "magnetometer": sound[0]["magnetometer"],
    }
    done = processed(tmp_path, slow, declared())
    assert done.exit_code == 0, done.output
    assert "stops at" not in done.output


def test_a_larger_range_of_the_accelerometer_as_advised(sound, tmp_path):
    level = 2.0 * 9.80665
    up = 9.81 * _up(sound)
    force = 2.2 * (sound[0]["accelerometer"] - up) + up
    table = sound[0] | {"accelerometer": np.clip(force, -level, level)}
    words = warned(tmp_path, table, declared())
    assert re.search(r"accelerometer stops at 19\.[0-9]", words)
    assert "Choose a larger range" in words
    done = processed(tmp_path, sound[0] | {"accelerometer": force}, declared())
    assert done.exit_code == 0, done.output
    assert "stops at" not in done.output


def _up(sound) -> np.ndarray:
    """Return the vertical in the sensor at each row of the table."""
    turned = sound[1][: len(sound[0]["gyroscope"])]
    return np.asarray(rotation.rotate(rotation.conjugate(turned), np.array([0.0, 0.0, 1.0])))


def test_a_compass_with_iron_on_it_is_calibrated_as_advised(sound, tmp_path):
    table = sound[0] | {"magnetometer": sound[0]["magnetometer"] + np.array([14.0, -9.0, 11.0])}
    words = warned(tmp_path, table, declared())
    assert "magnetic field varies by" in words
    assert "calibrate the magnetometer" in words
    iron = fit_sphere(1e-6 * table["magnetometer"][::5]).centre
    calibrated = table | {"magnetometer": table["magnetometer"] - 1e6 * np.asarray(iron)}
    # A sphere through what fifteen seconds have seen is known to some hundredths.
    is_right(tmp_path, calibrated, declared(), sound[1], within_deg=3.0)


def test_a_compass_beside_iron_is_moved_away_from_it_as_advised(sound, tmp_path):
    near = 1.0 + 1.6 * (np.arange(len(sound[0]["gyroscope"]))[:, None] > 1500)
    words = warned(tmp_path, sound[0] | {"magnetometer": near * sound[0]["magnetometer"]}, declared())
    assert "Go away from iron" in words
    is_right(tmp_path, sound[0], declared(), sound[1])


def resting(rng_seed: int = 4, rows: int = 3000) -> dict[str, np.ndarray]:
    """Readings of a sensor that lies still, in the units of `SOUND`."""
    rng = np.random.default_rng(rng_seed)
    return {
        "gyroscope": np.array([0.002, -0.004, 0.003]) + 0.002 * rng.normal(size=(rows, 3)),
        "accelerometer": np.array([0.3, -0.2, 9.8]) + 0.02 * rng.normal(size=(rows, 3)),
        "magnetometer": np.array([18.0, 4.0, -42.0]) + 0.2 * rng.normal(size=(rows, 3)),
    }


def test_degrees_per_second_at_rest_as_advised(tmp_path):
    table = resting()
    table["gyroscope"] = 1.7 * np.degrees(table["gyroscope"])
    words = warned(tmp_path, table, declared())
    assert "while the accelerometer stands still" in words
    assert "these may be degrees/s: declare them so" in words
    done = processed(tmp_path, table, corrected(declared(), "gyroscope", unit="deg/s"))
    assert done.exit_code == 0, done.output
    assert "warning" not in done.output


def test_the_zero_of_a_gyroscope_as_advised(tmp_path):
    table = resting()
    zero = np.array([0.2, -0.25, 0.1])
    words = warned(tmp_path, table | {"gyroscope": table["gyroscope"] + zero}, declared())
    assert "otherwise find the gyroscope zero" in words
    # What it reads at rest is its zero.
    offset = (table["gyroscope"] + zero)[:1000].mean(axis=0)
    done = processed(tmp_path, table | {"gyroscope": table["gyroscope"] + zero - offset}, declared())
    assert done.exit_code == 0, done.output
    assert "warning" not in done.output


NUMBER = r"([0-9]+(?:\.[0-9]+)?)"


def said_of(folder: Path, table: dict[str, np.ndarray]) -> str:
    """Return what is said of a recording, refused or not: one of a few seconds is only doubted."""
    done = processed(folder, table, declared())
    return " ".join(f"{done.output} {done.exception}".split())


@pytest.mark.parametrize("factor", [0.5, 0.64])
def test_a_wrong_rate_as_advised(sound, tmp_path, factor):
    """The times are `factor` times too short: the sensor turns so much farther than its gyroscope seems to say."""
    table = sound[0] | {"time_s": sampled_at() / factor}
    words = said_of(tmp_path, table)
    found = re.search(rf"turns {NUMBER} times as far .* come at {NUMBER} Hz, not at {NUMBER} Hz", words)
    assert found is not None, words
    assert "axes of the" not in words
    turns, rate_hz, said_hz = map(float, found.groups())
    true_hz = 1.0 / float(np.diff(sampled_at()).mean())
    assert (turns, rate_hz) == (pytest.approx(factor, rel=0.03), pytest.approx(true_hz, rel=0.03))
    assert said_hz == pytest.approx(factor * true_hz, rel=0.01)
    # By its rows: at a true rate that is no whole number other frames are estimated than by stamps.
    true, right = tmp_path / "true", tmp_path / "right"
    true.mkdir()
    right.mkdir()
    processed(true, table, declared() | {"time_column": None, "rate_hz": true_hz})
    expected = orientation(true)
    # The rate is found to a percent; a device's own is known to who set it.
    mapping = declared() | {"time_column": None, "rate_hz": rate_hz}
    is_right(right, table, mapping, expected, within_deg=3.0)


def test_a_wrong_rate_of_few_seconds_is_not_named_and_not_kept_silent(sound, tmp_path):
    """In seven and a half seconds a jump looks the same."""
    words = said_of(tmp_path, sound[0] | {"time_s": sampled_at() / 2.0})
    assert "does not fit" in words
    assert "Check the rate and the time stamps first" in words


@pytest.mark.parametrize("factor", [2.0, 0.5])
def test_a_wrong_range_as_advised(sound, tmp_path, factor):
    table = sound[0] | {"gyroscope": sound[0]["gyroscope"] / factor}
    words = advice(tmp_path, table, declared())
    said = float(re.search(rf"multiply its columns by {NUMBER}", words)[1])
    assert said == pytest.approx(factor, rel=0.03)
    is_right(tmp_path, table | {"gyroscope": said * table["gyroscope"]}, declared(), sound[1])
