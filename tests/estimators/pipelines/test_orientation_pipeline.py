"""Single sensors: the contract, any name, and orientation equal to the filter's own."""

from dataclasses import replace

import numpy as np
import pytest
from pipeline_contract import PipelineContract

from estimators import orientation
from estimators.errors import SetupError
from estimators.pipelines import SessionSetup, create
from tests.said import refuses


@pytest.fixture
def setup():
    return SessionSetup("orientation", ("imu", "another one"), 100.0)


@pytest.fixture
def chunk(ticks, gaps):
    whole = gaps(ticks)
    return replace(
        whole,
        gyroscope_radps=whole.gyroscope_radps[:2],
        accelerometer_mps2=whole.accelerometer_mps2[:2],
        magnetometer_t=whole.magnetometer_t[:2],
        quality=whole.quality[:2],
    )


class TestContract(PipelineContract):
    pass


class TestContractCalibrated(PipelineContract):
    pose = (100, 500)
    method = "static"


def test_orientation_is_that_of_the_filter(setup, chunk):
    frames = create(setup).step(chunk)
    alone = orientation.create(orientation.DEFAULT, 2, 0.01).update(chunk)
    assert np.array_equal(frames.q_room_segment, alone.q_earth_sensor.swapaxes(0, 1))
    assert np.array_equal(frames.segment_flags, alone.flags.T)
    # Room and earth are one here, and the sensor is the segment: nothing is added to what the filter says.
    np.testing.assert_allclose(frames.segment_sigma_rad, alone.sigma_rad.swapaxes(0, 1), rtol=1e-12)
    assert np.isfinite(frames.segment_sigma_rad[-1]).all()


def test_only_static_calibration(setup, chunk):
    pipeline = create(setup)
    pipeline.step(chunk.ticks(0, 1500))
    with refuses("calibration.single_sensors", error=SetupError):
        pipeline.calibrate(chunk.ticks(100, 400), "n_pose")
    with refuses("calibration.moved"):
        pipeline.calibrate(chunk.ticks(900, 1500), "static")
