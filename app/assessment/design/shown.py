"""Templates and their versions as clients see them."""

from collections.abc import Mapping, Sequence

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment import repository
from app.assessment.design.compiled import design_of, effective_template
from app.assessment.design.limits import Reached, resting_pose, troubles_of
from app.assessment.design.rules import side_of, whole_design
from app.assessment.design.weighted import offered_measures
from app.assessment.presentation import phase_curves_out, phases_out, repetition_out
from app.assessment.sources import load_source
from app.errors import InvalidInput, NotAllowed, NotFound
from app.exercises.models import Exercise, TemplateVersion
from app.exercises.models import Template as TemplateRow
from app.exercises.schemas import TemplateContent, TemplateOut, TemplateVersionDetail, TemplateVersionOut
from app.pages import Page
from app.recordings import repository as recordings
from app.recordings.compared import Source
from estimators.comparison import (
    Repetition,
    Template,
    is_of_stride,
    mirrored_name,
    near,
    phase_curves,
    side_channels,
    template_from_bytes,
)
from estimators.errors import EstimationError
from estimators.recording import Float
from estimators.sentences import CATALOGUE


def list_of(
    session: Session, subject: Subject, wanted: repository.TemplateSearch, page: Page
) -> list[TemplateOut]:
    """Return a page of the templates that the subject may use."""
    found = repository.list_templates(session, subject, wanted, page)
    names = repository.names_of_makers(session, [one for _, versions in found for one in versions])
    return [template_out(template, versions, names) for template, versions in found]


def template_out(
    template: TemplateRow, versions: Sequence[TemplateVersion], names: Mapping[str, str]
) -> TemplateOut:
    """Return a template with its versions; `names` as for `version_out`."""
    return TemplateOut(
        id=template.id,
        exercise_id=template.exercise_id,
        patient_id=template.patient_id,
        name=template.name,
        tags=template.tags,
        retired_at=template.retired_at,
        created_at=template.created_at,
        versions=[version_out(version, names) for version in versions],
    )


def detail(session: Session, subject: Subject, version_id: str) -> TemplateVersionDetail:
    """Return a version with its curves; single repetitions only to those who may read their recording."""
    template, version = repository.get_version(session, subject, version_id)
    return detail_of(session, subject, template, version)


def detail_of(
    session: Session, subject: Subject, template: TemplateRow, version: TemplateVersion
) -> TemplateVersionDetail:
    """Return the same for a version that the subject was found to have access to."""
    stored = effective_template(version)
    repetitions = _repetitions_of(version)
    curves = _repetition_curves(session, subject, version, stored, repetitions)
    content = TemplateContent(
        duration_s=stored.duration_s,
        repetitions=[repetition_out(repetition) for repetition in repetitions],
        phases=phases_out(stored),
        curves=phase_curves_out(stored, curves),
        measures=offered_measures(stored),
        side=side_of(stored.side),
    )
    return version_detail(session, template, version, content, kept_of(repetitions, curves))


def reached_of(session: Session, subject: Subject, version: TemplateVersion, stored: Template) -> Reached:
    """Return what a version's recording did, for checking limits and bands; access to the version was checked.

    Parameters
    ----------
    subject : Subject
        Without the right to the recording only the mean is known.
    stored : Template
        Of the version, on the side on which it was recorded, with the band in question.
    """
    repetitions = _repetitions_of(version)
    return Reached(
        stored, kept_of(repetitions, _repetition_curves(session, subject, version, stored, repetitions))
    )


def kept_of(repetitions: Sequence[Repetition], curves: Sequence[Float]) -> list[Float]:
    """Return the curves of the repetitions that count; none where none are known."""
    return [curve for one, curve in zip(repetitions, curves, strict=False) if one.is_kept]


def _repetitions_of(version: TemplateVersion) -> list[Repetition]:
    return [
        Repetition(**{**repetition, "reason": CATALOGUE.restored(repetition["reason"])})
        for repetition in version.repetitions
    ]


def _repetition_curves(
    session: Session,
    subject: Subject,
    version: TemplateVersion,
    template: Template,
    repetitions: list[Repetition],
) -> list[Float]:
    try:
        found = recordings.get_session(session, subject, version.source_session_id, action="")
        result = recordings.result_of(session, found, version.source_result_id)
        source = load_source(session, found, result)
        side = _recorded_side(source, repetitions, template.side)
        arm = side_channels(source.moved, side)
    except (NotFound, NotAllowed, InvalidInput, EstimationError):
        # The recording was deleted or is not this subject's to see; the template stands by itself.
        return []
    wanted = [name if side == template.side else mirrored_name(name) for name in template.channels]
    index = [arm.channels.index(name) if name in arm.channels else -1 for name in wanted]
    curves = []
    for repetition in repetitions:
        cut = arm.cut(repetition)
        curve = np.full(template.mean.shape, np.nan)
        if len(cut.time_s) >= 2:
            measured = phase_curves(cut)
            for column, place in enumerate(index):
                if place >= 0:
                    curve[:, column] = measured[:, place]
            curve = near(curve, template.mean, template.channels)
        curves.append(curve)
    return curves


def _recorded_side(source: Source, repetitions: list[Repetition], side: str) -> str:
    """Return of which foot the strides of a template were; those of a copy for the other foot keep theirs."""
    begun = {round(one.start_s, 3) for one in repetitions}
    for own, cycles in (source.cycles or {}).items():
        if begun & {round(one.start_s, 3) for one in cycles.repetitions}:
            return own
    return side


def version_out(version: TemplateVersion, names: Mapping[str, str]) -> TemplateVersionOut:
    """Return a version without its curves; `names` of the people who made versions, by account."""
    return TemplateVersionOut(
        id=version.id,
        number=version.number,
        created_at=version.created_at,
        repetition_count=sum(1 for repetition in version.repetitions if repetition["is_kept"]),
        source_session_id=version.source_session_id,
        reason=version.reason,
        made_by=names[version.created_by],
    )


def version_detail(
    session: Session,
    template: TemplateRow,
    version: TemplateVersion,
    content: TemplateContent,
    own: Sequence[Float] = (),
) -> TemplateVersionDetail:
    """Return a version with curves that are at hand; `own` are those of its repetitions that count."""
    recorded = template_from_bytes(version.content)
    posture = session.get_one(Exercise, template.exercise_id).posture
    design = whole_design(design_of(version), recorded, posture)
    rest = resting_pose(session, template.patient_id, template.exercise_id) if template.patient_id else {}
    return TemplateVersionDetail(
        **version_out(version, repository.names_of_makers(session, [version])).model_dump(),
        template_id=template.id,
        exercise_id=template.exercise_id,
        patient_id=template.patient_id,
        name=template.name,
        side=side_of(recorded.side),
        primary_channel=recorded.primary_channel,
        is_guided=not is_of_stride(recorded.primary_channel),
        reach_m=recorded.reach_m,
        design=design,
        troubles=[text for _, text in troubles_of(design.stops or (), Reached(recorded, own, rest))],
        content=content,
    )
