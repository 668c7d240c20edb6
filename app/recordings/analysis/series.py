"""Curves over time of stored results: a kind names what can be computed of its frames, one route serves them all."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import NotFound
from app.recordings import repository
from app.recordings.analysis.curve import Curve
from app.recordings.analysis.kinds import kinds
from app.recordings.points import ticks_between
from app.recordings.series_schemas import CurveOut, SeriesOut
from app.recordings.signals.store import read_frames, stored_step_s
from estimators.conventions import PLACEMENTS
from estimators.pipelines import SessionSetup
from estimators.recording import Float
from estimators.sentences import say

_PIECE_S: Final = 60.0
"""Results are read piece by piece, so that an hour needs no more memory than a minute."""


def series_of(
    session: Session,
    subject: Subject,
    session_id: str,
    names: Sequence[str],
    result_id: str | None,
    start_s: float | None,
    end_s: float | None,
    max_points: int,
) -> SeriesOut:
    """Return series of a result over the half-open session time `[start_s, end_s)`.

    Parameters
    ----------
    result_id : str, optional
        The main result by default.
    max_points : int
        Of every curve; every n-th tick is taken, least and most are of all.

    Raises
    ------
    NotFound
        No such session or result, or a series that no kind of session has.
    """
    found = repository.get_session(
        session,
        subject,
        session_id,
        action="session.series",
        details={"result": result_id or "main", "series": ",".join(sorted(set(names)))},
    )
    result = repository.result_of(session, found, result_id)
    setup = SessionSetup.from_dict(result.setup)
    known = {one.name for kind in kinds().values() for one in kind.series}
    if unknown := sorted(set(names) - known):
        raise NotFound(say("series.unknown", names=unknown, known=sorted(known)), known=sorted(known))
    own = {one.name: one for one in kinds()[setup.pipeline].series}
    reasons = {
        name: own[name].lacks(setup, result.layout) if name in own else say("series.other_kind")
        for name in dict.fromkeys(names)
    }
    wanted = [own[name] for name, reason in reasons.items() if not reason]
    step_s = stored_step_s(result)
    first, stop = ticks_between(session, result, step_s, start_s, end_s)
    stride = max(1, -(-(stop - first) // max_points))
    margin = max((round(one.margin_s / step_s) for one in wanted), default=0)
    length = max(1, round(_PIECE_S / step_s))
    times: list[float] = []
    parts: dict[tuple[str, str], _Parts] = {}
    for begin in range(first, stop if wanted else first, length):
        end = min(begin + length, stop)
        frames = read_frames(session, result.id, max(0, begin - margin) * step_s, (end + margin) * step_s)
        inside = slice(max(0, begin - frames.first_tick), end - frames.first_tick)
        shown = slice(-max(begin, frames.first_tick) % stride, None, stride)
        if not frames.tick_count or inside.start >= inside.stop:
            continue
        times += [round(float(t), 4) for t in frames.time_s[inside][shown]]
        for one in wanted:
            for curve in one.curves(frames, setup):
                parts.setdefault((one.name, curve.name), _Parts(one.name, curve)).add(curve, inside, shown)
    return SeriesOut(
        result_id=result.id,
        time_s=times,
        curves=[part.out() for part in parts.values()],
        reasons={name: reason for name, reason in reasons.items() if reason},
        unworn=[name for name in PLACEMENTS if name not in setup.placements],
    )


class _Parts:
    """One curve, piece by piece."""

    def __init__(self, series: str, curve: Curve) -> None:
        self._series, self._curve = series, curve
        self._values: list[float | None] = []
        self._sigma: list[float | None] | None = None if curve.sigma is None else []
        self._least, self._most = np.inf, -np.inf

    def add(self, curve: Curve, inside: slice, shown: slice) -> None:
        values = curve.values[inside]
        finite = np.isfinite(values)
        self._least = min(self._least, float(np.min(values, initial=np.inf, where=finite)))
        self._most = max(self._most, float(np.max(values, initial=-np.inf, where=finite)))
        self._values += _plain(values[shown])
        if self._sigma is not None and curve.sigma is not None:
            self._sigma += _plain(curve.sigma[inside][shown])

    def out(self) -> CurveOut:
        return CurveOut(
            series=self._series,
            name=self._curve.name,
            unit=self._curve.unit,
            value=self._values,
            sigma=self._sigma,
            least=_plain(np.array([self._least]))[0],
            most=_plain(np.array([self._most]))[0],
        )


def _plain(values: Float) -> list[float | None]:
    return [round(float(v), 5) if np.isfinite(v) else None for v in values]
