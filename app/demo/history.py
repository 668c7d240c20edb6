"""Past sessions of the demonstration: each streamed through the whole service, only faster, then dated back."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import timedelta
from pathlib import Path
from typing import Any, Final

from sqlalchemy import Engine, update

from app.commands.simulate import Options, scenario_of, stream
from app.commands.upload import finished, send
from app.database.base import utc_now
from app.database.unit_of_work import unit_of_work
from app.demo.dating import date_back
from app.demo.markers import send_markers, until_fused
from app.demo.people import EXERCISES, PATIENTS, DemoPatient
from app.demo.sources import make_source_session
from app.demo.walks import make_walks
from app.errors import TelemotionError
from app.exercises.models import Prescription, Template, TemplateVersion
from app.gateway import ServiceClient
from app.recordings.schemas import UploadIn
from estimators.conventions import Placement

REAL_RECORDING: Final = Path(__file__).with_name("data") / "whole_body_excerpt.mat"
"""Forty seconds of a real person with sixteen sensors; origin and licence lie beside it."""
REAL_POSE_S: Final = (0.5, 3.5)
REPETITIONS: Final = 6


@dataclass(frozen=True)
class PastSession:
    """When a session was, and how far the therapy had come."""

    days_ago: float
    progress: float
    patient_kind: str
    loss_percent: float = 0.0
    has_cameras: bool = False
    """A camera system saw a marker on the hand."""


PAST: Final = {
    "amara@demo.example": (
        PastSession(24.2, 0.0, "moderate_stroke"),
        PastSession(20.1, 0.2, "moderate_stroke", loss_percent=3.0),
        PastSession(15.0, 0.45, "moderate_stroke"),
        PastSession(9.3, 0.7, "moderate_stroke"),
        PastSession(4.1, 0.85, "moderate_stroke", loss_percent=2.0),
        PastSession(1.2, 1.0, "moderate_stroke", has_cameras=True),
    ),
    "tomasz@demo.example": (
        PastSession(16.3, 0.5, "mild_stroke"),
        PastSession(11.1, 0.3, "mild_stroke"),
        PastSession(8.0, 0.1, "moderate_stroke"),
    ),
}
TEMPLATE_DAYS_AGO: Final = {"amara@demo.example": 26.0, "tomasz@demo.example": 18.0}


async def make_history(
    service: ServiceClient, engine: Engine, patient_ids: dict[str, str], say: Callable[[str], None]
) -> None:
    """Record the templates, prescribe, and stream the past sessions.

    Parameters
    ----------
    service : ServiceClient
        Signed in as the demonstration's therapist.
    engine : Engine
        The same database, to date the sessions back.
    patient_ids : dict of str to str
        Identifier of each demonstration patient by e-mail.
    say : callable(text)
        Told about progress.
    """
    exercise_ids = {item["movement"]: item["id"] for item in await _get(service, "/api/exercises")}
    total = sum(len(sessions) + 1 for sessions in PAST.values()) + 2
    done, seen = 0, []
    for person in PATIENTS:
        patient_id = patient_ids[person.email]
        exercise_id = exercise_ids[person.movement]
        prescription_id = await record_template(service, engine, person, patient_id, exercise_id)
        done += 1
        say(f"preparing past sessions: {done} of {total}")
        for number, past in enumerate(PAST[person.email]):
            options = replace(
                _options(person, patient_id, exercise_id, seed=100 + number),
                prescription_id=prescription_id,
                patient_kind=past.patient_kind,
                progress=past.progress,
                loss_percent=past.loss_percent,
            )
            session_id, _ = await stream(service, options, _silent)
            if past.has_cameras:
                segment: Placement = "hand_left" if person.affected_side == "left" else "hand_right"
                await send_markers(service, session_id, scenario_of(options), segment)
                seen.append(session_id)
            date_back(engine, session_id, past.days_ago)
            done += 1
            say(f"preparing past sessions: {done} of {total}")
    declaration = UploadIn(
        patient_id=patient_ids[PATIENTS[1].email], format="qmt_mat", calibration_pose_s=REAL_POSE_S
    )
    job = await send(service, REAL_RECORDING, declaration)
    await finished(service, job.session_id)
    date_back(engine, job.session_id, 3.0)
    say(f"preparing past sessions: {done + 1} of {total}")
    await make_walks(service, engine, patient_ids[PATIENTS[1].email], exercise_ids["walk"])
    await make_source_session(service, engine, patient_ids[PATIENTS[1].email])
    for session_id in seen:
        try:
            await until_fused(service, session_id)
        except TelemotionError as error:
            say(f"the markers of one session were not fused: {error}")
    say(f"preparing past sessions: {total} of {total}")


async def record_template(
    service: ServiceClient, engine: Engine, person: DemoPatient, patient_id: str, exercise_id: str
) -> str:
    """Record and publish the therapist's template and prescribe it; returns the prescription.

    Parameters
    ----------
    service : ServiceClient
        Signed in as the therapist.
    engine : Engine
        To date it back.
    person : DemoPatient
    patient_id, exercise_id : str
    """
    options = replace(
        _options(person, patient_id, exercise_id, seed=7),
        patient_kind="therapist_template",
        purpose="template",
    )
    session_id, _ = await stream(service, options, _silent)
    exercise = next(item for item in EXERCISES if item.movement == person.movement)
    created = await _post(
        service,
        "/api/templates",
        {
            "session_id": session_id,
            "exercise_id": exercise_id,
            "patient_id": patient_id,
            "name": f"{exercise.name}, recorded with Ingrid Solberg",
        },
    )
    prescription = await _post(
        service,
        f"/api/patients/{patient_id}/prescriptions",
        {
            "exercise_id": exercise_id,
            "template_id": created["template_id"],
            "repetitions": REPETITIONS,
            "times_per_week": 3,
        },
    )
    days_ago = TEMPLATE_DAYS_AGO[person.email]
    date_back(engine, session_id, days_ago)
    moment = utc_now() - timedelta(days=days_ago - 0.02)
    with unit_of_work(engine) as session:
        session.execute(
            update(TemplateVersion).where(TemplateVersion.id == created["id"]).values(created_at=moment)
        )
        session.execute(
            update(Template).where(Template.id == created["template_id"]).values(created_at=moment)
        )
        session.execute(
            update(Prescription)
            .where(Prescription.id == prescription["id"])
            .values(created_at=moment, starts_at=moment)
        )
    return str(prescription["id"])


def _options(person: DemoPatient, patient_id: str, exercise_id: str, seed: int) -> Options:
    return Options(
        server="",
        email="",
        password="",
        patient_id=patient_id,
        exercise_id=exercise_id,
        movement=person.movement,
        arms=person.affected_side,
        repetitions=REPETITIONS,
        speed=None,
        seed=seed,
    )


async def _get(service: ServiceClient, path: str) -> Any:
    response = await service.http.get(path)
    response.raise_for_status()
    return response.json()


async def _post(service: ServiceClient, path: str, body: dict[str, Any]) -> Any:
    response = await service.http.post(path, json=body)
    if not response.is_success:
        raise TelemotionError(f"{path} answered {response.status_code}: {response.text[:300]}")
    return response.json()


def _silent(text: str) -> None:
    """Say nothing: the history tells its own progress."""
