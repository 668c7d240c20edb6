"""Who follows the advice of `telemotion process` by its own means gets what the sound recording gives."""

import numpy as np
import pytest

from estimators import rotation
from tests.app.commands.advice import (
    SOUND,
    advice,
    as_advised,
    corrected,
    declared,
    is_right,
    sound_recording,
)


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Readings, and what is estimated of them."""
    return sound_recording(tmp_path_factory.mktemp("sound"))


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
