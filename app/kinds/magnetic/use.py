"""Use of the source in a stored session: its pulses, its energy account, and the accuracy that it bought."""

from typing import Final

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import Conflict
from app.kinds.magnetic.safety import PIPELINE
from app.kinds.magnetic.schemas import SourceUseOut
from app.recordings import repository
from app.recordings.signals.store import read_frames
from estimators.magnetic import RelativeFlag
from estimators.pipelines import Frames
from estimators.recording import Float
from estimators.sentences import say

MAX_PULSES: Final = 5000
CURVE_POINTS: Final = 600


def source_use(session: Session, subject: Subject, session_id: str, result_id: str | None) -> SourceUseOut:
    """Return the use of the source in a result, by default the main one.

    Raises
    ------
    Conflict
        The session has no magnetic source.
    NotFound
        Nothing is estimated yet.
    """
    found = repository.get_session(session, subject, session_id, action="session.source_use")
    if found.setup["pipeline"] != PIPELINE:
        raise Conflict(say("magnetic.no_source"))
    result = repository.result_of(session, found, result_id)
    if result.pipeline != PIPELINE:
        raise Conflict(say("magnetic.result_of_walk"))
    return use_of(result.id, read_frames(session, result.id))


def use_of(result_id: str, frames: Frames) -> SourceUseOut:
    """Find the pulses in frames and their sums."""
    step_s, time_s = frames.time_step_s, frames.time_s
    coil = np.nan_to_num(_column(frames, "source_coil")).astype(np.int64)
    current = np.nan_to_num(_column(frames, "source_current_a"))
    edge = np.flatnonzero(np.diff(np.concatenate([[0], coil])) != 0)
    starts = edge[coil[edge] > 0]
    ends = np.append(edge, len(coil))[np.searchsorted(edge, starts) + 1]
    shown = slice(max(0, len(starts) - MAX_PULSES), None)
    thin = max(1, -(-frames.tick_count // CURVE_POINTS))
    sensors = frames.layout.segments[1:]
    on = coil > 0
    state = {name: np.nan_to_num(_column(frames, f"{name}_state"), nan=1.0).astype(int) for name in sensors}
    return SourceUseOut(
        result_id=result_id,
        duration_s=frames.tick_count * step_s,
        pulse_count=len(starts),
        on_time_s=float(on.sum() * step_s),
        charge_as=float(np.abs(current[on]).sum() * step_s),
        current_squared_a2s=float((current[on] ** 2).sum() * step_s),
        asked_count=int((np.nan_to_num(_column(frames, "source_ask_coil")) > 0).sum()),
        start_s=_rounded(time_s[starts[shown]]),
        length_s=_rounded(np.asarray((ends - starts)[shown] * step_s, dtype=np.float64)),
        coil=coil[starts[shown]].tolist(),
        current_a=_rounded(current[starts[shown]]),
        time_s=_rounded(time_s[::thin]),
        charge_curve_as=_rounded(np.nan_to_num(_column(frames, "source_charge_as"))[::thin]),
        sigma_m={name: _known(_column(frames, f"{name}_distance_sigma_m")[::thin]) for name in sensors},
        distance_m={name: _known(_column(frames, f"{name}_distance_m")[::thin]) for name in sensors},
        # A flag that is up for a moment must not fall between two points.
        state={
            name: np.bitwise_or.reduceat(bits, np.arange(0, len(bits), thin)).tolist() if len(bits) else []
            for name, bits in state.items()
        },
        inertial_only_s={
            name: round(float(((bits & _ALONE) == int(RelativeFlag.INERTIAL_ONLY)).sum() * step_s), 3)
            for name, bits in state.items()
        },
    )


_ALONE: Final = int(RelativeFlag.INERTIAL_ONLY | RelativeFlag.CALIBRATING | RelativeFlag.INVALID)


def _column(frames: Frames, name: str) -> Float:
    return frames.scalar[:, frames.layout.scalars.index(name)]


def _rounded(values: Float) -> list[float]:
    return [round(float(value), 4) for value in values]


def _known(values: Float) -> list[float | None]:
    return [round(float(value), 5) if np.isfinite(value) else None for value in values]
