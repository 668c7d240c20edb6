"""The stored part of a session that has streamed and moves to another machine."""

from collections.abc import Sequence
from dataclasses import dataclass

from app.live.guidance.resume_state import ResumeState
from app.live.repository import StoredSession
from app.recordings.signals.checkpoints import Checkpoint
from app.recordings.signals.chunks import EncodedChunk
from app.recordings.signals.store import Standing


@dataclass(frozen=True)
class Streamed:
    """All that is read to take a session up, read together with that of others; nobody else writes it meanwhile.

    Attributes
    ----------
    stored : StoredSession
        It has a hello and a live result.
    result_id : str
        The live result.
    first_unstored_tick : int
        Of its frames.
    chunks : sequence of EncodedChunk or None
        Those that have packets behind the checkpoint; nothing without one. None where they are still to be read.
    guided : ResumeState
        Where its guidance stood.
    is_prescribed : bool
        Whether it has a prescription, whose guidance is to be read.
    """

    stored: StoredSession
    result_id: str
    first_unstored_tick: int
    standing: Standing
    checkpoint: Checkpoint | None
    chunks: Sequence[EncodedChunk] | None
    guided: ResumeState
    is_prescribed: bool
