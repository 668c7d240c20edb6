"""Everything held about a patient as one archive, made in a child process and sent while it is made.

Nothing of it is ever whole in memory or on disk, and the live sessions keep their interpreter. A reader that is slow
slows only its own child, which holds no transaction while it waits.
"""

import io
import weakref
import zipfile
from collections.abc import Iterator
from typing import Final

from sqlalchemy import Engine, func, select

from app.accounts import audit
from app.accounts.subject import Subject
from app.assessment.exports.archive import write_archive
from app.database import engine as engines
from app.database.unit_of_work import read_only
from app.limits import Hold, Limits
from app.patients.access import require_patient
from app.processes import Child, Emit
from app.recordings.models import MotionSession
from app.settings import Settings

_PIECE_BYTES: Final = 2**18


def export(
    engine: Engine, settings: Settings, limits: Limits, subject: Subject, patient_id: str
) -> Iterator[bytes]:
    """Return an archive (ZIP) of everything held about a patient, piece by piece.

    Parameters
    ----------
    settings : Settings
        How much memory the child may take.
    limits : Limits
        How many exports are made at once.
    subject : Subject
        With the level `read`: the patient, whoever has a grant, the clinic's administrators.

    Returns
    -------
    iterator of bytes
        Access was decided and audited before the first one. An archive that could not be finished breaks off, without
        the directory at its end: no program takes it for a whole one.

    Raises
    ------
    NotFound, NotAllowed
        See `app.patients.access`.
    LimitReached, Unavailable
        Too many exports are being made.
    """
    hold = limits.take("exports", subject)
    try:
        with read_only(engine) as session:
            require_patient(session, subject, patient_id, "read")
            count = session.scalar(select(func.count()).where(MotionSession.patient_id == patient_id)) or 0
            audit.record(session, subject, "patient.export", patient_id, None, {"sessions": count})
        child = Child(
            _make, settings, subject, patient_id, memory_bytes=settings.job_memory_bytes, name="export"
        )
    except BaseException:
        hold.release()
        raise
    pieces = _sent(child, hold)
    # Also when the browser has gone before the first piece.
    weakref.finalize(pieces, child.end)
    weakref.finalize(pieces, hold.release)
    return pieces


def _sent(child: Child, hold: Hold) -> Iterator[bytes]:
    with hold:
        yield from child.results()


def _make(emit: Emit, settings: Settings, subject: Subject, patient_id: str) -> None:
    engine = engines.create(settings)
    pipe = _Pieces(emit)
    with zipfile.ZipFile(pipe, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        write_archive(archive, engine, subject, patient_id, settings.time_zone)
    pipe.flush()


class _Pieces(io.RawIOBase):
    """A file that cannot go back: what is written leaves in pieces."""

    def __init__(self, emit: Emit) -> None:
        self._emit = emit
        self._waiting = bytearray()

    def writable(self) -> bool:
        """Return that it is."""
        return True

    def write(self, data: bytes) -> int:  # type: ignore[override]
        """Take some bytes."""
        self._waiting += data
        if len(self._waiting) >= _PIECE_BYTES:
            self.flush()
        return len(data)

    def flush(self) -> None:
        """Send what waits."""
        piece, self._waiting = bytes(self._waiting), bytearray()
        if piece:
            self._emit(piece)
