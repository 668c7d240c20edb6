"""How long the service takes to answer progress over 200 sessions, of an arm and of walks, in one process.

Run: `python -m tests.benchmarks.bench_progress` from the root. Ends with status 1 when a median is above `LIMIT_S`.
Sessions are rows as the real chain leaves them, in a database of their own: of an arm ten repetitions with every
measure, of a walk a minute on both feet with strides, paths and curves.
"""

import argparse
import json
import platform
import random
import sys
import tempfile
import time
import zlib
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from sqlalchemy import Engine
from sqlalchemy.orm import Session

from app import tables as tables
from app.accounts.models import Account, Clinic
from app.accounts.subject import Subject
from app.assessment.measures import store_drawn
from app.assessment.models import Comparison, RepetitionMeasure
from app.assessment.progress import progress
from app.database import migrate
from app.database.base import new_id, utc_now
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.exercises.models import Exercise, Template, TemplateVersion
from app.kinds.walk.followed import followed_of
from app.kinds.walk.schemas import WalkContent
from app.kinds.walk.stored import PIPELINE
from app.patients.models import Patient
from app.recordings.models import WALK_STREAM, MotionSession, Result, SignalChunk
from estimators.measures import MEASURES, measures_of
from tests.benchmarks.machine import processor

LIMIT_S = 0.3
SESSIONS, REPETITIONS = 200, 10
ANGLES = ("yxy_elevation", "yxy_plane_of_elevation", "yxy_axial_rotation")
ROUNDS = 7


class Clinics:
    """A clinic with one patient and one exercise of an arm and one walk.

    Parameters
    ----------
    engine : Engine
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.clinic_id, self.account_id, self.patient_id = new_id(), new_id(), new_id()
        self.arm_id, self.walk_id, self.version_id = new_id(), new_id(), new_id()
        with unit_of_work(engine) as session:
            session.add(Clinic(id=self.clinic_id, name="Clinic"))
            session.flush()
            session.add(
                Account(
                    id=self.account_id,
                    clinic_id=self.clinic_id,
                    email="a@example.org",
                    display_name="A",
                    role="administrator",
                    password_hash="",
                )
            )
            session.add(
                Patient(id=self.patient_id, clinic_id=self.clinic_id, given_name="Ada", family_name="Berg")
            )
            session.flush()
            for exercise_id, movement, angle in (
                (self.arm_id, "reaching", "thorax_humerus_right_yxy_elevation"),
                (self.walk_id, "walk", ""),
            ):
                session.add(
                    Exercise(
                        id=exercise_id,
                        clinic_id=self.clinic_id,
                        name=movement,
                        movement=movement,
                        primary_angle=angle,
                    )
                )
            session.flush()
            template_id = new_id()
            session.add(
                Template(
                    id=template_id,
                    clinic_id=self.clinic_id,
                    exercise_id=self.arm_id,
                    name="T",
                    created_by=self.account_id,
                )
            )
            session.flush()
            session.add(
                TemplateVersion(
                    id=self.version_id,
                    template_id=template_id,
                    number=1,
                    source_session_id="0" * 32,
                    source_result_id="0" * 32,
                    repetitions=[],
                    content=b"",
                    created_by=self.account_id,
                )
            )

    def subject(self) -> Subject:
        """Return the clinic's administrator."""
        return Subject("account", self.account_id, self.account_id, self.clinic_id, "administrator", None)

    def add(self, session: Session, exercise_id: str, pipeline: str, days_ago: int) -> Result:
        """Add an analysed session and return its main result."""
        at = utc_now() - timedelta(days=days_ago)
        motion = MotionSession(
            id=new_id(),
            created_at=at,
            started_at=at,
            clinic_id=self.clinic_id,
            patient_id=self.patient_id,
            exercise_id=exercise_id,
            state="analysed",
            setup={"pipeline": pipeline},
            created_by=self.account_id,
        )
        session.add(motion)
        session.flush()
        result = Result(
            id=new_id(),
            session_id=motion.id,
            kind="offline",
            pipeline=pipeline,
            pipeline_version="1",
            orientation="telemotion",
            orientation_version="10",
            setup={},
            layout={},
            status="complete",
        )
        session.add(result)
        session.flush()
        motion.main_result_id = result.id
        return result

    def add_arm(self, days_ago: int, generator: random.Random) -> None:
        """Add a compared session."""
        names = []
        for one in MEASURES:
            if one.part == "repetition":
                angles = [f"thorax_humerus_right_{angle}" for angle in ANGLES]
                names.extend([one.name + angle for angle in angles] if one.name.endswith(":") else [one.name])
        with unit_of_work(self.engine) as session:
            result = self.add(session, self.arm_id, "arm", days_ago)
            comparison = Comparison(
                id=new_id(),
                session_id=result.session_id,
                result_id=result.id,
                template_version_id=self.version_id,
                version="2",
                repetition_count=REPETITIONS,
                summary={},
                content=b"",
            )
            session.add(comparison)
            session.flush()
            session.add_all(
                RepetitionMeasure(
                    comparison_id=comparison.id,
                    repetition=repetition,
                    measure=name,
                    value=generator.gauss(60, 5),
                    uncertainty=1.0,
                    unit="deg",
                )
                for repetition in range(1, REPETITIONS + 1)
                for name in names
            )
            session.flush()
            store_drawn(session, comparison.id)

    def add_walk(self, days_ago: int, generator: random.Random) -> None:
        """Add a walk of a minute."""
        with unit_of_work(self.engine) as session:
            result = self.add(session, self.walk_id, PIPELINE, days_ago)
            content = walk(generator)
            bare: dict[str, list[Any]] = {"footholds": [], "strides": [], "path_m": [], "curves": []}
            measured = content | {"feet": [foot | bare for foot in content["feet"]]}
            result.followed = followed_of(WalkContent.model_validate(measured))
            data = zlib.compress(json.dumps(content).encode())
            session.add(
                SignalChunk(
                    session_id=result.session_id,
                    stream=WALK_STREAM + result.id,
                    sequence=0,
                    start_ns=0,
                    ticks=0,
                    codec="json",
                    scale={},
                    crc=0,
                    data=data,
                )
            )


def walk(generator: random.Random) -> dict[str, Any]:
    """Return what is stored of a walk of a minute: the measures, and as much beside them as a real one has."""

    def measures(names: tuple[str, ...]) -> list[dict[str, Any]]:
        return [
            {
                "measure": name,
                "value": generator.gauss(1.2, 0.1),
                "sigma": 0.01,
                "spread": 0.05,
                "count": 50,
                "unit": "m",
            }
            for name in names
        ]

    def rows(count: int, width: int) -> list[list[float]]:
        # Rounded as stored ones are.
        return [[round(generator.gauss(0, 1), 4) for _ in range(width)] for _ in range(count)]

    feet = [
        {
            "side": side,
            "measures": measures(measures_of("foot")),
            "footholds": rows(56, 6),
            "strides": rows(55, 20),
            "path_m": rows(1200, 2),
            "curves": rows(8, 204),
        }
        for side in ("left", "right")
    ]
    return {
        "feet": feet,
        "both": measures(measures_of("both")),
        "asymmetry": measures(measures_of("asymmetry")),
        "turn_count": 4,
        "bout_count": 1,
        "reasons": [],
        "has_step_width": True,
    }


def timed(answer: Callable[[], object]) -> list[float]:
    """Return the processor time of each round after a first one, s: what it takes where nothing else runs."""
    took = []
    for _ in range(ROUNDS + 1):
        begun = time.process_time()
        answer()
        took.append(time.process_time() - begun)
    return took[1:]


def main() -> int:
    """Print the times beside the limit."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    generator = random.Random(1)
    with tempfile.TemporaryDirectory() as folder:
        engine = create_from_url(f"sqlite:///{folder}/progress.db")
        migrate.upgrade_engine(engine)
        clinics = Clinics(engine)
        for day in range(SESSIONS, 0, -1):
            clinics.add_arm(day, generator)
            clinics.add_walk(day, generator)

        def answer(exercise_id: str) -> str:
            with unit_of_work(engine) as session:
                found = progress(session, clinics.subject(), clinics.patient_id, exercise_id, "UTC")
                return found.model_dump_json()

        print(f"{platform.python_version()} on {processor()}")
        slowest = 0.0
        for name, exercise_id in (("arm", clinics.arm_id), ("walk", clinics.walk_id)):
            took = timed(lambda exercise_id=exercise_id: answer(exercise_id))
            slowest = max(slowest, float(np.median(took)))
            print(
                f"progress over {SESSIONS} sessions, {name}: median {1e3 * np.median(took):.0f} ms of"
                f" {1e3 * LIMIT_S:.0f} ms; rounds " + ", ".join(f"{1e3 * one:.0f}" for one in took)
            )
        engine.dispose()
    return int(slowest > LIMIT_S)


if __name__ == "__main__":
    sys.exit(main())
