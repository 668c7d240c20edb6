"""A stored template of known shape for tests of what is drawn on it: rows as recording would leave them."""

from functools import cache

from sqlalchemy import Engine

from app.database.base import new_id
from app.database.unit_of_work import unit_of_work
from app.exercises.models import Template, TemplateVersion
from estimators.comparison import Template as Recorded
from estimators.comparison import build_template, template_to_bytes
from tests.estimators.comparison.conftest import make_planar

FORWARD = "trunk_lean_forward_rad"
LATERAL = "trunk_lean_lateral_rad"
MAIN = "humerus_forearm_right_zxy_flexion"
ELEVATION = "thorax_humerus_right_yxy_elevation"


@cache
def planar_template() -> Recorded:
    made = make_planar(noise_rad=0.001)
    return build_template(made.trajectory, made.truth, "right", made.reach_m, made.primary)


def store_template(engine: Engine, world, patient_id: str | None, name: str = "Reach") -> tuple[str, str]:
    """Return the ids of the template and its first version."""
    with unit_of_work(engine) as session:
        template = Template(
            id=new_id(),
            clinic_id=world.clinic_id,
            exercise_id=world.exercise_id,
            patient_id=patient_id,
            name=name,
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
            content=template_to_bytes(planar_template()),
            created_by=world.accounts["therapist"],
        )
        session.add(version)
        session.flush()
        return template.id, version.id


DESIGN = {
    "phases": [
        {"name": "Lift", "start": 0.1, "end": 0.45},
        {"name": "Lower", "start": 0.55, "end": 0.9},
    ],
    "tolerances": [
        {
            "channel": FORWARD,
            "knots": [
                {"phase": 0.1, "below": 1.0, "above": 0.4},
                {"phase": 0.45, "below": 1.0, "above": 0.4},
                {"phase": 0.5, "below": None, "above": 2.0},
            ],
        },
        {"channel": LATERAL, "knots": [{"phase": 0.0, "below": 0.5, "above": 3.0}]},
    ],
    "watched": [ELEVATION],
    "stops": [{"kind": "limit", "channel": LATERAL, "limit": 0.5, "side": "above"}],
    "cues": [
        {
            "quantity": "deviation",
            "sentence": "guidance.sit_tall",
            "words": "Keep your back on the chair",
            "channel": LATERAL,
            "side": "above",
            "phases": [0.1, 0.45],
        },
        {"quantity": "slow", "sentence": "guidance.quicker", "tolerance": 1.5, "hold_s": 0.0, "is_on": False},
        {"quantity": "deviation", "sentence": "guidance.further", "channel": ELEVATION},
    ],
}
