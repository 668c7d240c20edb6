"""How far two results of one session are apart: RMS, greatest difference and curves of every joint angle."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import Conflict
from app.recordings import repository, service
from app.recordings.models import Result
from app.recordings.points import result_ticks
from app.recordings.schemas import AngleDifference, CurvePair, DifferencesOut
from app.recordings.signals.chunks import layout_from_dict
from app.recordings.signals.store import read_frames, stored_step_s
from estimators import rotation
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames
from estimators.recording import Float
from estimators.sentences import say

PIECE_S: Final = 60.0
"""Results are read piece by piece, so that an hour needs no more memory than a minute."""
MAX_CURVE_POINTS: Final = 2000
_LEFT_OUT: Final = np.uint8(OrientationFlag.INVALID | OrientationFlag.SINGULAR | OrientationFlag.CONVERGING)


def differences(
    session: Session, subject: Subject, session_id: str, result_a: str, result_b: str, max_points: int
) -> DifferencesOut:
    """Compare two results of a session tick by tick, of the ticks that both keep.

    Parameters
    ----------
    max_points : int
        Of every curve; every n-th tick is taken.

    Returns
    -------
    DifferencesOut
        RMS and greatest difference over the ticks in which both results stand for the column: not in gaps, while
        starting, or near a singular position.

    Raises
    ------
    NotFound
        No such session or result.
    Conflict
        A result is not finished.
    """
    found = repository.get_session(
        session,
        subject,
        session_id,
        action="session.differences",
        details={"result_a": result_a, "result_b": result_b},
    )
    first, second = (repository.result_of(session, found, name) for name in (result_a, result_b))
    for result in (first, second):
        if result.status != "complete":
            raise Conflict(say("result.not_complete"), result=result.id)
    return _compare(session, first, second, max_points)


def _compare(session: Session, first: Result, second: Result, max_points: int) -> DifferencesOut:
    layouts = [layout_from_dict(result.layout) for result in (first, second)]
    angles = _shared(layouts[0].angles, layouts[1].angles)
    segments = _shared(layouts[0].segments, layouts[1].segments)
    step_s = max(stored_step_s(result) for result in (first, second))
    rate_hz = 1.0 / step_s
    end_s = max(result_ticks(session, one) * stored_step_s(one) for one in (first, second))
    ticks = max(1, round(end_s * rate_hz))
    stride = max(1, -(-ticks // max_points))
    sums = {name: _Sum() for name in (*angles, *segments)}
    times: list[float] = []
    curves: dict[str, tuple[list[float | None], list[float | None]]] = {name: ([], []) for name in angles}
    for start_s in np.arange(0.0, ticks / rate_hz, PIECE_S):
        pair = [read_frames(session, r.id, float(start_s), float(start_s) + PIECE_S) for r in (first, second)]
        one, other = _together(*(frames.every(round(step_s / frames.time_step_s)) for frames in pair))
        if not one.tick_count:
            continue
        for name in angles:
            a, b, counts = _angle(one, other, name)
            # Unwrapped curves may differ by whole turns.
            apart = np.remainder(a - b + np.pi, 2.0 * np.pi) - np.pi
            sums[name].add(np.where(counts, apart, np.nan), one.time_s)
            for values, curve in ((b + apart, curves[name][0]), (b, curves[name][1])):
                shown = np.degrees(values[-one.first_tick % stride :: stride])
                curve += [round(float(v), 3) if np.isfinite(v) else None for v in shown]
        for name in segments:
            i, j = one.layout.segments.index(name), other.layout.segments.index(name)
            sound = ((one.segment_flags[:, i] | other.segment_flags[:, j]) & _LEFT_OUT) == 0
            turned = rotation.angle_between(one.q_room_segment[:, i], other.q_room_segment[:, j])
            sums[name].add(np.where(sound, turned, np.nan), one.time_s)
        times += [float(t) for t in one.time_s[-one.first_tick % stride :: stride]]
    return DifferencesOut(
        result_a=service.result_out(first),
        result_b=service.result_out(second),
        angles=[sums[name].out(name, rate_hz) for name in angles],
        segments=[sums[name].out(name, rate_hz) for name in segments],
        time_s=times,
        curves=[CurvePair(name=name, a_deg=a, b_deg=b) for name, (a, b) in curves.items()],
    )


@dataclass
class _Sum:
    """What is stored of the differences of one column."""

    count: int = 0
    total: float = 0.0
    squares: float = 0.0
    largest: float = 0.0
    largest_at_s: float | None = field(default=None)

    def add(self, apart: Float, time_s: Float) -> None:
        finite = np.isfinite(apart)
        if not finite.any():
            return
        self.count += int(finite.sum())
        self.total += float(apart[finite].sum())
        self.squares += float(np.square(apart[finite]).sum())
        worst = int(np.nanargmax(np.abs(apart)))
        if abs(apart[worst]) > self.largest or self.largest_at_s is None:
            self.largest, self.largest_at_s = float(abs(apart[worst])), float(time_s[worst])

    def out(self, name: str, rate_hz: float) -> AngleDifference:
        known = self.count > 0
        return AngleDifference(
            name=name,
            rms_deg=float(np.degrees(np.sqrt(self.squares / self.count))) if known else None,
            mean_deg=float(np.degrees(self.total / self.count)) if known else None,
            maximum_deg=float(np.degrees(self.largest)) if known else None,
            maximum_at_s=self.largest_at_s,
            compared_s=self.count / rate_hz,
        )


def _together(one: Frames, other: Frames) -> tuple[Frames, Frames]:
    """Cut both to the ticks that both have."""
    first = max(one.first_tick, other.first_tick)
    stop = min(one.first_tick + one.tick_count, other.first_tick + other.tick_count)
    return _cut(one, first, stop), _cut(other, first, stop)


def _cut(frames: Frames, first: int, stop: int) -> Frames:
    return frames.ticks(first - frames.first_tick, max(first, stop) - frames.first_tick)


def _angle(one: Frames, other: Frames, name: str) -> tuple[Float, Float, NDArray[np.bool_]]:
    i, j = one.layout.angles.index(name), other.layout.angles.index(name)
    sound = ((one.angle_flags[:, i] | other.angle_flags[:, j]) & _LEFT_OUT) == 0
    return one.angle_rad[:, i], other.angle_rad[:, j], np.asarray(sound)


def _shared(first: Sequence[str], second: Sequence[str]) -> list[str]:
    return [name for name in first if name in second]
