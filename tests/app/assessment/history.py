"""Makes weeks of compared sessions without measuring anything: rows as the real chain would leave them."""

from datetime import timedelta

from app.assessment.measures import store_drawn
from app.assessment.models import Comparison, RepetitionMeasure
from app.database.base import new_id, utc_now
from app.database.unit_of_work import unit_of_work
from app.exercises.models import Prescription, Template, TemplateVersion
from app.recordings.models import MotionSession, Result

MEASURE = "range:thorax_humerus_right_yxy_elevation"


class History:
    """Makes sessions with compared repetitions."""

    def __init__(self, engine, world):
        self.engine, self.world = engine, world
        with unit_of_work(engine) as session:
            template = Template(
                id=new_id(),
                clinic_id=world.clinic_id,
                exercise_id=world.exercise_id,
                patient_id=world.patient_id,
                name="Template",
                created_by=world.accounts["therapist"],
            )
            session.add(template)
            session.flush()
            version = TemplateVersion(
                id=new_id(),
                template_id=template.id,
                number=1,
                source_session_id="0" * 32,
                source_result_id="0" * 32,
                repetitions=[],
                tolerance_scale={},
                content=b"",
                is_published=True,
                created_by=world.accounts["therapist"],
            )
            session.add(version)
        self.template_id, self.version_id = template.id, version.id
        self.summary = []
        """Of the comparisons that are made from now on."""

    def prescribe(self, days_ago, times_per_week=5, template=True, patient_id=None):
        return self.prescribe_at(utc_now() - timedelta(days=days_ago), times_per_week, template, patient_id)

    def prescribe_at(self, starts_at, times_per_week=5, template=True, patient_id=None):
        with unit_of_work(self.engine) as session:
            row = Prescription(
                id=new_id(),
                patient_id=patient_id or self.world.patient_id,
                exercise_id=self.world.exercise_id,
                template_id=self.template_id if template else None,
                times_per_week=times_per_week,
                prescribed_by=self.world.accounts["therapist"],
                starts_at=starts_at,
                ends_at=None,
            )
            session.add(row)
        return row

    def session(self, days_ago, *arguments, **fields):
        return self.session_at(utc_now() - timedelta(days=days_ago), *arguments, **fields)

    def session_at(self, at, values=(), orientation="vqf", measure=MEASURE, **fields):
        with unit_of_work(self.engine) as session:
            motion = MotionSession(
                id=new_id(),
                created_at=at,
                started_at=at,
                clinic_id=self.world.clinic_id,
                patient_id=fields.pop("patient_id", self.world.patient_id),
                exercise_id=fields.pop("exercise_id", self.world.exercise_id),
                state=fields.pop("state", "analysed"),
                duration_s=fields.pop("duration_s", 60.0),
                setup={},
                created_by=self.world.accounts["patient"],
                **fields,
            )
            session.add(motion)
            session.flush()
            if len(values):
                motion.main_result_id = self.compare(session, motion.id, values, orientation, at, measure)
        return motion.id

    def compare(self, session, motion_id, values, orientation, at, measure=MEASURE):
        result = Result(
            id=new_id(),
            session_id=motion_id,
            kind="offline",
            pipeline="arm",
            pipeline_version="1",
            orientation=orientation,
            orientation_version="2",
            setup={},
            layout={},
            status="complete",
        )
        session.add(result)
        session.flush()
        comparison = Comparison(
            id=new_id(),
            created_at=at,
            session_id=motion_id,
            result_id=result.id,
            template_version_id=self.version_id,
            version="1",
            repetition_count=len(values),
            summary={"measures": self.summary},
            content=b"",
        )
        session.add(comparison)
        session.flush()
        for number, value in enumerate(values, start=1):
            session.add(
                RepetitionMeasure(
                    comparison_id=comparison.id,
                    repetition=number,
                    measure=measure,
                    value=value,
                    uncertainty=0.01,
                    unit="rad",
                )
            )
        session.flush()
        store_drawn(session, comparison.id)
        return result.id


def reason_declining(history):
    for age, mean in zip(range(6, 0, -1), [1.5, 1.5, 1.5, 1.0, 1.0, 1.0], strict=True):
        history.session(age, [mean - 0.02, mean + 0.02])
