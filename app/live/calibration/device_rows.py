"""Knowledge of sensors by their serial numbers: calibrations made in the hand, constants learnt.

All functions block; the live side calls them in a thread. Only sensors whose gateway tells serial numbers are
remembered: a name such as "phone" may be another phone tomorrow.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from sqlalchemy import Engine, Select, select
from sqlalchemy.orm import Session

from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.network.declaration import Declaration
from app.patients.models import SensorDevice
from app.recordings.models import MotionSession, SessionEvent
from estimators.calibration import DeviceCalibration
from estimators.conventions import Placement
from estimators.pipelines import DeviceConstants, SessionSetup


def with_known_devices(
    engine: Engine, clinic_id: str, setup: SessionSetup, declaration: Declaration
) -> SessionSetup:
    """Return the setup with what is remembered of the sensors that the gateway declares."""
    serials = declaration.serial_of
    if not serials:
        return setup
    with read_only(engine) as session:
        rows = {row.serial: row for row in session.scalars(_devices(clinic_id, serials.values()))}
        found = {placement: rows[serial] for placement, serial in serials.items() if serial in rows}
        return replace(
            setup,
            devices={
                p: DeviceCalibration.from_dict(row.calibration) for p, row in found.items() if row.calibration
            },
            device_constants={
                p: DeviceConstants.from_dict(row.constants) for p, row in found.items() if row.constants
            },
        )


def save_device_calibrations(
    engine: Engine,
    session_id: str,
    serials: Mapping[Placement, str],
    found: Mapping[Placement, DeviceCalibration],
    scores: Mapping[Placement, float],
) -> None:
    """Remember calibrations made in the hand; constants learnt with the readings before are forgotten."""
    with unit_of_work(engine) as session:
        rows = _rows(session, session_id, [serials[one] for one in found if one in serials])
        for placement, device in found.items():
            if placement in serials:
                row = rows[serials[placement]]
                row.calibration = device.to_dict()
                row.scores = {**row.scores, **_scored(device, scores.get(placement, 1.0))}
                row.constants = {}


def save_device_constants(
    engine: Engine,
    session_id: str,
    serials: Mapping[Placement, str],
    found: Mapping[Placement, DeviceConstants],
) -> None:
    """Remember what a session learnt about its sensors; nothing learnt, nothing stored.

    Nor is anything stored of a sensor whose readings could not be right: swapped axes or a wrong unit look like a
    device with large constants, which would spoil the next session, where the readings are right.
    """
    with unit_of_work(engine) as session:
        refused = {
            event.placement
            for event in session.scalars(
                select(SessionEvent).where(
                    SessionEvent.session_id == session_id, SessionEvent.kind == "implausible"
                )
            )
            if event.details.get("severity") == "refuse"
        }
        learnt = {
            serials[placement]: constants.to_dict()
            for placement, constants in found.items()
            if placement in serials and placement not in refused and constants != DeviceConstants()
        }
        for serial, row in _rows(session, session_id, learnt).items():
            row.constants = learnt[serial]


def _devices(clinic_id: str, serials: Iterable[str]) -> Select[SensorDevice]:
    return select(SensorDevice).where(SensorDevice.clinic_id == clinic_id, SensorDevice.serial.in_(serials))


def _scored(device: DeviceCalibration, score: float) -> dict[str, float]:
    names = ("accelerometer", "gyroscope", "magnetometer")
    return {name: score for name in names if getattr(device, name) is not None}


def _rows(session: Session, session_id: str, serials: Collection[str]) -> dict[str, SensorDevice]:
    """Return the rows of devices by serial number, new ones where there are none: written by this session, now."""
    if not serials:
        return {}
    clinic_id = session.scalars(select(MotionSession.clinic_id).where(MotionSession.id == session_id)).one()
    rows = {row.serial: row for row in session.scalars(_devices(clinic_id, serials))}
    for serial in serials:
        if serial not in rows:
            rows[serial] = SensorDevice(
                clinic_id=clinic_id, serial=serial, calibration={}, scores={}, constants={}
            )
            session.add(rows[serial])
        rows[serial].session_id, rows[serial].updated_at = session_id, utc_now()
    return rows
