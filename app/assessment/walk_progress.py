"""Measures of a patient's walks over sessions: the same values that progress shows of repetitions of an arm."""

from typing import Final

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.assessment.measures import SessionValue
from app.kinds.walk.history import walk_content
from app.kinds.walk.schemas import WalkContent, WalkMeasure
from app.kinds.walk.stored import PIPELINE
from app.recordings.models import MotionSession, Result

_LABELS: Final = {
    "test_time": "Time of the test, whole walk",
    "test_distance": "Distance, whole walk",
    "speed": "Walking speed, steady strides",
    "stride_length": "Stride length, steady strides",
    "cadence": "Cadence",
    "stance_share": "Stance, part of the stride",
    "double_support_share": "Both feet on the ground, part of the stride",
    "step_width": "Step width",
    "step_length": "Step length",
    "clearance": "Lift of the foot in swing",
    "toe_out": "Toes turned outward",
    "weight_on_left": "Weight on the left foot, standing",
    "centre_to_left": "Centre of mass left of the middle, walking",
    "margin": "Margin of stability, least of each second",
}
_FEET: Final = ("speed", "stride_length", "cadence", "stance_share", "clearance", "toe_out")
_BOTH: Final = ("double_support_share", "step_width")
_BALANCE: Final = ("weight_on_left", "centre_to_left", "margin")
_UNEVEN: Final = ("stride_length", "step_time", "stance_share")
_SIDES: Final = ("left", "right")
_ORDER: Final = (
    "test_time",
    "test_distance",
    *(f"{name}:{side}" for name in ("speed", "stride_length") for side in _SIDES),
    *(f"uneven:{name}" for name in _UNEVEN),
    *_BOTH,
    *_BALANCE,
    *(f"{name}:{side}" for name in _FEET[2:] for side in _SIDES),
)
_UNEVEN_LABELS: Final = {
    "stride_length": "Stride length, left compared with right",
    "step_time": "Step time, left compared with right",
    "stance_share": "Stance, left compared with right",
}
_PREFIX: Final = "walk:"


def walk_values(session: Session, patient_id: str, exercise_id: str | None = None) -> list[SessionValue]:
    """Return the values of every analysed walk, oldest first; access was checked.

    Parameters
    ----------
    session : Session
    patient_id : str
    exercise_id : str, optional
        Only walks of this exercise.

    Returns
    -------
    list of SessionValue
        Means over the strides that count, with their spread and number; results of a walking test stand alone.
    """
    at = func.coalesce(MotionSession.started_at, MotionSession.created_at)
    wanted = (
        select(MotionSession, Result)
        .join(Result, Result.id == MotionSession.main_result_id)
        .where(
            MotionSession.patient_id == patient_id,
            MotionSession.purpose == "exercise",
            Result.pipeline == PIPELINE,
        )
        .order_by(at, MotionSession.id)
    )
    if exercise_id is not None:
        wanted = wanted.where(MotionSession.exercise_id == exercise_id)
    found = []
    for walked, result in session.execute(wanted):
        content = walk_content(session, walked)
        if content is None:
            continue
        for name, one in _chosen(content).items():
            if one.value is None:
                continue
            # Parts of one are shown in per cent.
            factor, unit = (100.0, "%") if one.unit == "1" else (1.0, one.unit)
            found.append(
                SessionValue(
                    patient_id=patient_id,
                    exercise_id=walked.exercise_id,
                    session_id=walked.id,
                    at=walked.started_at or walked.created_at,
                    measure=_PREFIX + name,
                    unit=unit,
                    mean=factor * one.value,
                    spread=None if one.spread is None else factor * one.spread,
                    count=one.count,
                    orientation=result.orientation,
                    orientation_version=result.orientation_version,
                    pipeline_version=result.pipeline_version,
                    template_version_id="",
                )
            )
    return found


def walk_label(measure: str) -> str:
    """Return what a person calls a measure of a walk: `Stride length, left`."""
    name, _, part = measure.removeprefix(_PREFIX).partition(":")
    if name == "uneven":
        return _UNEVEN_LABELS[part]
    return _LABELS[name] + (f", {part}" if part else "")


def walk_order(measure: str) -> int:
    """Return the place of a measure among those of a walk, the most telling first."""
    return _ORDER.index(measure.removeprefix(_PREFIX))


def _chosen(content: WalkContent) -> dict[str, WalkMeasure]:
    found: dict[str, WalkMeasure] = {}
    test = content.test
    if test is not None and test.kind == "timed_up_and_go":
        found["test_time"] = _single("test_time", test.time_s, "s")
    if test is not None and test.kind == "six_minute_walk":
        found["test_distance"] = _single("test_distance", test.distance_m, "metres")
    for foot in content.feet:
        found |= {f"{one.measure}:{foot.side}": one for one in foot.measures if one.measure in _FEET}
    found |= {f"uneven:{one.measure}": one for one in content.asymmetry if one.measure in _UNEVEN}
    found |= {one.measure: one for one in content.both if one.measure in _BOTH}
    if content.balance is not None:
        found |= {one.measure: one for one in content.balance.measures if one.measure in _BALANCE}
    return found


def _single(name: str, value: float, unit: str) -> WalkMeasure:
    return WalkMeasure(measure=name, value=value, sigma=None, spread=None, count=1, unit=unit)


__all__ = ["walk_label", "walk_order", "walk_values"]
