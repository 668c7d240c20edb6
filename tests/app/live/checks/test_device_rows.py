"""What a session taught about its sensors is kept, but not of readings that could not be right."""

from collections.abc import Callable
from typing import Any

import pytest
from sqlalchemy import Engine, select

from app.database.unit_of_work import read_only, unit_of_work
from app.live.calibration.device_rows import save_device_calibrations, save_device_constants
from app.patients.models import SensorDevice
from app.recordings.models import MotionSession, SessionEvent
from estimators.calibration import DeviceCalibration, LocalField, TriadCalibration
from estimators.orientation import DeviceConstants
from estimators.pipelines import SessionSetup
from tests.app.recordings.storage.test_writer_counts import statements_of

ARM: tuple[Any, ...] = ("sternum", "upper_arm_right", "forearm_right")


@pytest.fixture
def streamed(engine: Engine, world: Any) -> Callable[..., str]:
    """A session in which something was told of a sensor."""

    def make(placement: str, severity: str) -> str:
        with unit_of_work(engine) as session:
            found = MotionSession(
                clinic_id=world.clinic_id,
                patient_id=world.patient_id,
                setup=SessionSetup("arm", ARM, 100.0).to_dict(),
                created_by=world.accounts["therapist"],
            )
            session.add(found)
            session.flush()
            told = {"code": "gyroscope_axes", "severity": severity}
            event = {"kind": "implausible", "time_s": 12.0, "placement": placement, "details": told}
            session.add(SessionEvent(session_id=found.id, **event))
            return found.id

    return make


def test_the_field_at_the_calibration_is_kept_with_the_device(
    engine: Engine, streamed: Callable[..., str]
) -> None:
    field = LocalField(48.2e-6, float("nan"), 0.4e-6, float("nan"))
    device = DeviceCalibration(magnetometer=TriadCalibration(bias=(1e-6, 2e-6, 3e-6)), field=field)
    serials = {"sternum": "serial of sternum"}
    session_id = streamed("sternum", "warning")
    save_device_calibrations(engine, session_id, serials, {"sternum": device}, {"sternum": 0.9})
    with read_only(engine) as session:
        stored = session.scalars(select(SensorDevice)).one()
        # PostgreSQL takes no NaN in JSON.
        assert stored.calibration["field"]["dip_rad"] is None
        known = DeviceCalibration.from_dict(stored.calibration)
    assert known.field is not None
    assert known.field.norm == field.norm
    assert known.magnetometer == device.magnetometer


def test_nothing_is_kept_of_a_sensor_that_cannot_be_right(
    engine: Engine, streamed: Callable[..., str]
) -> None:
    learnt = dict.fromkeys(ARM, DeviceConstants(magnetometer_delay_s=0.01))
    serials = {name: f"serial of {name}" for name in ARM}
    save_device_constants(engine, streamed("sternum", "warning"), serials, {"sternum": learnt["sternum"]})
    save_device_constants(engine, streamed("forearm_right", "refuse"), serials, learnt)
    with read_only(engine) as session:
        rows = {row.serial: row.constants for row in session.scalars(select(SensorDevice))}
    assert set(rows) == {serials["sternum"], serials["upper_arm_right"]}
    assert rows[serials["sternum"]]["magnetometer_delay_s"] == 0.01


def test_many_sensors_take_the_statements_of_one(
    engine: Engine, world: Any, streamed: Callable[..., str]
) -> None:
    """Whoever ends a session of seventeen sensors must not hold up those who go on."""
    serials = {name: f"serial of {name}" for name in ARM}

    def saved(delay_s: float, placements: tuple[Any, ...]) -> int:
        learnt = dict.fromkeys(placements, DeviceConstants(magnetometer_delay_s=delay_s))
        session_id = streamed("sternum", "warning")
        return statements_of(engine, lambda: save_device_constants(engine, session_id, serials, learnt))

    assert saved(0.01, ARM) == saved(0.02, ARM) == saved(0.03, ARM[:1])
    own = select(SensorDevice).where(SensorDevice.clinic_id == world.clinic_id)
    with read_only(engine) as session:
        rows = {row.serial: row.constants["magnetometer_delay_s"] for row in session.scalars(own)}
    assert rows == {serials[name]: 0.03 if name == ARM[0] else 0.02 for name in ARM}
