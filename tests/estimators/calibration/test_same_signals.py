"""One sensor under several names is found by its noise; sensors that lie still in parallel are not."""

import numpy as np
import pytest

from estimators.calibration import check_distinct
from estimators.errors import CalibrationError

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
