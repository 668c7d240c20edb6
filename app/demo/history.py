"""Past sessions of the demonstration: each streamed through the whole service, only faster, then dated back."""

import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from datetime import timedelta
from functools import partial
from pathlib import Path
from typing import Any, Final

from sqlalchemy import Engine, delete, update

from app.commands.simulation.arm import Options, scenario_of, stream
from app.commands.upload import finished, send
from app.database.base import utc_now
from app.database.unit_of_work import unit_of_work
from app.demo.dating import date_back
from app.demo.markers import send_markers, until_fused
from app.demo.people import EXERCISES, PATIENTS, DemoPatient
from app.demo.sources import make_source_session
from app.demo.walks import PAST_WALKS, PastWalk, make_walk
from app.edge.demonstration import HistoryProgress
from app.errors import TelemotionError
from app.exercises.models import Prescription, Template, TemplateVersion
from app.gateway import ServiceClient
from app.live.session.states import STREAMING
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
    service: ServiceClient,
    engine: Engine,
    patient_ids: dict[str, str],
    progress: HistoryProgress,
    say: Callable[[str], None],
) -> None:
    """Record the templates, prescribe, and stream the past sessions; what is there already is not made again.

    Parameters
    ----------
    service : ServiceClient
        Signed in as the demonstration's therapist.
    engine : Engine
        The same database, to date the sessions back.
    patient_ids : dict of str to str
        Identifier of each demonstration patient by e-mail.
    say : callable(text)
        Called when all is there.
    """
    if progress.is_complete:
        return
    await _forget_half_made(service, engine, patient_ids, progress)
    for step, make in History(service, engine, patient_ids, progress).steps():
        if step not in progress.done:
            result, session_id = await make()
            progress.add(step, result, session_id)
    say("past sessions complete")


Made = tuple[str, str]
"""What later steps need, and the session that was made."""


@dataclass(frozen=True)
class History:
    """The steps of which the history consists; each is one session."""

    service: ServiceClient
    engine: Engine
    patient_ids: dict[str, str]
    progress: HistoryProgress

    def steps(self) -> list[tuple[str, Callable[[], Awaitable[Made]]]]:
        """Return them by name, in their order."""
        made: list[tuple[str, Callable[[], Awaitable[Made]]]] = []
        for person in PATIENTS:
            made.append((f"{person.email} template", partial(self._template, person)))
            made += [
                (f"{person.email} {number}", partial(self._session, person, number, past))
                for number, past in enumerate(PAST[person.email])
            ]
        made.append(("recording", self._recording))
        made += [(f"walk {number}", partial(self._walk, walk)) for number, walk in enumerate(PAST_WALKS)]
        return [*made, ("source", self._source)]

    async def _exercise(self, movement: str) -> str:
        return next(
            str(item["id"])
            for item in await _get(self.service, "/api/exercises")
            if item["movement"] == movement
        )

    async def _template(self, person: DemoPatient) -> Made:
        return await record_template(
            self.service,
            self.engine,
            person,
            self.patient_ids[person.email],
            await self._exercise(person.movement),
        )

    async def _session(self, person: DemoPatient, number: int, past: PastSession) -> Made:
        exercise_id = await self._exercise(person.movement)
        options = replace(
            _options(person, self.patient_ids[person.email], exercise_id, seed=100 + number),
            prescription_id=self.progress.done[f"{person.email} template"],
            patient_kind=past.patient_kind,
            progress=past.progress,
            loss_percent=past.loss_percent,
        )
        session_id, _ = await stream(self.service, options, _silent)
        if past.has_cameras:
            segment: Placement = "hand_left" if person.affected_side == "left" else "hand_right"
            await send_markers(self.service, session_id, scenario_of(options), segment)
            await until_fused(self.service, session_id)
        date_back(self.engine, session_id, past.days_ago)
        return "", session_id

    async def _recording(self) -> Made:
        declaration = UploadIn(patient_id=self._walker, format="qmt_mat", calibration_pose_s=REAL_POSE_S)
        job = await send(self.service, REAL_RECORDING, declaration)
        await finished(self.service, job.session_id)
        date_back(self.engine, job.session_id, 3.0)
        return "", job.session_id

    async def _walk(self, walk: PastWalk) -> Made:
        exercise_id = await self._exercise("walk")
        return "", await make_walk(self.service, self.engine, self._walker, exercise_id, walk)

    async def _source(self) -> Made:
        return "", await make_source_session(self.service, self.engine, self._walker)

    @property
    def _walker(self) -> str:
        return self.patient_ids[PATIENTS[1].email]


async def _forget_half_made(
    service: ServiceClient, engine: Engine, patient_ids: dict[str, str], progress: HistoryProgress
) -> None:
    """Erase what an interrupted start left half made: its sessions, and a template whose step did not end."""
    for email, patient_id in patient_ids.items():
        if f"{email} template" not in progress.done:
            with unit_of_work(engine) as session:
                session.execute(delete(Prescription).where(Prescription.patient_id == patient_id))
                session.execute(delete(Template).where(Template.patient_id == patient_id))
        for row in await service.every(f"/api/patients/{patient_id}/sessions"):
            # What is created or streams is the live patient's of now.
            if row["id"] not in progress.kept_sessions and row["state"] not in ("created", *STREAMING):
                if row["state"] == "closing":
                    # Its analysis goes on where it was interrupted; under its feet nothing is erased.
                    with contextlib.suppress(TelemotionError):
                        await finished(service, row["id"])
                await service.http.delete(f"/api/sessions/{row['id']}")


async def record_template(
    service: ServiceClient, engine: Engine, person: DemoPatient, patient_id: str, exercise_id: str
) -> tuple[str, str]:
    """Record and publish the therapist's template and prescribe it; returns the prescription and the session.

    Parameters
    ----------
    service : ServiceClient
        Signed in as the therapist.
    engine : Engine
        To date it back.
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
    return str(prescription["id"]), session_id


def _options(person: DemoPatient, patient_id: str, exercise_id: str, seed: int) -> Options:
    return Options(
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
