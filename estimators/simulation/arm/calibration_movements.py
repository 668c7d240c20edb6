"""The movements of a functional calibration, active or passive, as an exercise of one repetition."""

from typing import Final

from estimators.errors import SetupError
from estimators.simulation.arm.exercises import Exercise, Stop
from estimators.simulation.arm.movements import MovementStyle, Schedule

CALIBRATION_STYLE: Final = MovementStyle(amplitude_sd=0.0, duration_sd=0.0)
"""Timing exactly as planned, so that `calibration_ranges_s` holds; posture still varies."""
_HOLD_S: Final = 0.4


def calibration_exercise(*, passive: bool = False, cycles: int = 3) -> Exercise:
    """Return bending the elbow, turning the forearm, raising the arm forward and sideways, in this order.

    Parameters
    ----------
    passive : bool
        Seated, moved by someone else: the forearm rests bent, movements are half as large and slower.
    cycles : int
        Of each movement.
    """
    return _plan(passive, cycles)[0]


def calibration_ranges_s(
    schedule: Schedule, *, passive: bool = False, cycles: int = 3
) -> dict[str, tuple[float, float]]:
    """Return when each movement happens, and `rest`, in seconds of a session with `CALIBRATION_STYLE`.

    Parameters
    ----------
    schedule : Schedule
        Of the session.
    passive : bool
        As for `calibration_exercise`; the rest is then the seated one, not the N-pose.

    Returns
    -------
    dict of str to (float, float)
        `rest`, `elbow_flexion`, `pronation`, `raise_forward`, `raise_sideways`.
    """
    if schedule.repetitions != 1:
        raise SetupError(f"{schedule}: calibration movements are one repetition")
    begin = schedule.n_pose_s + schedule.transition_s + schedule.settle_s + schedule.pause_s
    found = {"rest": (1.0, schedule.n_pose_s)}
    if passive:
        found["rest"] = (schedule.n_pose_s + schedule.transition_s, begin)
    for name, start, stop in _plan(passive, cycles)[1]:
        found[name] = (begin + start, begin + stop)
    return found


def t_pose_exercise() -> Exercise:
    """Return stretching both arms out to the sides, palms down, and holding them for eight seconds."""
    rest = {"plane": 0.0, "elevation": 2.0, "axial": 0.0, "flexion": 3.0, "pronation": 90.0}
    level = {"plane": 0.0, "elevation": 90.0, "axial": 0.0, "flexion": 0.0, "pronation": 90.0}
    stops = (Stop(level, 2.0, 8.0),)
    return Exercise("t pose", "T-pose", rest, stops, 2.0, "thorax_humerus_{side}_yxy_elevation")


def _plan(passive: bool, cycles: int) -> tuple[Exercise, list[tuple[str, float, float]]]:
    rest = {"plane": 0.0, "elevation": 2.0, "axial": 0.0, "flexion": 3.0, "pronation": 90.0}
    bend, turn_in, turn_out, raised, pace = 125.0, 155.0, 25.0, 95.0, 1.3
    if passive:
        rest |= {"elevation": 10.0, "flexion": 75.0}
        bend, turn_in, turn_out, raised, pace = 115.0, 125.0, 55.0, 45.0, 1.8
    stops: list[Stop] = []
    ranges: list[tuple[str, float, float]] = []
    now = 0.0

    def go(posture: dict[str, float], seconds: float, hold_s: float = _HOLD_S) -> None:
        nonlocal now
        stops.append(Stop(posture, seconds, hold_s))
        now += seconds + hold_s

    straight = rest | {"flexion": 30.0} if passive else rest
    if passive:
        go(straight, pace)
    begin = now
    for _ in range(cycles):
        go(rest | {"flexion": bend}, pace)
        go(straight, pace)
    ranges.append(("elbow_flexion", begin, now))
    elbow = rest | {"flexion": 75.0 if passive else 90.0}
    go(elbow, pace)
    begin = now
    for _ in range(cycles):
        go(elbow | {"pronation": turn_in}, pace)
        go(elbow | {"pronation": turn_out}, pace)
    go(elbow, pace)
    ranges.append(("pronation", begin, now))
    go(rest, pace)
    for name, plane in (("raise_forward", 90.0), ("raise_sideways", 0.0)):
        # Changing the plane of a hanging arm with the opposite axial rotation is no movement.
        low = rest | {"plane": plane, "axial": -plane}
        go(low | {"elevation": rest["elevation"]}, 1.0)
        begin = now
        for _ in range(cycles):
            go(low | {"elevation": raised}, 1.3 * pace)
            go(low, 1.3 * pace)
        ranges.append((name, begin, now))
    go(rest, 1.0)
    name = "passive calibration" if passive else "calibration"
    title = "Calibration movements"
    return (
        Exercise(name, title, rest, tuple(stops), pace, "humerus_forearm_{side}_zxy_flexion"),
        ranges,
    )
