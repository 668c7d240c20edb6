"""Centre of mass of stored results, where sensors on trunk and legs tell it."""

from typing import Final

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.kinds.arm.mass_centre_schemas import MassCentreCurve, MassCentreOut
from app.recordings import repository
from app.recordings.points import ticks_between
from app.recordings.signals.store import read_frames
from app.sentences import say
from estimators.balance import MASS_SCALARS
from estimators.conventions import PLACEMENTS
from estimators.pipelines import ArmPipeline, SessionSetup
from estimators.recording import Float

NAMES: Final = ("ahead", "left", "height")
_PIECE_S: Final = 60.0


def mass_centre_of(
    session: Session,
    subject: Subject,
    session_id: str,
    result_id: str | None,
    start_s: float | None,
    end_s: float | None,
    max_points: int,
) -> MassCentreOut:
    """Return the centre of mass of a result over the half-open session time `[start_s, end_s)`.

    Parameters
    ----------
    session : Session
    subject : Subject
    session_id : str
    result_id : str, optional
        The main result by default.
    start_s, end_s : float, optional
    max_points : int
        Of every curve; every n-th tick is taken.

    Raises
    ------
    NotFound
        No such session or result.
    """
    found = repository.get_session(
        session, subject, session_id, action="session.mass_centre", details={"result": result_id or "main"}
    )
    result = repository.result_of(session, found, result_id)
    setup = SessionSetup.from_dict(result.setup)
    assumed = [name for name in PLACEMENTS if name not in setup.placements]
    scalars = list(result.layout["scalars"])
    if MASS_SCALARS[0] not in scalars:
        reason = (
            say("mass_centre.sensors")
            if setup.pipeline == ArmPipeline.name
            else say("mass_centre.other_kind")
        )
        return MassCentreOut(result_id=result.id, time_s=[], curves=[], assumed=[], reason=reason)
    columns = [scalars.index(name) for name in MASS_SCALARS]
    step_s = 1.0 / setup.rate_hz
    first, stop = ticks_between(session, result, step_s, start_s, end_s)
    stride, length = max(1, -(-(stop - first) // max_points)), max(1, round(_PIECE_S / step_s))
    times: list[Float] = []
    parts: list[Float] = []
    least, most = np.full(len(NAMES), np.inf), np.full(len(NAMES), -np.inf)
    for begin in range(first, stop, length):
        frames = read_frames(session, result.id, begin * step_s, min(begin + length, stop) * step_s)
        values = frames.scalar[:, columns].astype(np.float64)
        thinned = slice(-frames.first_tick % stride, None, stride)
        times.append(frames.time_s[thinned])
        parts.append(values[thinned])
        placed = values[:, : len(NAMES)]
        least = np.fmin(least, np.min(placed, axis=0, initial=np.inf, where=np.isfinite(placed)))
        most = np.fmax(most, np.max(placed, axis=0, initial=-np.inf, where=np.isfinite(placed)))
    table = np.concatenate(parts) if parts else np.empty((0, len(columns)))
    return MassCentreOut(
        result_id=result.id,
        time_s=[round(float(t), 4) for piece in times for t in piece],
        curves=[
            MassCentreCurve(
                name=name,
                value_m=_plain(table[:, i]),
                sigma_m=_plain(table[:, len(NAMES) + i]),
                least_m=_plain(least[i : i + 1])[0],
                most_m=_plain(most[i : i + 1])[0],
            )
            for i, name in enumerate(NAMES)
        ],
        assumed=assumed,
        reason="",
    )


def _plain(values: Float) -> list[float | None]:
    return [round(float(v), 5) if np.isfinite(v) else None for v in values]


__all__ = ["NAMES", "mass_centre_of"]
