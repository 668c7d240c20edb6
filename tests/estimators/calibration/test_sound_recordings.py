"""Sound recordings of any movement, device and rate are accused of nothing; what does not fit is blamed on nothing."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.calibration import RecordingCheck, check_recording
from estimators.calibration.field.dip import _differ
from estimators.calibration.plausibility.explanation import Explanation, explain
from estimators.magnetic import perpendicular_source
from estimators.recording import ImuChunk
from estimators.simulation.coil.motion import relative_motion
from estimators.simulation.coil.scene import relative_scene
from validation.orientation.false_diagnoses import accusations
from validation.orientation.sound_recordings import MOVES, sound_recording

FRESH = range(70_000, 71_000)
"""No threshold was set with these."""


def recording(moves: str, has_field: bool, *, most_ticks: int = 3_000):
    """Return the first fresh recording of a kind."""
    for seed in FRESH:
        generator = np.random.default_rng([seed, 44])
        if str(generator.choice(MOVES)) == moves:
            made = sound_recording(seed)
            if (made.chunk.magnetometer_t is not None) == has_field and made.chunk.tick_count <= most_ticks:
                return made
    raise AssertionError(f"no {moves} among fresh seeds")


@pytest.mark.parametrize("moves", ["hand", "swings", "circles", "hinge", "turns", "module"])
def test_sound_recordings_are_accused_of_nothing(moves):
    assert accusations(recording(moves, has_field=moves != "circles")) == ([], [])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(71_000, 71_020))
def test_more_sound_recordings_are_accused_of_nothing(seed):
    assert accusations(sound_recording(seed)) == ([], [])


def explained(chunk: ImuChunk) -> Explanation | None:
    check = RecordingCheck(["hand_left"], "unknown")
    check.add(chunk)
    (sensor,) = check._sensors
    return explain(sensor.evidence, sensor.fastest_radps)


@pytest.mark.parametrize("seed", [3, 34, 56])
def test_a_steady_swing_is_no_rest_and_no_fault(seed):
    """On a circle at even pace the force stands still in the sensor; on a swing of constant length it hardly turns."""
    assert accusations(sound_recording(seed)) == ([], [])


@pytest.mark.parametrize("seed", [20_071, 20_084])
def test_an_accelerometer_read_at_the_end_of_a_step_has_no_offset(seed):
    """An arm at 25 Hz: half a step late, force seems to turn with the sensor as an offset does."""
    assert accusations(sound_recording(seed)) == ([], [])


@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(226, id="one offset of a device is paid once, not with each look"),
        pytest.param(510, id="a gyroscope that is read smaller goes on a smaller circle"),
        pytest.param(667, id="a hinge shows on the other axes that those of a device are not quite square"),
        pytest.param(96, id="iron on the device is no matter of the room"),
        pytest.param(8774, id="iron in the room turns a flat field up, here more and there less"),
    ],
)
def test_what_a_sound_device_and_an_ordinary_movement_do_is_no_fault(seed):
    """Each was accused: of axes, a gyroscope's unit, axes, a field that varies by 16 %, gravity the other way round."""
    assert accusations(sound_recording(seed)) == ([], [])


@pytest.mark.parametrize(
    ("sines", "is_in_doubt"),
    [
        pytest.param(
            [-0.52, -0.51, -0.51, -0.51, -0.52, -0.45, -0.34, -0.21, -0.15, -0.16], False, id="two places"
        ),
        pytest.param(
            [-0.54, -0.65, -0.65, -0.38, -0.64, -0.63, -0.16, -0.17, -0.65, -0.21], False, id="two more"
        ),
        pytest.param([-0.30, -0.28, -0.31], False, id="one place"),
        pytest.param([-0.01, -0.24, -0.49, -0.41], True, id="few that scatter"),
        pytest.param([-0.5, 0.1, -0.4, -0.3, 0.3, -0.2, -0.6, -0.1, 0.2], True, id="either way"),
    ],
)
def test_windows_that_point_one_way_decide_although_they_scatter(sines, is_in_doubt):
    """Who goes to another table has two fields; reversed gravity is found in both of them."""
    assert _differ(np.array(sines)) == is_in_doubt


@pytest.mark.parametrize("seed", [320_033, 320_040])
@pytest.mark.parametrize("change", [-np.eye(3), np.eye(3)[[1, 0, 2]]], ids=["reversed", "exchanged"])
def test_axes_of_a_walk_are_not_called_a_quick_clock(seed, change):
    """On a clock five times as quick little time passes, and any turn fits the force of so short a while."""
    made = sound_recording(seed)
    chunk, (name,) = made.chunk, made.names[3:4]
    turned = replace(
        chunk,
        gyroscope_radps=chunk.gyroscope_radps[3:4] @ change.T,
        accelerometer_mps2=chunk.accelerometer_mps2[3:4],
        magnetometer_t=None,
        quality=chunk.quality[3:4],
    )
    found = check_recording(turned, [name], hemisphere=made.hemisphere)
    assert {one.subject[1] for one in found} == {"axes"}


def beside_a_source(seed: int) -> ImuChunk:
    """The upper arm of the demonstration's magnetic session: it turns about one axis, never rests, and has offsets."""
    motion = relative_motion("shoulder", 45.0, seed)
    made = relative_scene(perpendicular_source(), motion, 45.0, 120.0, seed=seed)
    readings = (made.gyroscope_radps, made.accelerometer_mps2, made.ambient_t)
    return ImuChunk(
        0, made.time_step_s, *(one[None] for one in readings), np.zeros((1, len(made.time_s)), np.uint8)
    )


def test_an_offset_is_not_taken_for_exchanged_axes():
    """The offset of the demonstration's gyroscope fitted other axes by 26 of logarithm."""
    chunk = beside_a_source(3)
    assert explained(chunk) is None
    swapped = explained(replace(chunk, gyroscope_radps=chunk.gyroscope_radps[..., [2, 1, 0]]))
    assert swapped is not None
    assert (swapped.triads, swapped.is_certain) == ({"gyroscope"}, True)


def test_what_no_single_fault_explains_is_blamed_on_nothing():
    """Gyroscope and magnetometer have each other axes than the accelerometer has."""
    chunk = beside_a_source(4)
    assert chunk.magnetometer_t is not None
    both = replace(
        chunk,
        gyroscope_radps=chunk.gyroscope_radps[..., [1, 2, 0]],
        magnetometer_t=chunk.magnetometer_t[..., [0, 2, 1]],
    )
    (found,) = check_recording(both, ["hand_left"], hemisphere="unknown")
    assert (found.code, found.severity) == ("unexplained", "warning")
    assert found.message.code == "readings.unexplained"
