"""The fused motion of markers and a sensor, read back: as CSV, as a stretch for curves, whole for the 3D view."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import InvalidInput, NotFound
from app.readers.markers.schemas import MarkerMotionOut
from app.recordings import repository
from app.recordings.markers import COLUMNS, KIND, MOTION_STREAM, sound
from app.recordings.models import Job, SignalChunk
from app.recordings.signals import codecs
from estimators.samples import Samples
from estimators.sentences import say

LONGEST_S: Final = 120.0
"""Of a stretch for curves."""
_MOST_POINTS: Final = 4000
_NONE: Final = say("markers.none")


@dataclass(frozen=True)
class Motion(Samples):
    """A stretch of fused motion.

    Attributes
    ----------
    time_s : ndarray, shape (K,)
        Session time.
    values : ndarray of float32, shape (K, len(COLUMNS))
        NaN where nothing is known.
    """

    time_s: NDArray[np.float64]
    values: NDArray[np.float32]

    def column(self, name: str) -> NDArray[np.float32]:
        """Return one of `COLUMNS`, shape (K,)."""
        return self.values[:, COLUMNS.index(name)]

    def three(self, name: str) -> NDArray[np.float32]:
        """Return x, y and z of a quantity in metres, shape (K, 3)."""
        return np.stack([self.column(f"{name}_{axis}_m") for axis in "xyz"], axis=1)


def newest(session: Session, session_id: str) -> str | None:
    """Return the identifier of the markers that were fused last; None without any."""
    arguments = session.scalar(
        select(Job.arguments)
        .where(Job.session_id == session_id, Job.kind == KIND, Job.status == "complete")
        .order_by(Job.created_at.desc(), Job.id)
        .limit(1)
    )
    return None if arguments is None else str(arguments["markers_id"])


def require(session: Session, session_id: str, markers_id: str) -> None:
    """Check that these markers have been fused.

    Raises
    ------
    NotFound
        They have not.
    """
    next(_pieces(session, session_id, markers_id, 0.0, np.inf))


def read_motion(
    session: Session, session_id: str, markers_id: str | None, from_s: float = 0.0, until_s: float = np.inf
) -> Motion:
    """Return the motion of ticks within a stretch of session time.

    Raises
    ------
    NotFound
        These markers were never fused, or have been erased.
    """
    pieces = list(_pieces(session, session_id, markers_id, from_s, until_s))
    time_s = np.concatenate([np.zeros(0), *(piece.time_s for piece in pieces)])
    values = np.concatenate([np.zeros((0, len(COLUMNS)), np.float32), *(piece.values for piece in pieces)])
    inside = (time_s >= from_s) & (time_s < until_s)
    return Motion(time_s[inside], values[inside])


def motion_csv(session: Session, subject: Subject, session_id: str, markers_id: str | None) -> Iterator[str]:
    """Return the fused motion at the rate of the sensor as lines of CSV; the newest by default.

    Raises
    ------
    NotFound
        There is none.
    """
    repository.get_session(
        session,
        subject,
        session_id,
        action="session.markers.export",
        details={"markers": markers_id or "newest"},
    )
    lines = [csv_head()]
    for piece in _pieces(session, session_id, markers_id, 0.0, np.inf):
        lines += csv_lines(piece.time_s, piece.values)
    return iter(lines)


def csv_head() -> str:
    """Return the first line of a CSV of motion."""
    return ",".join(("time_s", *COLUMNS)) + "\n"


def csv_lines(time_s: NDArray[np.float64], values: NDArray[np.float32]) -> Iterator[str]:
    """Return lines of a CSV; what is not known is empty."""
    for time, line in zip(time_s.tolist(), values.tolist(), strict=True):
        numbers = ",".join("" if value != value else f"{value:.7g}" for value in line)
        yield f"{time:.5f},{numbers}\n"


def motion_between(
    session: Session, subject: Subject, session_id: str, markers_id: str | None, from_s: float, until_s: float
) -> MarkerMotionOut:
    """Return a stretch for curves, thinned where it holds very many ticks.

    Raises
    ------
    NotFound
        There is no motion of these markers.
    InvalidInput
        The stretch is empty or too long.
    """
    if not 0.0 < until_s - from_s <= LONGEST_S:
        raise InvalidInput(say("markers.too_long", longest_s=LONGEST_S), field="until_s")
    repository.get_session(session, subject, session_id, action="session.markers")
    markers_id = markers_id or newest(session, session_id) or ""
    motion = read_motion(session, session_id, markers_id, from_s, until_s)
    motion = motion.every(1 + (len(motion.time_s) - 1) // _MOST_POINTS)
    velocity = np.stack([motion.column(f"velocity_{axis}_mps") for axis in "xyz"], axis=1)
    place, sigma, measured = (motion.three(name) for name in ("marker", "position_sigma", "measured"))
    return MarkerMotionOut(
        markers_id=markers_id,
        time_s=[round(float(t), 4) for t in motion.time_s],
        place_m=_axes(place),
        sigma_m=_axes(sigma),
        measured_m=_axes(measured),
        speed_mps=_plain(np.linalg.norm(velocity, axis=1)),
        is_gap=(motion.column("is_gap") > 0).tolist(),
    )


def _axes(values: NDArray[np.float32]) -> tuple[list[float | None], list[float | None], list[float | None]]:
    return _plain(values[:, 0]), _plain(values[:, 1]), _plain(values[:, 2])


def _plain(values: NDArray[np.float32]) -> list[float | None]:
    return [round(value, 5) if value == value else None for value in values.tolist()]


def _pieces(
    session: Session, session_id: str, markers_id: str | None, from_s: float, until_s: float
) -> Iterator[Motion]:
    stream = MOTION_STREAM + (markers_id or newest(session, session_id) or "")
    known = session.execute(
        select(SignalChunk.sequence, SignalChunk.ticks, SignalChunk.scale)
        .where(SignalChunk.session_id == session_id, SignalChunk.stream == stream)
        .order_by(SignalChunk.sequence)
    ).all()
    if not known:
        raise NotFound(_NONE)
    for sequence, ticks, scale in known:
        first, step = int(scale["first_tick"]), float(scale["time_step_s"])
        if (first + ticks) * step <= from_s or first * step >= until_s:
            continue
        row = session.get_one(SignalChunk, (session_id, stream, sequence))
        names = list(scale["columns"])
        stored = codecs.decode_floats(sound(row), ticks, len(names))
        values = np.full((ticks, len(COLUMNS)), np.nan, dtype=np.float32)
        # An earlier version stored fewer columns.
        for column, name in enumerate(COLUMNS):
            if name in names:
                values[:, column] = stored[:, names.index(name)]
        yield Motion((first + np.arange(ticks)) * step, values)
