"""Templates from a recorded session: cut, judged, averaged; previewed first, then saved."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment import repository
from app.assessment.design.compiled import apply_design
from app.assessment.design.rules import side_of
from app.assessment.design.shown import version_detail
from app.assessment.design.weighted import offered_measures
from app.assessment.presentation import phase_curves_out, phases_out, repetition_out
from app.assessment.sources import load_source
from app.errors import InvalidInput
from app.exercises.design import PhaseDesign, TemplateDesign
from app.exercises.models import Exercise, TemplateVersion
from app.exercises.schemas import (
    TemplateContent,
    TemplateIn,
    TemplatePreviewIn,
    TemplateVersionDetail,
)
from app.patients.models import Patient
from app.recordings import repository as recordings
from app.recordings.compared import Source
from app.recordings.models import MotionSession, Result
from estimators.comparison import (
    Repetition,
    SideChannels,
    Template,
    build_template,
    near,
    phase_curves,
    side_channels,
    template_to_bytes,
)
from estimators.conventions import Side
from estimators.errors import EstimationError
from estimators.recording import Float
from estimators.sentences import for_json, say

FEWEST = 2
"""Strides of which a template is made."""
BY_HAND = say("template.by_hand")


@dataclass(frozen=True)
class Built:
    """A template with every repetition that was found, accepted or not.

    Attributes
    ----------
    template : Template
        With the phases and channels to watch that it begins with.
    curves : list of ndarray, shape (101, C)
    design : TemplateDesign
        What it begins with.
    sides : tuple of str
        To choose from, of a movement of both sides.
    """

    template: Template
    repetitions: list[Repetition]
    curves: list[Float]
    design: TemplateDesign = field(default_factory=TemplateDesign)
    sides: tuple[Side, ...] = ()


def build(
    source: Source,
    side: str,
    primary_channel: str,
    dropped: Sequence[int] | None,
    tolerance_scale: Mapping[str, float],
) -> Built:
    """Cut a session into repetitions and average those that are accepted.

    Parameters
    ----------
    dropped : sequence of int, optional
        Numbers that a person left out: all others are accepted, odd ones too. When absent the service decides,
        and says why.

    Raises
    ------
    InvalidInput
        Too few repetitions, or a channel that was not measured: the message says what to do.
    """
    try:
        judged = source.judged(side)
        unknown = set(dropped or ()) - {repetition.number for repetition in judged}
        if unknown:
            raise InvalidInput(say("template.no_repetition", number=min(unknown)), field="dropped")
        if dropped is not None:
            judged = [_decided(r, is_kept=r.number not in dropped) for r in judged]
        accepted = sum(repetition.is_kept for repetition in judged)
        if source.cycles is not None and accepted < FEWEST:
            raise InvalidInput(say("template.few_strides", count=accepted), field="session_id")
        template = build_template(
            source.moved,
            judged,
            side,
            source.reach_m,
            primary_channel,
            tolerance_scale,
            judge=dropped is None and source.cycles is None,
        )
    except EstimationError as error:
        raise InvalidInput(error.message) from error
    arm = side_channels(source.moved, side)
    return Built(template, judged, [_curve(arm, repetition, template) for repetition in judged])


def _decided(repetition: Repetition, *, is_kept: bool) -> Repetition:
    """Apply a person's choice to a judged repetition; what was odd about one left out stays its reason."""
    reason = "" if is_kept else repetition.reason or BY_HAND
    return replace(repetition, is_kept=is_kept, reason=reason)


def _curve(arm: SideChannels, repetition: Repetition, template: Template) -> Float:
    cut = arm.cut(repetition)
    if len(cut.time_s) < 2:
        return np.full(template.mean.shape, np.nan)
    return near(phase_curves(cut), template.mean, template.channels)


def preview(session: Session, subject: Subject, wanted: TemplatePreviewIn) -> TemplateContent:
    """Build a template from a session without keeping it."""
    _, _, built = _build_from(session, subject, wanted, None)
    return content_of(built)


def prepare(
    session: Session, subject: Subject, wanted: TemplateIn
) -> tuple[TemplateVersion, TemplateContent]:
    """Build a template from a session, ready to be stored by `store`; reads only."""
    # First of all the right to the recording: a stranger learns nothing about anything else.
    recordings.get_session(session, subject, wanted.session_id, "treat", action="")
    exercise = repository.exercise_of(session, subject, wanted.exercise_id)
    found, result, built = _build_from(session, subject, wanted, exercise, wanted.phases)
    version = TemplateVersion(
        source_session_id=found.id,
        source_result_id=result.id,
        repetitions=[
            {**asdict(repetition), "reason": for_json(repetition.reason)} for repetition in built.repetitions
        ],
        tolerance_scale=dict(wanted.tolerance_scale),
        content=template_to_bytes(built.template),
        design=built.design.model_dump(mode="json"),
    )
    return version, content_of(built)


def store(
    session: Session,
    subject: Subject,
    wanted: TemplateIn,
    version: TemplateVersion,
    content: TemplateContent,
) -> TemplateVersionDetail:
    """Store what `prepare` built, as a first or further version."""
    recordings.get_session(session, subject, wanted.session_id, "treat", action="")
    exercise = repository.exercise_of(session, subject, wanted.exercise_id)
    template = None
    if wanted.template_id is not None:
        template = repository.get_template(session, subject, wanted.template_id)
    template = repository.add_version(
        session, subject, template, exercise, wanted.patient_id, wanted.name, version
    )
    return version_detail(session, template, version, content)


def _build_from(
    session: Session,
    subject: Subject,
    wanted: TemplatePreviewIn,
    exercise: Exercise | None,
    phases: Sequence[PhaseDesign] | None = None,
) -> tuple[MotionSession, Result, Built]:
    found = recordings.get_session(session, subject, wanted.session_id, "treat", action="template.preview")
    result = recordings.result_of(session, found, wanted.result_id)
    if exercise is None and found.exercise_id is not None:
        exercise = session.get(Exercise, found.exercise_id)
    source = load_source(session, found, result)
    if source.cycles is not None:
        patient = session.get_one(Patient, found.patient_id)
        side = wanted.side or source.acting_side("right", patient.affected_side)
        cycles = source.cycles.get("left" if side == "left" else "right")
        if cycles is None:
            raise InvalidInput(say("compare.side_not_measured", side=side), field="side")
        # An exercise that is judged by an angle finds none in strides, and says so.
        main = (exercise.primary_angle if exercise is not None else "") or cycles.main_channel
        built = build(source, side, main, wanted.dropped, wanted.tolerance_scale)
        known = [PhaseDesign(name=one.name, start=one.start, end=one.end) for one in cycles.phases]
        begun = _begun(built, known if phases is None else phases, cycles.watched)
        return found, result, replace(begun, sides=tuple(source.cycles))
    side, primary = _what_moved(source) if exercise is None else (exercise.side, exercise.primary_angle)
    if not primary:
        raise InvalidInput(say("template.not_walked"), field="session_id")
    built = build(source, side, primary, wanted.dropped, wanted.tolerance_scale)
    return found, result, _begun(built, phases) if phases else built


def _begun(built: Built, phases: Sequence[PhaseDesign], watched: Sequence[str] = ()) -> Built:
    """Return a template with the phases and the channels to watch that it begins with."""
    design = TemplateDesign(
        phases=list(phases), watched=[name for name in watched if name in built.template.channels]
    )
    return replace(built, template=apply_design(built.template, design), design=design)


def _what_moved(source: Source) -> tuple[str, str]:
    """Return side and angle with the largest range, for a session without an exercise."""
    moved = source.moved
    values = moved.measured
    best, channel = 0.0, ""
    for column, name in enumerate(moved.channels):
        if not name.endswith(("_elevation", "_flexion", "_pronation")) or "plane_of" in name:
            continue
        finite = values[np.isfinite(values[:, column]), column]
        if finite.size and (extent := float(np.subtract(*np.percentile(finite, [98, 2])))) > best:
            best, channel = extent, name
    if not channel:
        raise InvalidInput(say("template.no_angle"))
    return ("left" if "_left_" in channel else "right"), channel


def content_of(built: Built) -> TemplateContent:
    """Return what a built template looks like."""
    return TemplateContent(
        duration_s=built.template.duration_s,
        repetitions=[repetition_out(repetition) for repetition in built.repetitions],
        phases=phases_out(built.template),
        curves=phase_curves_out(built.template, built.curves),
        measures=offered_measures(built.template),
        side=side_of(built.template.side),
        sides=list(built.sides),
    )
