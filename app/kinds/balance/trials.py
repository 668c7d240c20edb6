"""The trials of a balance test: from the marks of its time line and the stored frames to measures."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType
from typing import Final, cast

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import Conflict, InvalidInput
from app.kinds.balance.schemas import (
    BalanceMeasure,
    BalanceTestOut,
    Condition,
    EllipseOut,
    RombergOut,
    TrialOut,
)
from app.recordings import repository
from app.recordings.models import MotionSession, Result
from app.recordings.service import result_out
from app.recordings.signals.store import read_frames
from estimators.balance.sway import (
    SHORTEST_S,
    SwayMeasure,
    Trial,
    reach,
    romberg_ratio,
    sway_acceleration,
    sway_ellipse,
    sway_measures,
)
from estimators.errors import ShapeError
from estimators.pipelines import (
    TRUNK,
    BalancePipeline,
    Frames,
    SessionSetup,
    hips_above_ankles_m,
    sway_columns,
    trunk_above_ankles_m,
)
from estimators.recording import Float
from estimators.sentences import say

CONDITIONS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "eyes_open_firm": say("balance.eyes_open_firm"),
        "eyes_closed_firm": say("balance.eyes_closed_firm"),
        "eyes_open_foam": say("balance.eyes_open_foam"),
        "eyes_closed_foam": say("balance.eyes_closed_foam"),
        "reach": say("balance.reach"),
    }
)
"""Labels of the marks that begin a trial, and what the time line says."""
REST: Final = "rest"
"""The label of the mark that ends one."""
_UNMARKED: Final = "unmarked"
_REACH: Final = "reach"
_SHOWN_HZ: Final = 20.0
_RATIOS: Final = ("sway_speed", "ellipse_area", "acceleration_rms")


@dataclass(frozen=True)
class _Sensor:
    """Which columns of the frames the numbers are of, and how high it and the shown point are above the ankles."""

    placement: str
    segment: int
    columns: tuple[int, ...]
    rate_hz: float
    height_m: float
    point_m: float


def balance_of(
    session: Session, subject: Subject, session_id: str, result_id: str | None, placement: str | None
) -> BalanceTestOut:
    """Return the trials of a balance test with their measures.

    Parameters
    ----------
    result_id : str, optional
        The main result by default.
    placement : str, optional
        The sensor; the pelvis by default, where one was worn.

    Raises
    ------
    NotFound
        No such session or result.
    Conflict
        It is no balance test.
    InvalidInput
        No such sensor was worn.
    """
    found = repository.get_session(
        session, subject, session_id, action="session.balance", details={"result": result_id or "main"}
    )
    if found.setup["pipeline"] != BalancePipeline.name:
        raise Conflict(say("balance.no_test"))
    result = repository.result_of(session, found, result_id)
    sensor = _sensor(SessionSetup.from_dict(result.setup), result, placement)
    spans = spans_of(session, found)
    trials: list[TrialOut] = []
    stances: dict[str, dict[str, SwayMeasure]] = {}
    for condition, start_s, end_s in spans:
        frames = read_frames(session, result.id, start_s, end_s)
        trial, measures = _evaluated(frames, sensor, condition, start_s, end_s)
        trials.append(trial)
        if measures:
            stances[condition] = measures
    return BalanceTestOut(
        session_id=session_id,
        result=result_out(result),
        placement=sensor.placement,
        height_m=sensor.point_m,
        trials=trials,
        romberg=_ratios(stances),
        reasons=[
            say("balance.one_link", height_m=sensor.point_m),
            *([say("balance.nothing_marked")] if [one[0] for one in spans] == [_UNMARKED] else []),
        ],
    )


def spans_of(session: Session, found: MotionSession) -> list[tuple[Condition, float, float]]:
    """Return condition, begin and end of each trial: from a mark to the next, or to the end of the recording.

    Parameters
    ----------
    found : MotionSession
        Of which access was checked. Without marks its whole recording is one trial. What was marked before Record was
        pressed begins there, or is no trial where it had ended by then; the same for Stop.
    """
    start_s, stop_s = found.recorded_s or (0.0, float("inf"))
    end_s = found.duration_s if found.recording_end_s is None else stop_s
    events = repository.events_of(session, found.id)
    marks = sorted(
        (event.time_s, str(event.details["label"]))
        for event in events
        if event.kind == "mark" and event.details.get("label") in {*CONDITIONS, REST}
    )
    if not marks:
        return [(_UNMARKED, start_s, end_s)]
    ends = [at for at, _ in marks[1:]] + [max(end_s, marks[-1][0])]
    trials = [
        (cast(Condition, label), max(at, start_s), min(end, stop_s))
        for (at, label), end in zip(marks, ends, strict=True)
        if label != REST
    ]
    return [one for one in trials if one[2] > one[1] or found.recorded_s is None]


def _sensor(setup: SessionSetup, result: Result, wanted: str | None) -> _Sensor:
    worn = [name for name in TRUNK if name in setup.placements]
    if wanted is not None and wanted not in worn:
        raise InvalidInput(say("session.no_sensor", places=[wanted]), field="placement")
    placement = wanted or worn[0]
    scalars = list(result.layout["scalars"])
    columns = tuple(scalars.index(name) for name in sway_columns(placement))
    return _Sensor(
        placement,
        list(result.layout["segments"]).index(placement),
        columns,
        setup.rate_hz,
        trunk_above_ankles_m(placement, setup.body),
        hips_above_ankles_m(setup.body),
    )


def _evaluated(
    frames: Frames, sensor: _Sensor, condition: Condition, start_s: float, end_s: float
) -> tuple[TrialOut, dict[str, SwayMeasure]]:
    """Return a trial as clients see it, and its measures of sway."""
    values, sigma = _longest(frames, sensor)
    lean, acceleration, rate = values[:, 0:2], values[:, 2:4], values[:, 4:6]
    path, ellipse, measures = np.empty((0, 2)), None, {}
    try:
        if condition == _REACH:
            # A reach is of the sensor's own place: a chest moves further than the hips.
            reached = reach(lean[:, 0], sigma, sensor.rate_hz, sensor.height_m)
            shown = {"reach_lean": reached.lean, "reach_displacement": reached.displacement}
        else:
            trial = Trial(
                sway_acceleration(lean, acceleration), rate, sensor.rate_hz, sensor.height_m, sensor.point_m
            )
            shown = measures = sway_measures(trial)
            path, ellipse = trial.shown_m, EllipseOut(**asdict(sway_ellipse(trial)))
    except ShapeError:
        shown = {}
    thin = max(1, round(sensor.rate_hz / _SHOWN_HZ))
    out = TrialOut(
        condition=condition,
        start_s=start_s,
        end_s=end_s,
        measures=[_measure(name, one) for name, one in shown.items()],
        path_m=[[round(float(x), 5), round(float(y), 5)] for x, y in path[::thin]],
        ellipse=ellipse,
        reason=""
        if shown
        else say("balance.too_short", shortest_s=2.0 if condition == _REACH else SHORTEST_S),
    )
    return out, measures


def _longest(frames: Frames, sensor: _Sensor) -> tuple[Float, Float]:
    """Return the columns (N, 6) of the longest stretch without a gap, and the sigma of the lean (N,), rad."""
    values = frames.scalar[:, sensor.columns].astype(np.float64)
    sound = np.concatenate([[False], np.isfinite(values).all(axis=1), [False]])
    edges = np.flatnonzero(np.diff(sound.astype(np.int8)))
    if not len(edges):
        return np.empty((0, 6)), np.empty(0)
    best = int(np.argmax(edges[1::2] - edges[::2]))
    inside = slice(int(edges[2 * best]), int(edges[2 * best + 1]))
    known = frames.segment_sigma_rad
    sigma = np.full(len(values), np.nan) if known is None else known[:, sensor.segment, :2].max(axis=1)
    return values[inside], np.asarray(sigma[inside], dtype=np.float64)


def _ratios(stances: Mapping[str, Mapping[str, SwayMeasure]]) -> list[RombergOut]:
    found = []
    for surface in ("firm", "foam"):
        closed, opened = stances.get(f"eyes_closed_{surface}"), stances.get(f"eyes_open_{surface}")
        if closed is not None and opened is not None:
            ratios = [_measure(name, romberg_ratio(closed[name], opened[name])) for name in _RATIOS]
            found.append(RombergOut(surface="firm" if surface == "firm" else "foam", measures=ratios))
    return found


def _measure(name: str, one: SwayMeasure) -> BalanceMeasure:
    return BalanceMeasure(measure=name, value=_plain(one.value), sigma=_plain(one.sigma), unit=one.unit)


def _plain(value: float) -> float | None:
    return float(f"{value:.5g}") if math.isfinite(value) else None
