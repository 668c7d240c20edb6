"""Past walks of the demonstration: simulated on instrumented shoes, uploaded like any recording."""

import asyncio
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from sqlalchemy import Engine

from app.commands.upload import finished, send
from app.demo.dating import date_back
from app.gateway import ServiceClient
from app.readers import write_instrumented_shoe
from app.recordings.schemas import UploadIn
from estimators.conventions import Side
from estimators.simulation import Bout, FootStyle, Leg, gait_preset, simulate_gait

RATE_HZ: Final = 100.0
WIDTH_M: Final = 0.18
STEPS: Final = 13


@dataclass(frozen=True)
class PastWalk:
    """When a walk was, and which walk of the simulator it is."""

    days_ago: float
    preset: str
    seed: int


PAST_WALKS: Final = (PastWalk(15.9, "stroke", 5), PastWalk(2.2, "centre_of_mass", 6))
"""At first with a paretic left leg, its weight and mass toward the right; at last even."""


async def make_walk(
    service: ServiceClient, engine: Engine, patient_id: str, exercise_id: str, walk: PastWalk
) -> str:
    """Simulate, upload and date back a walk; returns its session.

    Parameters
    ----------
    service : ServiceClient
        Signed in as the therapist.
    patient_id : str
        Whose left side is affected.
    exercise_id : str
        Of a walk.
    """
    declaration = UploadIn(
        patient_id=patient_id,
        exercise_id=exercise_id,
        format="instrumented_shoe",
        feet_apart_m=WIDTH_M,
        feet_apart_end_m=WIDTH_M,
    )
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"{walk.preset}.csv"
        await asyncio.to_thread(_simulate, walk, path)
        job = await send(service, path, declaration)
        await finished(service, job.session_id)
    date_back(engine, job.session_id, walk.days_ago)
    return job.session_id


def _simulate(walk: PastWalk, path: Path) -> None:
    preset = gait_preset(walk.preset, walk.seed)
    style = replace(preset.walk, stride_time_sd_s=0.03)
    if walk.preset == "stroke":
        # A sound leg that carries most, standing and walking.
        left, right = style.feet["left"], style.feet["right"]
        feet: dict[Side, FootStyle] = {
            "left": replace(left, toe_out_rad=0.3, step_time_scale=1.2),
            "right": replace(right, step_time_scale=0.8),
        }
        style = replace(style, standing_left_share=0.3, feet=feet)
    course = (Bout((Leg(STEPS),), 3.0),)
    scenario = replace(preset, walk=style, rate_hz=RATE_HZ, course=course)
    write_instrumented_shoe(simulate_gait(scenario).recording, path)
