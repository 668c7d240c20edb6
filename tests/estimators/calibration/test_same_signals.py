"""One sensor under several names is found by its noise; sensors that lie still in parallel are not."""

import numpy as np
import pytest

from estimators.calibration import check_distinct, same_signals
from estimators.errors import CalibrationError
from estimators.recording import ImuChunk

PLACEMENTS = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
GYROSCOPE_SD_RADPS, ACCELEROMETER_SD_MPS2 = 0.003, 0.02
GYROSCOPE_COUNT_RADPS, ACCELEROMETER_COUNT_MPS2 = np.deg2rad(0.07), 9.81 / 4096
"""A 16-bit sensor at 2000 degrees a second and 8 g."""


def lying(
    seed: int, noise: float = 1.0, counts: bool = False, sway: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Four sensors in parallel for three seconds at 100 Hz, shape (4, 300, 3) each; sway is common to all."""
    rng = np.random.default_rng(seed)
    common = sway * np.sin(2.0 * np.pi * 5.0 * np.arange(300) / 100.0)[None, :, None]
    turning = common + noise * rng.normal(0.0, GYROSCOPE_SD_RADPS, (4, 300, 3))
    force = [0.0, 0.0, 9.81] + common + noise * rng.normal(0.0, ACCELEROMETER_SD_MPS2, (4, 300, 3))
    if counts:
        turning = np.round(turning / GYROSCOPE_COUNT_RADPS) * GYROSCOPE_COUNT_RADPS
        force = np.round(force / ACCELEROMETER_COUNT_MPS2) * ACCELEROMETER_COUNT_MPS2
    return turning, force


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(
    "how",
    [{}, {"counts": True}, {"counts": True, "noise": 0.1}, {"counts": True, "noise": 0.0}, {"sway": 0.02}],
    ids=["noise", "counts", "hardly a count", "no count", "common tremor"],
)
def test_sensors_that_lie_in_parallel_are_distinct(seed, how):
    check_distinct(*lying(seed, **how), PLACEMENTS)


@pytest.mark.parametrize("counts", [False, True])
@pytest.mark.parametrize("added", [0.0, 0.05], ids=["identical", "nearly"])
def test_copies_are_named(counts, added):
    turning, force = lying(7, counts=counts)
    rng = np.random.default_rng(8)
    for values, sd in ((turning, GYROSCOPE_SD_RADPS), (force, ACCELEROMETER_SD_MPS2)):
        # Another zero does not make another sensor.
        values[3] = values[1] + 0.01 + added * sd * rng.normal(size=values[1].shape)
    with pytest.raises(
        CalibrationError, match="right upper arm and right hand send the same signal"
    ) as refused:
        check_distinct(turning, force, PLACEMENTS)
    assert refused.value.args[0].parameters["where"] == ["upper_arm_right", "hand_right"]


def test_copies_of_a_sensor_whose_gyroscope_shows_no_count_are_found_by_force():
    turning, force = lying(9, counts=True)
    turning[:] = 0.0
    force[2] = force[0]
    with pytest.raises(CalibrationError, match="chest and right forearm"):
        check_distinct(turning, force, PLACEMENTS)


def chunk(turning: np.ndarray, force: np.ndarray) -> ImuChunk:
    return ImuChunk(
        first_tick=0,
        time_step_s=0.01,
        gyroscope_radps=turning,
        accelerometer_mps2=force,
        magnetometer_t=None,
        quality=np.zeros(turning.shape[:2], np.uint8),
    )


def moving(seed: int, rest_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Four sensors on one rigid limb that swings at 1 Hz and 3 rad/s for 20 s, after a rest."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(2000) / 100.0
    swing = np.where(time_s < rest_s, 0.0, 3.0 * np.sin(2.0 * np.pi * time_s))[None, :, None]
    turning = swing + rng.normal(0.0, GYROSCOPE_SD_RADPS, (4, 2000, 3))
    force = [0.0, 0.0, 9.81] + 3.0 * swing + rng.normal(0.0, ACCELEROMETER_SD_MPS2, (4, 2000, 3))
    return turning, force


@pytest.mark.parametrize("rest_s", [0.0, 6.0])
@pytest.mark.parametrize("seed", range(5))
def test_sensors_of_a_recording_that_move_as_one_are_distinct(seed, rest_s):
    assert same_signals(chunk(*moving(seed, rest_s))) == []


@pytest.mark.parametrize("rest_s", [0.0, 6.0])
def test_copies_in_a_recording_are_found_with_and_without_a_rest(rest_s):
    turning, force = moving(1, rest_s)
    for values in (turning, force):
        values[3] = values[1] + 0.01
        values[2, 40:50] = np.nan
    assert same_signals(chunk(turning, force)) == [1, 3]


def test_nothing_is_told_of_sensors_that_were_hardly_there():
    turning, force = moving(1, 6.0)
    assert same_signals(chunk(turning[:, :1], force[:, :1])) == []
    turning[:], force[:] = np.nan, np.nan
    assert same_signals(chunk(turning, force)) == []
