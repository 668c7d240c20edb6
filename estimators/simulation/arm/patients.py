"""People for demonstrations and tests: a therapist, patients after a mild and a moderate stroke."""

from dataclasses import replace
from typing import Final, Literal

from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.simulation.arm.exercises import LEG_EXERCISES, ExerciseName
from estimators.simulation.arm.movements import Schedule, style_of_impairment
from estimators.simulation.arm.scenario import ARM_PLACEMENTS, ArmScenario, leg_placements

PatientName = Literal["therapist_template", "mild_stroke", "moderate_stroke"]

IMPAIRMENT: Final[dict[PatientName, float]] = {
    "therapist_template": 0.0,
    "mild_stroke": 0.35,
    "moderate_stroke": 0.7,
}
"""Impairment level at the first session, for `style_of_impairment`."""

RECOVERABLE: Final = 0.75
"""Part of the impairment that is gone at progress 1."""


def demonstration_scenario(
    patient: PatientName,
    exercise: ExerciseName,
    *,
    side: Side = "right",
    progress: float = 0.0,
    repetitions: int = 6,
    seed: int = 0,
) -> ArmScenario:
    """Return a session of one of the demonstration people.

    Parameters
    ----------
    patient : str
        `therapist_template`, `mild_stroke` or `moderate_stroke`.
    side : Side
        The acting, for a patient the affected, side.
    progress : float
        0 at the first session, 1 at the end of the therapy; sessions in between improve evenly.
    seed : int
        Another seed is another day.

    Returns
    -------
    ArmScenario
        Change anything else with `dataclasses.replace`.

    Raises
    ------
    SetupError
        If nobody has that name or progress is outside 0 to 1.
    """
    if patient not in IMPAIRMENT:
        raise SetupError(f"nobody is named {patient!r}; known: {', '.join(IMPAIRMENT)}")
    if not 0.0 <= progress <= 1.0:
        raise SetupError(f"progress is {progress}; it goes from 0 to 1")
    style = style_of_impairment(IMPAIRMENT[patient] * (1.0 - RECOVERABLE * progress))
    if patient == "therapist_template":
        # Someone who demonstrates moves with care: slower and more alike from one repetition to the next.
        style = replace(style, speed=0.9, amplitude_sd=0.01, duration_sd=0.02)
    return ArmScenario(
        exercise=exercise,
        side=side,
        placements=leg_placements(side) if exercise in LEG_EXERCISES else ARM_PLACEMENTS,
        style=style,
        schedule=Schedule(repetitions=repetitions),
        seed=seed,
    )
