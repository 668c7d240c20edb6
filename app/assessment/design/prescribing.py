"""Prescriptions made and changed: what is asked of a patient must be possible with the template that guides her."""

from dataclasses import replace

from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment import practice
from app.assessment import repository as templates
from app.assessment.design.compiled import effective_template
from app.assessment.design.limits import Reached, check_band, check_stops, resting_pose
from app.assessment.design.shown import reached_of
from app.errors import InvalidInput
from app.exercises import repository as exercises
from app.exercises.design import StopDesign
from app.exercises.models import Prescription
from app.exercises.schemas import PrescriptionChangeIn, PrescriptionIn, PrescriptionOut
from estimators.comparison import channel_name, template_from_bytes
from estimators.errors import EstimationError
from estimators.sentences import say


def prescribe(
    session: Session, subject: Subject, patient_id: str, body: PrescriptionIn, default_zone: str
) -> PrescriptionOut:
    """Prescribe an exercise; what was done of it earlier this week counts, unless it counts for another prescription.

    Parameters
    ----------
    subject : Subject
        With the level `treat`.
    default_zone : str
        Setting `time_zone`.

    Raises
    ------
    InvalidInput
        As of the repository's `create_prescription`; a limit or the band cannot hold with this template or by this
        patient at rest: the message has the value.
    """
    new = exercises.create_prescription(session, subject, patient_id, body)
    _check(session, subject, new[0], is_band_new=True)
    return practice.with_practice_of(session, subject, new, default_zone)


def change(
    session: Session, subject: Subject, prescription_id: str, body: PrescriptionChangeIn, default_zone: str
) -> PrescriptionOut:
    """Change what is prescribed; see `prescribe`, and the repository's `change_prescription` for its errors."""
    changed = exercises.change_prescription(session, subject, prescription_id, body)
    given = body.model_fields_set
    if given & {"stops", "template_id", "tolerance_scale"}:
        is_band_new = bool(given & {"template_id", "tolerance_scale"})
        _check(session, subject, changed[0], is_band_new=is_band_new)
    return practice.with_practice_of(session, subject, changed, default_zone)


def _check(session: Session, subject: Subject, one: Prescription, *, is_band_new: bool) -> None:
    if one.template_id is None or not (one.stops or one.tolerance_scale < 1.0):
        return
    version = templates.newest_version(session, one.template_id)
    if version is None:
        return
    try:
        drawn = effective_template(version, scale=one.tolerance_scale)
    except EstimationError:
        # A template that cannot be read guides nobody, and says so itself.
        return
    stops = [StopDesign.model_validate(stop) for stop in one.stops]
    for place, stop in enumerate(stops):
        if stop.kind == "limit" and stop.channel not in drawn.channels:
            name = channel_name(stop.channel)
            raise InvalidInput(
                say("design.limit_channel", number=place + 1, channel=name), field=f"stops.{place}"
            )
    reached: Reached = reached_of(session, subject, version, drawn)
    reached = replace(reached, rest=resting_pose(session, one.patient_id, one.exercise_id))
    check_stops(stops, reached, "stops")
    if is_band_new and one.tolerance_scale < 1.0:
        check_band(reached, template_from_bytes(version.content), "tolerance_scale")
