"""Templates and comparisons: every query, who may, and the audit event it leaves.

A template made for one patient is that patient's data. A template of the clinic can be used by everybody who
works there; a patient sees those that were prescribed to them or that they were compared with.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import ColumnElement, String, cast, false, func, or_, select, true
from sqlalchemy.orm import Session, defer

from app.accounts import audit
from app.accounts.models import Account
from app.accounts.subject import Subject
from app.assessment.measures import store_drawn
from app.assessment.models import Comparison, RepetitionMeasure
from app.errors import InvalidInput, NotAllowed, NotFound
from app.exercises.models import Exercise, Prescription, Template, TemplateVersion
from app.pages import Page, rows_of
from app.patients.access import require_patient
from app.recordings import repository as recordings
from app.recordings.models import MotionSession
from estimators.sentences import say

NO_SUCH_TEMPLATE = say("template.not_found")
NO_SUCH_COMPARISON = say("comparison.not_found")


@dataclass(frozen=True)
class TemplateSearch:
    """Which templates to list.

    Attributes
    ----------
    words : str
        Each must be in the name of the template or of its exercise, or in a tag.
    is_retired : bool
        Whether those that are no longer offered are listed too.
    """

    exercise_id: str | None = None
    patient_id: str | None = None
    words: str = ""
    is_retired: bool = False


STAFF = frozenset({"administrator", "therapist", "integrator", "system"})
MAKERS = frozenset({"therapist", "administrator", "system"})
"""Roles that make and change templates."""


def list_templates(
    session: Session, subject: Subject, wanted: TemplateSearch, page: Page
) -> list[tuple[Template, list[TemplateVersion]]]:
    """Return a page of the templates by name with their published versions, newest first.

    Those of the clinic that the subject may use and, with `patient_id`, those of that patient.
    """
    patient_id = wanted.patient_id
    visible: ColumnElement[bool] = Template.patient_id.is_(None) & _usable(subject)
    if patient_id is not None:
        require_patient(session, subject, patient_id, "read")
        audit.record(session, subject, "template.list", patient_id)
        visible = or_(visible, Template.patient_id == patient_id)
    query = select(Template).where(Template.clinic_id == subject.clinic_id, visible)
    if wanted.exercise_id is not None:
        query = query.where(Template.exercise_id == wanted.exercise_id)
    # A patient goes on with what was prescribed, whether or not it is still offered.
    if not wanted.is_retired and subject.role in STAFF:
        query = query.where(Template.retired_at.is_(None))
    for word in wanted.words.lower().split():
        query = query.where(_holds(word))
    found = [template for (template,) in rows_of(session, query, (Template.name, Template.id), page)]
    versions = session.scalars(
        select(TemplateVersion)
        .where(TemplateVersion.template_id.in_([template.id for template in found]))
        .where(TemplateVersion.is_published)
        .order_by(TemplateVersion.number.desc())
        .options(defer(TemplateVersion.content))
    ).all()
    return [(template, [v for v in versions if v.template_id == template.id]) for template in found]


def _holds(word: str) -> ColumnElement[bool]:
    """Return the condition that a word is in the name of a template or of its exercise, or in a tag."""
    named = select(Exercise.id).where(
        Exercise.id == Template.exercise_id, func.lower(Exercise.name).contains(word, autoescape=True)
    )
    # Tags are stored in small letters, and as JSON writes them.
    tagged = cast(Template.tags, String).contains(json.dumps(word)[1:-1], autoescape=True)
    return or_(func.lower(Template.name).contains(word, autoescape=True), tagged, named.exists())


def get_template(session: Session, subject: Subject, template_id: str) -> Template:
    """Return a template that the subject may use.

    Raises
    ------
    NotFound
        No such template, or no right to know of it.
    """
    template = session.get(Template, template_id)
    if template is None or template.clinic_id != subject.clinic_id:
        raise NotFound(NO_SUCH_TEMPLATE)
    if template.patient_id is None:
        usable = select(Template.id).where(Template.id == template.id, _usable(subject))
        if session.scalar(usable) is None:
            raise NotFound(NO_SUCH_TEMPLATE)
        return template
    try:
        require_patient(session, subject, template.patient_id, "read")
    except (NotFound, NotAllowed):
        raise NotFound(NO_SUCH_TEMPLATE) from None
    return template


def get_version(
    session: Session, subject: Subject, version_id: str, *, audited: bool = True
) -> tuple[Template, TemplateVersion]:
    """Return a version of a template that the subject may use."""
    version = session.get(TemplateVersion, version_id)
    if version is None:
        raise NotFound(NO_SUCH_TEMPLATE)
    template = get_template(session, subject, version.template_id)
    if audited:
        audit.record(session, subject, "template.read", template.patient_id, version.id)
    return template, version


def _usable(subject: Subject) -> ColumnElement[bool]:
    """Return the condition that a template of the clinic is open to the subject."""
    if subject.role in STAFF:
        return true()
    if subject.patient_id is None:
        return false()
    prescribed = select(Prescription.id).where(
        Prescription.patient_id == subject.patient_id, Prescription.template_id == Template.id
    )
    compared = (
        select(Comparison.id)
        .join(TemplateVersion, TemplateVersion.id == Comparison.template_version_id)
        .join(MotionSession, MotionSession.id == Comparison.session_id)
        .where(MotionSession.patient_id == subject.patient_id, TemplateVersion.template_id == Template.id)
    )
    return or_(prescribed.exists(), compared.exists())


def exercise_of(session: Session, subject: Subject, exercise_id: str) -> Exercise:
    """Return an exercise of the subject's clinic."""
    exercise = session.get(Exercise, exercise_id)
    if exercise is None or exercise.clinic_id != subject.clinic_id:
        raise InvalidInput(say("exercise.not_found"), field="exercise_id")
    return exercise


def add_version(
    session: Session,
    subject: Subject,
    template: Template | None,
    exercise: Exercise,
    patient_id: str | None,
    name: str,
    version: TemplateVersion,
) -> Template:
    """Store a new template with its first version, or a further version of a template.

    The right to the source session was checked; here the right to what the template belongs to.

    Raises
    ------
    NotAllowed
        Only people who treat make templates.
    InvalidInput
        The template is of another exercise or patient.
    """
    if subject.role not in MAKERS or subject.account_id is None:
        raise NotAllowed(say("template.create_not_allowed"))
    if patient_id is not None:
        require_patient(session, subject, patient_id, "treat")
    if template is None:
        template = Template(
            clinic_id=subject.clinic_id,
            exercise_id=exercise.id,
            patient_id=patient_id,
            name=name,
            created_by=subject.account_id,
        )
        session.add(template)
        session.flush()
    elif template.exercise_id != exercise.id or template.patient_id != patient_id:
        raise InvalidInput(say("template.other_exercise"), field="template_id")
    else:
        template.name = name
    _publish(session, subject, template, version)
    return template


def treated_template(session: Session, subject: Subject, template_id: str) -> Template:
    """Return a template that the subject may change.

    Raises
    ------
    NotFound
        No such template, or no right to know of it.
    NotAllowed
        Only people who treat change templates; of a patient's, those who treat that patient.
    """
    template = get_template(session, subject, template_id)
    if subject.role not in MAKERS or subject.account_id is None:
        raise NotAllowed(say("template.create_not_allowed"))
    if template.patient_id is not None:
        require_patient(session, subject, template.patient_id, "treat")
    return template


def newest_version(session: Session, template_id: str) -> TemplateVersion | None:
    """Return the newest version of a template, the one that guides; access to the template was checked."""
    return session.scalar(
        select(TemplateVersion)
        .where(TemplateVersion.template_id == template_id, TemplateVersion.is_published)
        .order_by(TemplateVersion.number.desc())
        .limit(1)
    )


def add_drawn_version(
    session: Session, subject: Subject, template: Template, version: TemplateVersion
) -> TemplateVersion:
    """Store a further version of a template that `treated_template` gave."""
    _publish(session, subject, template, version)
    return version


def _publish(session: Session, subject: Subject, template: Template, version: TemplateVersion) -> None:
    last = session.scalar(
        select(func.max(TemplateVersion.number)).where(TemplateVersion.template_id == template.id)
    )
    version.template_id = template.id
    version.number = (last or 0) + 1
    version.created_by = str(subject.account_id)
    session.add(version)
    session.flush()
    audit.record(
        session,
        subject,
        "template.publish",
        template.patient_id,
        version.id,
        {"template": template.id, "number": version.number, "source_session": version.source_session_id},
    )


def names_of_makers(session: Session, versions: Sequence[TemplateVersion]) -> dict[str, str]:
    """Return the names of those who made versions, by account; access to the versions was checked."""
    makers = select(Account).where(Account.id.in_({one.created_by for one in versions}))
    return {account.id: account.display_name for account in session.scalars(makers)}


def prescribed_version(session: Session, found: MotionSession) -> TemplateVersion | None:
    """Return the newest published version of the template that a session was prescribed with."""
    if found.prescription_id is None:
        return None
    template_id = session.scalar(
        select(Prescription.template_id).where(Prescription.id == found.prescription_id)
    )
    if template_id is None:
        return None
    return session.scalar(
        select(TemplateVersion)
        .where(TemplateVersion.template_id == template_id, TemplateVersion.is_published)
        .order_by(TemplateVersion.number.desc())
        .limit(1)
    )


def add_comparison(
    session: Session, subject: Subject, found: MotionSession, new: Comparison, rows: list[RepetitionMeasure]
) -> Comparison:
    """Store a comparison with a row per repetition and measure, and one per measure for progress."""
    session.add(new)
    session.flush()
    for row in rows:
        row.comparison_id = new.id
    session.add_all(rows)
    session.flush()
    store_drawn(session, new.id)
    audit.record(
        session,
        subject,
        "comparison.create",
        found.patient_id,
        new.id,
        {"template_version": new.template_version_id},
    )
    return new


def list_comparisons(
    session: Session, subject: Subject, session_id: str, page: Page
) -> list[tuple[Comparison, str]]:
    """Return a page of a session's comparisons, newest first, each with its template's name."""
    recordings.get_session(session, subject, session_id, action="comparison.list")
    query = (
        select(Comparison, Template.name)
        .join(TemplateVersion, TemplateVersion.id == Comparison.template_version_id)
        .join(Template, Template.id == TemplateVersion.template_id)
        .where(Comparison.session_id == session_id)
        .options(defer(Comparison.content))
    )
    order = (Comparison.created_at, Comparison.id)
    return [(found, name) for found, name in rows_of(session, query, order, page, newest_first=True)]


def get_comparison(
    session: Session, subject: Subject, comparison_id: str
) -> tuple[Comparison, Template, TemplateVersion]:
    """Return a comparison of a session that the subject may read."""
    comparison = session.get(Comparison, comparison_id)
    if comparison is None:
        raise NotFound(NO_SUCH_COMPARISON)
    try:
        found = recordings.get_session(session, subject, comparison.session_id, action="")
    except NotFound:
        raise NotFound(NO_SUCH_COMPARISON) from None
    audit.record(session, subject, "comparison.read", found.patient_id, comparison.id)
    version = session.get_one(TemplateVersion, comparison.template_version_id)
    return comparison, session.get_one(Template, version.template_id), version
