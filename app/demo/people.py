"""Who works and who is treated in the demonstration clinic. All invented; the password is known to everybody."""

from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from typing import Final

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.credentials.passwords import Passwords
from app.accounts.models import Account, Clinic, Consent
from app.accounts.subject import Subject
from app.database import migrate
from app.database.base import new_id
from app.database.engine import create_from_url
from app.database.unit_of_work import read_only, unit_of_work
from app.edge.demonstration import HistoryProgress, complete, new_progress
from app.exercises.models import Exercise, Posture
from app.patients.models import Grant, Patient
from estimators.conventions import Side
from estimators.gait import GuidedKind
from estimators.simulation import ExerciseName

PASSWORD: Final = "telemotion-demo"  # noqa: S105 - printed at the start of the demonstration
CLINIC: Final = "Harbour Rehabilitation (demonstration)"
THERAPIST: Final = "therapist@demo.example"
ADMINISTRATOR: Final = "admin@demo.example"


@dataclass(frozen=True)
class DemoPatient:
    """One invented patient and what the demonstration does with them."""

    email: str
    given_name: str
    family_name: str
    birth_date: date
    affected_side: Side
    stature_m: float
    notes: str
    movement: ExerciseName


PATIENTS: Final = (
    DemoPatient(
        email="amara@demo.example",
        given_name="Amara",
        family_name="Okafor",
        birth_date=date(1957, 3, 14),
        affected_side="right",
        stature_m=1.66,
        notes="Ischaemic stroke, left MCA, nine weeks ago. Reaching at table height, no shoulder pain.",
        movement="reaching",
    ),
    DemoPatient(
        email="tomasz@demo.example",
        given_name="Tomasz",
        family_name="Lindqvist",
        birth_date=date(1949, 11, 2),
        affected_side="left",
        stature_m=1.79,
        notes="Stroke four months ago. Stops abduction when the shoulder hikes.",
        movement="abduction",
    ),
)


@dataclass(frozen=True)
class DemoExercise:
    """An exercise of the demonstration clinic."""

    name: str
    movement: ExerciseName
    side: Side
    primary_angle: str
    description: str
    posture: Posture = "standing"


@dataclass(frozen=True)
class DemoWalk:
    """A walking test of the demonstration clinic."""

    name: str
    kind: GuidedKind
    description: str


WALKS: Final = (
    DemoWalk(
        "Walk on level ground", "walk", "Stand still for three seconds, walk to the end, stand still again."
    ),
    DemoWalk("Timed up and go", "timed_up_and_go", "Get up, walk three metres, turn, come back, sit down."),
    DemoWalk(
        "Six-minute walk", "six_minute_walk", "Walk as far as possible in six minutes; rest when needed."
    ),
)


EXERCISES: Final = (
    DemoExercise(
        "Reach forward to the table",
        "reaching",
        "right",
        "humerus_forearm_right_zxy_flexion",
        "Sit upright, hand in the lap. Reach forward until the elbow is almost straight, pause, come back.",
        "seated",
    ),
    DemoExercise(
        "Raise the arm to the side",
        "abduction",
        "left",
        "thorax_humerus_left_yxy_elevation",
        "Stand upright. Lift the straight arm sideways to shoulder height without leaning, lower it slowly.",
    ),
    DemoExercise(
        "Drink from a cup",
        "drinking",
        "right",
        "humerus_forearm_right_zxy_flexion",
        "Sit at the table. Reach for the cup, bring it to the mouth, put it back.",
        "seated",
    ),
    DemoExercise(
        "Raise the arm to the front",
        "flexion",
        "right",
        "thorax_humerus_right_yxy_elevation",
        "Stand upright. Lift the straight arm forward to shoulder height, lower it slowly.",
    ),
    DemoExercise(
        "Turn the forearm",
        "pronation",
        "right",
        "humerus_forearm_right_zxy_pronation",
        "Sit upright, elbow at the body, bent to a right angle. Turn the palm up and down.",
        "seated",
    ),
)


def prepare(url: str, folder: Path) -> HistoryProgress:
    """Bring a database to the newest schema, with the demonstration's people, and return how far its history is.

    Parameters
    ----------
    url : str
        Of the database.
    folder : Path
        Data directory of the service, where the progress is noted.
    """
    migrate.upgrade(url)
    engine = create_from_url(url)
    try:
        if not _is_seeded(engine):
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            new_progress(folder).save()
            seed_people(engine)
    finally:
        engine.dispose()
    # Where there are people and no progress was noted, an earlier version made them: what was recorded since stays.
    return HistoryProgress.of(folder) or complete(folder)


def _is_seeded(engine: Engine) -> bool:
    with read_only(engine) as session:
        return session.scalar(select(Clinic.id).where(Clinic.name == CLINIC)) is not None


def seed_people(engine: Engine) -> None:
    """Create the clinic, its people and its exercises, in one transaction.

    Parameters
    ----------
    engine : Engine
        Migrated, without the clinic.
    """
    password_hash = Passwords().hash(PASSWORD)
    with unit_of_work(engine) as session:
        clinic = Clinic(id=new_id(), name=CLINIC)
        session.add(clinic)
        session.flush()
        therapist = _account(session, clinic, "therapist", THERAPIST, "Ingrid Solberg", password_hash)
        _account(session, clinic, "administrator", ADMINISTRATOR, "Noor Haddad", password_hash)
        acting = Subject("account", therapist.id, therapist.id, clinic.id, "therapist", None)
        for person in PATIENTS:
            _patient(session, clinic, therapist, acting, person, password_hash)
        for exercise in EXERCISES:
            session.add(
                Exercise(
                    id=new_id(),
                    clinic_id=clinic.id,
                    name=exercise.name,
                    description=exercise.description,
                    movement=exercise.movement,
                    side=exercise.side,
                    primary_angle=exercise.primary_angle,
                    posture=exercise.posture,
                )
            )
        for walk in WALKS:
            session.add(
                Exercise(
                    id=new_id(),
                    clinic_id=clinic.id,
                    name=walk.name,
                    description=walk.description,
                    movement=walk.kind,
                    primary_angle="",
                )
            )


def _account(
    session: Session,
    clinic: Clinic,
    role: str,
    email: str,
    name: str,
    password_hash: str,
    patient_id: str | None = None,
) -> Account:
    row = Account(
        id=new_id(),
        clinic_id=clinic.id,
        role=role,
        email=email,
        display_name=name,
        password_hash=password_hash,
        patient_id=patient_id,
    )
    session.add(row)
    session.flush()
    return row


def _patient(
    session: Session,
    clinic: Clinic,
    therapist: Account,
    acting: Subject,
    person: DemoPatient,
    password_hash: str,
) -> None:
    patient = Patient(
        id=new_id(),
        clinic_id=clinic.id,
        given_name=person.given_name,
        family_name=person.family_name,
        birth_date=person.birth_date,
        affected_side=person.affected_side,
        notes=person.notes,
        body_dimensions={"stature_m": person.stature_m},
        created_at=datetime.now(UTC) - timedelta(days=40),
    )
    session.add(patient)
    session.flush()
    account = _account(
        session,
        clinic,
        "patient",
        person.email,
        f"{person.given_name} {person.family_name}",
        password_hash,
        patient.id,
    )
    session.add(Grant(id=new_id(), patient_id=patient.id, account_id=therapist.id, granted_by=therapist.id))
    for purpose in ("treatment", "home_streaming"):
        session.add(
            Consent(id=new_id(), patient_id=patient.id, purpose=purpose, granted=True, changed_by=account.id)
        )
    session.flush()
    audit.record(session, acting, "patient.create", patient.id, patient.id, {})
