"""Commands on the database: migrate, backup, restore, reprocess, check the audit trail."""

import json
import zipfile
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import typer
from sqlalchemy import select

from app import tables as tables
from app.accounts import audit
from app.accounts.credentials.password_rules import check_password
from app.accounts.credentials.passwords import Passwords
from app.accounts.credentials.sign_in import normalise_email
from app.accounts.models import Account, Clinic
from app.accounts.subject import Subject
from app.assessment.records import ended_again
from app.database import backup as archives
from app.database import ended
from app.database import engine as engines
from app.database import migrate as migrations
from app.database.base import new_id
from app.database.ended import Ended
from app.database.unit_of_work import read_only, unit_of_work
from app.database.writer_lock import writer_lock
from app.errors import Conflict, InvalidInput, NotFound, TelemotionError
from app.recordings import service
from app.recordings.analysis.jobs import run_job
from app.recordings.analysis.reprocess import reprocess as reprocess_task
from app.recordings.models import MotionSession
from app.recordings.schemas import ReprocessIn
from app.scaled import backup as whole
from app.settings import Settings


def migrate() -> None:
    """Bring the database to the newest schema and say which that is.

    Raises
    ------
    Conflict
        A service runs on it, or a newer version has made it.
    """
    _bring_up(Settings(), "telemotion migrate")
    typer.echo(f"database is at revision {migrations.newest_revision()}")


def _bring_up(settings: Settings, purpose: str) -> None:
    """Migrate a database that needs it; a service that runs on it is never migrated under."""
    if not migrations.is_newest(settings.database_url):
        with writer_lock(settings.database_url, purpose):
            migrations.upgrade(settings.database_url)


def backup(archive: Path) -> None:
    """Write the whole database to a new file and read it back; of a service on many machines its streams too.

    Raises
    ------
    Conflict
        The file exists.
    InvalidInput
        It is one of many machines, and NATS cannot be reached.
    """
    if archive.exists():
        raise Conflict(f"{archive} exists; name a new file")
    settings = Settings()
    engine = engines.create(settings)
    try:
        whole.backup(engine, settings, archive)
    finally:
        engine.dispose()
    manifest = archives.verify(archive)
    typer.echo(
        f"{archive}: {archive.stat().st_size / 1e6:.1f} MB, {sum(manifest.rows.values())} rows, verified"
    )


def restore(archive: Path, registers: Sequence[Path] = ()) -> None:
    """Fill an empty database from a backup; of one of many machines that had something in its streams, them too.

    What was erased, revoked or withdrawn after the backup is so again, as far as a register says it: that of the data
    folder, that of the backup itself, and those that are named.

    Parameters
    ----------
    registers : sequence of Path
        Registers, or newer backups, which carry one.

    Raises
    ------
    Conflict
        A service runs on the database, or it is not empty; or what was in streams can only be read by workers.
    InvalidInput
        It is one of many machines, and NATS cannot be reached; or there is no such register.
    """
    settings = Settings()
    own = ended.path_of(settings)
    named = [entry for path in registers for entry in _register_in(path)]
    known_until = datetime.fromtimestamp(own.stat().st_mtime, UTC) if own.exists() else None
    with writer_lock(settings.database_url, "telemotion restore"):
        manifest = whole.restore(archive, settings)
        ended.add(own, [*named, *_register_in(archive)])
        engine = engines.create(settings)
        try:
            done = ended_again.apply(engine, settings, ended.read(own))
        finally:
            engine.dispose()
    typer.echo(f"{sum(manifest.rows.values())} rows restored")
    typer.echo(ended_again.in_words(done) or "erased again: nobody, revoked: nothing")
    if known_until is not None:
        typer.echo(f"The register of erasures and revocations reaches to {known_until:%Y-%m-%d %H:%M} UTC.")
    elif not registers:
        typer.echo(
            f"No register of erasures and revocations is in {own.parent}. Whoever was erased and whatever was revoked"
            f" after {manifest.created_at} is back: restore with --register and the ended.jsonl of the old data folder,"
            " or a newer backup, or erase and revoke again by hand."
        )


def _register_in(path: Path) -> list[Ended]:
    """Read a register, or that of a backup; one from before there were registers has none."""
    if not path.exists():
        raise InvalidInput(f"{path} does not exist; name a register (ended.jsonl) or a backup")
    if not zipfile.is_zipfile(path):
        return ended.read(path)
    return ended.parse(archives.rows_of(path, ended.ENTRY)) if _has_register(path) else []


def _has_register(path: Path) -> bool:
    return ended.ENTRY in archives.verify(path).rows


def audit_verify(archive: Path | None) -> None:
    """Check the audit chain of every clinic and print how far it is whole.

    Parameters
    ----------
    archive : Path or None
        A backup: each chain must still contain the last event that it had then, so a cut end is found too.

    Raises
    ------
    typer.Exit
        With code 1 when a chain is broken.
    """
    heads = archives.verify(archive).audit_heads if archive is not None else {}
    engine = engines.create(Settings())
    try:
        with read_only(engine) as session:
            known = set(session.scalars(select(Clinic.id)))
            reports = {
                clinic_id: audit.verify(session, clinic_id, heads.get(clinic_id))
                for clinic_id in sorted(known | set(heads))
            }
    finally:
        engine.dispose()
    for clinic_id, report in reports.items():
        if report.is_intact:
            typer.echo(f"clinic {clinic_id}: {report.events} events, intact, head {report.head}")
        else:
            typer.echo(f"clinic {clinic_id}: broken at event {report.broken_at}: {report.reason}")
    if not all(report.is_intact for report in reports.values()):
        raise typer.Exit(1)


def create_clinic(name: str, email: str, person: str, password: str) -> None:
    """Create a clinic and its first administrator in the database of the settings.

    Parameters
    ----------
    name : str
        Of the clinic.
    email, person, password : str
        Of the administrator.

    Raises
    ------
    InvalidInput
        The password is too easy to guess or the address is none.
    Conflict
        The address is taken.
    """
    check_password(password, email, person)
    address = normalise_email(email)
    if address.count("@") != 1 or address.startswith("@") or address.endswith("@"):
        raise InvalidInput("the e-mail address needs a name, an @ and a host")
    settings = Settings()
    _bring_up(settings, "telemotion create-clinic")
    engine = engines.create(settings)
    try:
        with unit_of_work(engine) as session:
            if session.scalar(select(Account.id).where(Account.email == address)) is not None:
                raise Conflict("there is an account with this e-mail address already")
            clinic = Clinic(id=new_id(), name=name)
            session.add(clinic)
            session.flush()
            session.add(
                Account(
                    id=new_id(),
                    clinic_id=clinic.id,
                    role="administrator",
                    email=address,
                    display_name=person,
                    password_hash=Passwords().hash(password),
                )
            )
            session.flush()
            audit.record(session, Subject.system(clinic.id), "clinic.create", None, clinic.id, {})
    finally:
        engine.dispose()
    typer.echo(f"{name} is ready; {address} can sign in")


def reprocess(session_id: str, orientation: str, parameters: str) -> None:
    """Estimate one stored session, or all, again in this process.

    Raises
    ------
    InvalidInput
        The parameters are no JSON object.
    NotFound
        No such session.
    """
    try:
        values = json.loads(parameters)
    except ValueError as error:
        raise InvalidInput("--parameters must be a JSON object, for instance '{}'") from error
    wanted = ReprocessIn(orientation=orientation, orientation_parameters=values)
    settings = Settings()
    engine = engines.create(settings)
    try:
        with read_only(engine) as session:
            query = select(MotionSession.id, MotionSession.clinic_id)
            if session_id != "all":
                query = query.where(MotionSession.id == session_id)
            else:
                query = query.where(MotionSession.state == "analysed")
            found = session.execute(query.order_by(MotionSession.created_at)).all()
        if not found:
            raise NotFound("There is no such session.")
        for identifier, clinic_id in found:
            try:
                with unit_of_work(engine) as session:
                    job = service.queue_reprocess(session, Subject.system(clinic_id), identifier, wanted)
            except TelemotionError as error:
                if session_id != "all":
                    raise
                typer.echo(f"{identifier}: left out, {error.message}")
                continue
            done = run_job(engine, settings, job.id, reprocess_task)
            said = f"{done.status} {done.message}" if done else "taken by the running service"
            typer.echo(f"{identifier}: {said}")
    finally:
        engine.dispose()
