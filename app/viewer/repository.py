"""The data of a view in the database, and who may have it."""

from dataclasses import dataclass
from typing import Literal

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment.design.prescribed import exercise_side, prescribed_version
from app.assessment.models import Comparison
from app.database.unit_of_work import read_only
from app.errors import Conflict, InvalidInput, NotFound
from app.exercises.models import Exercise, Posture, Template, TemplateVersion
from app.patients.access import require_patient
from app.patients.models import Patient
from app.recordings import marker_motion
from app.recordings import repository as recordings
from app.recordings.analysis.kinds import View, kind_of
from app.recordings.models import MotionSession, Result
from app.recordings.schemas import ViewIn, ViewLanguage
from app.recordings.signals.store import read_frames
from app.viewer.figure.ghost import Ghost, GhostClock, ghost_from_template
from app.viewer.fluent import fluent
from app.viewer.layers.markers import markers_of
from app.viewer.pose import (
    SEGMENTS,
    PoseTrack,
    measured_segments,
    thinned,
    track_from_frames,
    track_from_markers,
)
from estimators.body import BodyDimensions
from estimators.comparison import (
    RepetitionResult,
    comparison_from_bytes,
    is_of_stride,
    template_from_bytes,
)
from estimators.conventions import Side
from estimators.pipelines import SessionSetup
from estimators.sentences import say

Mode = Literal["live", "replay"]
NO_SUCH_TEMPLATE = say("template.not_found")
_ENDED = ("analysed", "failed")


@dataclass(frozen=True)
class ViewTarget:
    """What a view shows, by identifiers; small enough to be held for hours."""

    mode: Mode
    session_id: str
    patient_id: str
    result_id: str | None
    template_version_id: str | None
    markers_id: str | None = None
    language: ViewLanguage = "en"


@dataclass(frozen=True)
class Contents:
    """What stands in the scene of a view.

    Attributes
    ----------
    track : PoseTrack or None
        The stored movement; None in live views.
    is_calibrating : bool
        Whether the session waits for the calibration pose.
    side : {"left", "right"}
        The arm that the exercise is about.
    """

    body: BodyDimensions
    measured: frozenset[str]
    affected_side: str | None
    side: Side
    ghost: Ghost | None
    ghost_clock: GhostClock | None
    track: PoseTrack | None
    is_calibrating: bool = False
    view: View = "body"
    """Modules want a nearer camera, feet a lower one."""
    posture: Posture = "standing"
    """Of the exercise."""
    movement: str = ""
    """Kind of the exercise; empty without one."""


def find_target(engine: Engine, subject: Subject, session_id: str, wanted: ViewIn) -> ViewTarget:
    """Check the right to a view and fix what it shows; leaves an audit event.

    Parameters
    ----------
    wanted : ViewIn
        Without a template, the prescribed one's newest version is taken.

    Raises
    ------
    NotFound, NotAllowed
        No such session, result or template for this subject.
    Conflict
        A live view of a session that has ended.
    """
    with read_only(engine) as session:
        found = recordings.get_session(
            session, subject, session_id, action="session.view", details={"mode": wanted.mode}
        )
        if wanted.markers_id is not None:
            if wanted.mode == "live":
                raise InvalidInput(say("viewer.markers_live"), field="markers_id")
            marker_motion.require(session, found.id, wanted.markers_id)
            return ViewTarget(
                wanted.mode, found.id, found.patient_id, None, None, wanted.markers_id, wanted.language
            )
        result_id = None
        if wanted.mode == "replay":
            result_id = recordings.result_of(session, found, wanted.result_id).id
        elif found.state in _ENDED:
            raise Conflict(say("viewer.session_ended"), state=found.state)
        version_id = wanted.template_version_id
        if version_id is not None:
            _template_version(session, subject, version_id)
        else:
            version_id = prescribed_version(session, found)
        return ViewTarget(
            wanted.mode, found.id, found.patient_id, result_id, version_id, language=wanted.language
        )


def check_right(engine: Engine, subject: Subject, target: ViewTarget) -> None:
    """Check an open view again; no audit event, the opening left one.

    Raises
    ------
    NotFound, NotAllowed
        The right to the patient has been lost, or the session erased.
    """
    with read_only(engine) as session:
        require_patient(session, subject, target.patient_id, "read")
        if session.get(MotionSession, target.session_id) is None:
            raise NotFound(recordings.NO_SUCH_SESSION)


def load_contents(engine: Engine, target: ViewTarget) -> Contents:
    """Read what a view shows; access was decided by `find_target`.

    Raises
    ------
    NotFound
        It has been deleted since.
    InvalidInput
        The result holds no frames.
    """
    with read_only(engine) as session:
        found = session.get(MotionSession, target.session_id)
        patient = session.get(Patient, target.patient_id)
        if found is None or patient is None:
            raise NotFound(recordings.NO_SUCH_SESSION)
        setup = SessionSetup.from_dict(found.setup)
        measured: frozenset[str] = frozenset(SEGMENTS).intersection(setup.placements)
        exercise = session.get(Exercise, found.exercise_id) if found.exercise_id else None
        view = kind_of(setup).view
        posture: Posture = "standing"
        if exercise is not None and view == "body" and target.markers_id is None:
            posture = exercise.posture
        track = None
        if target.markers_id is not None:
            motion = marker_motion.read_motion(session, found.id, target.markers_id)
            track = track_from_markers(*markers_of(motion))
        elif target.result_id is not None:
            result = session.get(Result, target.result_id)
            if result is None:
                raise NotFound(say("result.not_found"))
            setup = SessionSetup.from_dict(result.setup)
            frames = read_frames(session, target.result_id)
            if frames.tick_count == 0:
                raise InvalidInput(say("result.no_movement"))
            measured = measured_segments(frames)
            track = track_from_frames(fluent(thinned(frames)), setup.body, posture)
        side = exercise_side(session, found, measured)
        ghost, clock = _ghost(session, target, found, setup.body, side, posture)
        return Contents(
            body=setup.body,
            measured=measured,
            affected_side=patient.affected_side,
            side=ghost.side if ghost is not None else side,
            ghost=ghost,
            ghost_clock=clock,
            track=track,
            is_calibrating=found.state in {"created", "calibrating"},
            view=view,
            posture=posture,
            movement=exercise.movement if exercise is not None else "",
        )


def _template_version(session: Session, subject: Subject, version_id: str) -> TemplateVersion:
    row = session.execute(
        select(TemplateVersion, Template)
        .join(Template, Template.id == TemplateVersion.template_id)
        .where(TemplateVersion.id == version_id, Template.clinic_id == subject.clinic_id)
    ).first()
    if row is None:
        raise NotFound(NO_SUCH_TEMPLATE)
    version, template = row
    if template.patient_id is not None:
        try:
            require_patient(session, subject, template.patient_id, "read")
        except NotFound:
            raise NotFound(NO_SUCH_TEMPLATE) from None
    return version


def _ghost(
    session: Session,
    target: ViewTarget,
    found: MotionSession,
    body: BodyDimensions,
    side: Side,
    posture: Posture,
) -> tuple[Ghost | None, GhostClock | None]:
    if target.template_version_id is None:
        return None, None
    version = session.get(TemplateVersion, target.template_version_id)
    if version is None:
        return None, None
    template = template_from_bytes(version.content)
    if is_of_stride(template.primary_channel):
        # A foot that walks has no figure to be a ghost of.
        return None, None
    results: tuple[RepetitionResult, ...] = ()
    if target.mode == "replay":
        stored = session.scalars(
            select(Comparison)
            .where(
                Comparison.session_id == found.id,
                Comparison.template_version_id == version.id,
                Comparison.result_id == target.result_id,
            )
            .order_by(Comparison.created_at.desc())
        ).first()
        if stored is not None:
            comparison = comparison_from_bytes(stored.content)
            results = comparison.repetitions
            if comparison.channels:
                side = "left" if any("_left" in name for name in comparison.channels) else "right"
    ghost = ghost_from_template(template, body, side, posture)
    return ghost, GhostClock.of(ghost.duration_s, results, found.recording_start_s or 0.0)
