"""Magnetic sources of a clinic: their coils as they were measured, stored by serial number, chosen for sessions.

They are no patient data: everybody who works in the clinic may see and replace them. Calibrating one from a session
reads that session, which needs the right to treat its patient. A session keeps the coils that it was recorded with.
"""

from typing import Any, Final

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.models import Account
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, InvalidInput, NotAllowed
from app.kinds.magnetic.bench import Bench, coils_out, findings
from app.kinds.magnetic.known_sources import find_source
from app.kinds.magnetic.safety import PIPELINE
from app.kinds.magnetic.source_schemas import (
    MagneticSourceIn,
    MagneticSourceOut,
    SourceCalibrationIn,
    SourceStopsOut,
)
from app.recordings import repository
from app.recordings.analysis.offline import aligned
from app.recordings.models import MagneticSource, MotionSession
from estimators.conventions import Placement
from estimators.errors import SetupError
from estimators.pipelines import SessionSetup, relative_source
from estimators.sentences import say

_STAFF: Final = ("therapist", "administrator")


def list_sources(session: Session, subject: Subject) -> list[MagneticSourceOut]:
    """Return the sources of the clinic by name, without retired ones."""
    _require_staff(subject)
    query = select(MagneticSource).where(
        MagneticSource.clinic_id == subject.clinic_id, MagneticSource.retired_at.is_(None)
    )
    return [_told(session, row) for row in session.scalars(query.order_by(MagneticSource.name))]


def keep(session: Session, subject: Subject, wanted: MagneticSourceIn) -> MagneticSourceOut:
    """Store a source with typed or imported coils; one with the same serial number is replaced.

    Raises
    ------
    NotAllowed
        Not somebody who works in the clinic.
    InvalidInput
        No source that a body may wear.
    """
    _require_staff(subject)
    return _told(session, _store(session, subject, wanted, wanted.method, None))


def retire(session: Session, subject: Subject, source_id: str) -> None:
    """Offer a source no longer; doing it twice is doing it once."""
    _require_staff(subject)
    row = find_source(session, subject, source_id)
    if row.retired_at is None:
        row.retired_at = utc_now()
        audit.record(session, subject, "source.retire", None, row.id, {"serial": row.serial})


def stops(session: Session, subject: Subject, session_id: str, sensor: Placement | None) -> SourceStopsOut:
    """Return where the sensor lay still in a bench session."""
    found = _bench_session(session, subject, session_id, "session.source_stops")
    bench = _bench(session, found, sensor)
    return SourceStopsOut(source=bench.source, sensor=bench.sensor, stops=bench.to_schema())


def calibrate(
    engine: Engine, subject: Subject, session_id: str, wanted: SourceCalibrationIn
) -> MagneticSourceOut:
    """Find the coils of a source from a bench session and keep them.

    Nothing is locked while they are found: that takes seconds, in which other patients' packets must be stored.

    Raises
    ------
    InvalidInput
        Places and stops do not fit, or no coils explain the pulses.
    """
    with read_only(engine) as session:
        found = _bench_session(session, subject, session_id, "session.source_calibration")
        bench = _bench(session, found, wanted.sensor)
    fit = bench.calibrate(wanted.positions_m, wanted.place_sigma_m)
    described = MagneticSourceIn(
        name=wanted.name,
        serial=wanted.serial,
        coils=coils_out(fit.source),
        current_limit_a=bench.current_limit_a,
        gain_sigma=fit.gain_sigma,
        found=findings(fit, sum(place is not None for place in wanted.positions_m)),
    )
    with unit_of_work(engine) as session:
        return _told(session, _store(session, subject, described, "session", session_id))


def _require_staff(subject: Subject) -> None:
    if subject.role not in _STAFF:
        raise NotAllowed(say("source.not_allowed"))


def _store(
    session: Session, subject: Subject, wanted: MagneticSourceIn, method: str, session_id: str | None
) -> MagneticSource:
    coils = [coil.model_dump(mode="json") for coil in wanted.coils]
    _check(coils, wanted.current_limit_a, wanted.gain_sigma)
    row = session.scalar(
        select(MagneticSource).where(
            MagneticSource.clinic_id == subject.clinic_id, MagneticSource.serial == wanted.serial
        )
    )
    if row is None:
        row = MagneticSource(clinic_id=subject.clinic_id, serial=wanted.serial)
        session.add(row)
    row.name, row.coils = wanted.name, coils
    row.current_limit_a, row.gain_sigma = wanted.current_limit_a, wanted.gain_sigma
    row.found, row.method, row.session_id = wanted.found.model_dump(mode="json"), method, session_id
    row.calibrated_at, row.calibrated_by = wanted.calibrated_at or utc_now(), subject.id
    row.retired_at = None
    session.flush()
    facts = {"serial": row.serial, "method": method, "gain_sigma": row.gain_sigma, "session": session_id}
    audit.record(session, subject, "source.calibrate", None, row.id, facts)
    return row


def _check(coils: list[dict[str, Any]], current_limit_a: float, gain_sigma: float) -> None:
    parameters = {"calibrated_coils": coils, "current_limit_a": current_limit_a, "gain_sigma": gain_sigma}
    try:
        relative_source(
            SessionSetup("relative_pose", ("pelvis", "sternum"), 100.0, orientation_parameters=parameters)
        )
    except SetupError as error:
        raise InvalidInput(say("source.impossible", reason=error.message), field="coils") from error


def _bench_session(session: Session, subject: Subject, session_id: str, action: str) -> MotionSession:
    found = repository.get_session(session, subject, session_id, "treat", action=action)
    if found.setup["pipeline"] != PIPELINE:
        raise Conflict(say("magnetic.no_source"))
    if found.state not in {"analysed", "failed"}:
        raise Conflict(say("session.not_finished"), state=found.state)
    return found


def _bench(session: Session, found: MotionSession, sensor: Placement | None) -> Bench:
    setup = SessionSetup.from_dict(found.setup)
    pieces = aligned(session, found.id, found.hello, setup.placements)
    return Bench(pieces, setup, sensor)


def _told(session: Session, row: MagneticSource) -> MagneticSourceOut:
    account = session.get(Account, row.calibrated_by)
    own = {name: getattr(row, name) for name in MagneticSourceOut.model_fields if name != "calibrated_by"}
    return MagneticSourceOut.model_validate(
        own | {"calibrated_by": None if account is None else account.display_name}
    )
