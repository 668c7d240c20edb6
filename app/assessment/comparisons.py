"""Comparing a session with a template: on demand, and by the task that follows a closed session."""

import logging
from dataclasses import dataclass

from sqlalchemy import Engine
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment import repository
from app.assessment.course.bands import beside_other_side
from app.assessment.design.compiled import (
    design_of,
    effective_template,
    mirrored_weights,
    tolerance_scale_of,
)
from app.assessment.design.counted import counted_live
from app.assessment.design.weighted import weighted_sum
from app.assessment.models import ALL_REPETITIONS, Comparison, RepetitionMeasure
from app.assessment.practised import Practised, practised_or_why
from app.assessment.presentation import (
    phase_curves_out,
    phases_out,
    repetition_comparison,
    summary_out,
)
from app.assessment.schemas import ComparisonDetail, ComparisonIn, ComparisonOut, MeasureValue
from app.assessment.sources import load_source
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput, NotFound
from app.exercises.models import Exercise, TemplateVersion
from app.exercises.models import Template as TemplateRow
from app.pages import Page
from app.patients.models import Patient
from app.recordings import repository as recordings
from app.recordings.analysis.jobs import JobContext
from app.recordings.models import MotionSession, SessionEvent
from estimators.comparison import (
    TOGETHER,
    ComparisonResult,
    Template,
    compare,
    comparison_from_bytes,
    comparison_to_bytes,
    is_of_stride,
    mirror_template,
)
from estimators.errors import ComparisonError, EstimationError
from estimators.sentences import say

logger = logging.getLogger(__name__)

VERSION = "7"
"""Of the comparison method; stored with each comparison, changes whenever the numbers change."""


@dataclass(frozen=True)
class _Work:
    """A computed comparison, not yet stored."""

    result_id: str
    version_id: str
    template: Template
    template_name: str
    result: ComparisonResult


def compare_session(engine: Engine, subject: Subject, session_id: str, wanted: ComparisonIn) -> ComparisonOut:
    """Compare a stored session with a template version and keep the comparison.

    Reading and computing happen outside the writing transaction, which is short.

    Raises
    ------
    NotFound, NotAllowed
        The session or template is not the subject's to compare.
    InvalidInput
        They cannot be compared; the message says why.
    """
    with read_only(engine) as session:
        found = recordings.get_session(session, subject, session_id, "treat", action="")
        template, version = repository.get_version(
            session, subject, wanted.template_version_id, audited=False
        )
        if template.patient_id not in {None, found.patient_id}:
            raise InvalidInput(say("template.other_patient"), field="template_version_id")
        work = _compute(session, found, template, version, wanted.result_id)
    with unit_of_work(engine) as session:
        found = recordings.get_session(session, subject, session_id, "treat", action="")
        return _out(_store(session, subject, found, work), work.template_name)


def compare_task(context: JobContext) -> str:
    """Task `compare`: compare with what was prescribed; on closing, the session is then analysed.

    Arguments: `close`; `template_version_id` and `result_id` to name them.
    """
    close = bool(context.arguments.get("close"))
    work: _Work | None = None
    message = refused = ""
    with read_only(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        of_whom = _of_whom(found)
        named = context.arguments.get("template_version_id")
        version = (
            session.get(TemplateVersion, named)
            if named
            else repository.prescribed_version(session, found)
            if found.purpose == "exercise"
            else None
        )
        if version is None:
            message = say("comparison.no_template")
        else:
            context.progress(0.1, say("progress.comparing"))
            template = session.get_one(TemplateRow, version.template_id)
            try:
                work = _compute(session, found, template, version, context.arguments.get("result_id"))
            except (InvalidInput, NotFound, ComparisonError) as error:
                # A session that cannot be compared is still analysed: the movement can be seen.
                if not close:
                    raise
                message, refused = say("comparison.not_compared", reason=error.message), error.message
        is_practice = close and found.purpose == "exercise"
        counts, reason = _counted(session, found, work, refused) if is_practice else (None, "")
    with unit_of_work(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        if _of_whom(found) != of_whom:
            # It was moved meanwhile; whoever did that has queued another comparison.
            return say("comparison.no_template")
        if counts is not None:
            found.valid_repetitions, found.active_s = counts
            if reason:
                _say_not_practised(session, found, reason)
        if work is not None:
            _store(session, context.subject, found, work)
            accepted = sum(1 for r in work.result.repetitions if r.repetition.is_kept)
            message = say("comparison.done", kept=accepted, all=len(work.result.repetitions))
        if close and found.state == "closing":
            _conclude(session, found, message if work is None and version is not None else "")
    return message


def _of_whom(found: MotionSession) -> tuple[str | None, ...]:
    """Return what a comparison depends on and somebody may put right meanwhile."""
    return found.patient_id, found.exercise_id, found.prescription_id


def _counted(
    session: Session, found: MotionSession, work: _Work | None, refused: str
) -> tuple[Practised | None, str]:
    """Measure what was valid; None where the session is too long to be looked at whole.

    It is analysed nevertheless, and counts as one that recorded something: counting is no reason to fail.
    """
    repetitions = None if work is None else [one.repetition for one in work.result.repetitions]
    try:
        return practised_or_why(session, found, repetitions, refused)
    except MemoryError:
        logger.warning("session %s is too long to count what was practised", found.id)
        return None, ""


def _say_not_practised(session: Session, found: MotionSession, reason: str) -> None:
    """Say on the time line why a session does not count."""
    text = say("comparison.not_practised", reason=reason)
    start_s = found.recording_start_s or 0.0
    session.add(SessionEvent(session_id=found.id, kind="not_practised", time_s=start_s, text=text))


def _conclude(session: Session, found: MotionSession, reason: str) -> None:
    """Let a closed session be analysed."""
    found.state = "analysed"
    found.state_reason = found.state_reason or reason
    found.ended_at = found.ended_at or utc_now()
    session.add(
        SessionEvent(session_id=found.id, kind="state", time_s=found.duration_s, text=say("session.analysed"))
    )


def _compute(
    session: Session,
    found: MotionSession,
    template_row: TemplateRow,
    version: TemplateVersion,
    result_id: str | None,
) -> _Work:
    result = recordings.result_of(session, found, result_id)
    scale = tolerance_scale_of(session, found, version.template_id)
    exercise = session.get(Exercise, found.exercise_id) if found.exercise_id else None
    patient = session.get_one(Patient, found.patient_id)
    source = load_source(session, found, result)
    template = effective_template(version, scale=scale)
    side = source.acting_side(
        template.side if exercise is None else exercise.side, patient.affected_side, template.side
    )
    if is_of_stride(template.primary_channel) is (source.cycles is None):
        raise InvalidInput(say("template.other_kind"), field="template_version_id")
    if side != template.side:
        template = mirror_template(template)
    prescribed = repository.prescribed_version(session, found)
    # What was counted by another template says nothing about this one.
    is_counted = prescribed is not None and prescribed.template_id == version.template_id
    try:
        compared = compare(
            source.moved,
            template,
            template.side,
            source.reach_m,
            source.start_s,
            source.end_s,
            None if source.cycles is None else source.judged(side),
            is_judged=source.cycles is not None,
            counted=counted_live(session, found) if is_counted else None,
        )
    except EstimationError as error:
        raise InvalidInput(error.message) from error
    return _Work(result.id, version.id, template, template_row.name, compared)


def _store(session: Session, subject: Subject, found: MotionSession, work: _Work) -> Comparison:
    summary = summary_out(work.result, work.template)
    rows = [
        RepetitionMeasure(
            repetition=one.repetition.number,
            measure=measure.measure,
            value=measure.value,
            uncertainty=measure.uncertainty,
            unit=measure.unit,
        )
        for one in work.result.repetitions
        if one.repetition.is_kept
        for measure in repetition_comparison(one, work.template).measures
        if measure.value is not None
    ]
    rows.extend(
        RepetitionMeasure(
            repetition=ALL_REPETITIONS,
            measure=measure.measure,
            value=measure.value,
            uncertainty=measure.uncertainty,
            unit=measure.unit,
        )
        for measure in summary
        if measure.value is not None and measure.measure.startswith(TOGETHER)
    )
    new = Comparison(
        session_id=found.id,
        result_id=work.result_id,
        template_version_id=work.version_id,
        version=VERSION,
        repetition_count=sum(1 for r in work.result.repetitions if r.repetition.is_kept),
        summary={"measures": [measure.model_dump() for measure in summary]},
        content=comparison_to_bytes(work.result),
    )
    return repository.add_comparison(session, subject, found, new, rows)


def list_of(session: Session, subject: Subject, session_id: str, page: Page) -> list[ComparisonOut]:
    """Return a page of a session's comparisons, newest first."""
    rows = repository.list_comparisons(session, subject, session_id, page)
    return [_out(found, name) for found, name in rows]


def detail(session: Session, subject: Subject, comparison_id: str) -> ComparisonDetail:
    """Return a comparison with every repetition and curve."""
    found, template_row, version = repository.get_comparison(session, subject, comparison_id)
    compared = comparison_from_bytes(found.content)
    session_row = session.get_one(MotionSession, found.session_id)
    template = effective_template(
        version, scale=tolerance_scale_of(session, session_row, version.template_id)
    )
    weights = design_of(version).weights
    if template.channels != compared.channels:
        template, weights = mirror_template(template), mirrored_weights(weights)
    out = _out(found, template_row.name)
    patient = session.get_one(Patient, session_row.patient_id)
    exercise = session.get(Exercise, session_row.exercise_id) if session_row.exercise_id else None
    repetitions = [repetition_comparison(one, template) for one in compared.repetitions]
    return ComparisonDetail(
        **out.model_dump(),
        repetitions=repetitions,
        curves=phase_curves_out(template, [one.aligned for one in compared.repetitions]),
        phases=phases_out(template),
        findings=list(compared.findings),
        other_side=beside_other_side(session, patient, exercise, out.summary),
        weighted_sum=weighted_sum(weights, template, repetitions),
    )


def _out(found: Comparison, template_name: str) -> ComparisonOut:
    return ComparisonOut(
        id=found.id,
        session_id=found.session_id,
        result_id=found.result_id,
        template_version_id=found.template_version_id,
        template_name=template_name,
        created_at=found.created_at,
        repetition_count=found.repetition_count,
        summary=[MeasureValue.model_validate(measure) for measure in found.summary["measures"]],
    )
