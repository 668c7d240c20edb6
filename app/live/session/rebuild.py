"""Taking a session up again after the service was restarted: the stored packets through the same live chain.

It goes on from its checkpoint, with the bits of one that was never interrupted. Where there is none that fits, and the
session has magnetometers, the last minute is enough: orientation converges within it, and of the packets before it only
so many are looked at as tell how the device's clock has run. Without them heading is what was integrated since
calibration, so the whole session runs again; so does one that moves to another machine while somebody watches, because
no bit may differ. Clip levels that the check of the session found are in force again from the packets on from which
they were.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence

from sqlalchemy import Engine

from app.errors import PacketError
from app.live.session.checkpoint import resume
from app.live.session.runner import LiveSession
from app.network.alignment import Aligner
from app.network.clock import Admitted, PacketClock
from app.network.packet import Packet
from app.network.raw_packet import RawPacket
from app.recordings.analysis.offline import decoded
from app.recordings.signals.checkpoints import Checkpoint
from app.recordings.signals.chunks import EncodedChunk
from app.recordings.signals.store import packets_in_order, read_before_ending, read_packets_in_order
from estimators.channels import Channel
from estimators.recording import ImuChunk

TAIL_S = 60.0
PIECE_TICKS = 250


def rebuild(
    session: LiveSession,
    engine: Engine,
    checkpoint: Checkpoint | None = None,
    chunks: Sequence[EncodedChunk] | None = None,
    *,
    is_exact: bool = False,
    until: Callable[[int], bool] | None = None,
) -> Exception | None:
    """Bring clock, alignment and pipeline to where the stored packets end; blocks, so call it in a thread.

    Parameters
    ----------
    session : LiveSession
        Not yet given to anybody; open at the writer.
    checkpoint : Checkpoint, optional
        Where the session stood; one that does not fit is left.
    chunks : sequence of EncodedChunk, optional
        Those that have packets behind the checkpoint, where they were read already.
    is_exact : bool
        Begin with the first packet where there is no checkpoint, also when the last minute would do.
    until : callable(sequence), optional
        Whether no more is to be taken from this packet on. No clip levels may be known that come into force from there
        on.

    Returns
    -------
    Exception or None
        Why the estimation cannot go on, for `EstimationLine.stop` on the event loop; storing can.
    """
    tail: deque[tuple[Packet, Admitted]] = deque()
    is_resumed = resume(session, checkpoint)
    first = checkpoint.sequence if is_resumed and checkpoint is not None else 0
    is_whole = is_exact or is_resumed or not session.pipeline.begins_anywhere
    again = _Again(session)
    try:
        if not is_whole:
            ticks = math.ceil((TAIL_S + 1.0) * session.declaration.rate_hz)
            first, before = read_before_ending(engine, session.id, ticks, Channel.MAGNETOMETER)
            if None in [_admitted(session, head) for head in before]:
                # With a long hole within a chunk its ends do not say how the clock ran.
                session.now.clock, first = PacketClock(session.now.clock.declaration), 0
        raws = (
            packets_in_order(chunks, first)
            if is_resumed and chunks is not None
            else read_packets_in_order(engine, session.id, first)
        )
        for raw in raws:
            if until is not None and until(raw.sequence):
                break
            packet = decoded(raw)
            place = _admitted(session, packet)
            if place is None:
                continue
            tail.append((packet, place))
            is_whole = is_whole or not packet.channels & Channel.MAGNETOMETER
            if is_whole:
                while tail:
                    again.feed(*tail.popleft())
            elif tail[-1][1].time_us - tail[0][1].time_us > 1e6 * TAIL_S:
                tail.popleft()
        if tail:
            # Alignment begins at the tail instead of filling up from tick 0.
            first_tick = max(0, round(tail[0][1].time_us * 1e-6 * session.declaration.rate_hz))
            session.aligner = Aligner(session.declaration, first_tick=first_tick)
        while tail:
            again.feed(*tail.popleft())
        again.finish()
    except StoppedError as failure:
        return failure.error
    session.aligner.gaps.clear()
    return None


class StoppedError(Exception):
    """The pipeline raised; carries the error out of the loop over the packets."""

    def __init__(self, error: Exception) -> None:
        super().__init__(str(error))
        self.error = error


def _admitted(session: LiveSession, packet: Packet | RawPacket) -> Admitted | None:
    try:
        return session.clock.admit(packet)
    except PacketError:
        return None


class _Again:
    """Gives a session's packets to its pipeline once more, some hundred ticks at a time: any pieces give the same."""

    def __init__(self, session: LiveSession) -> None:
        self._session = session
        self._clips = deque(session.declaration.found_clips)
        self._pieces: list[ImuChunk] = []
        self._ticks = 0

    def feed(self, packet: Packet, place: Admitted) -> None:
        """Take the next packet."""
        self._put_in_force(place.sequence)
        try:
            self._take(self._session.aligner.push(packet, place.sequence, place.time_us))
        except PacketError:
            return

    def finish(self) -> None:
        """Estimate what is left."""
        # Found after the last packet that was stored.
        self._put_in_force(None)
        self._step()

    def _put_in_force(self, sequence: int | None) -> None:
        """Put the clip levels in force that were when this packet was unpacked; all with None."""
        clips = self._clips
        if clips and (sequence is None or clips[0].first_sequence <= sequence):
            # What came before them was unpacked without them.
            self._take(self._session.aligner.drain())
        while clips and (sequence is None or clips[0].first_sequence <= sequence):
            clips.popleft().write(self._session.aligner.clip_levels)

    def _take(self, chunk: ImuChunk | None) -> None:
        if chunk is None:
            return
        self._pieces.append(chunk)
        self._ticks += chunk.tick_count
        self._session.rebuilt_ticks += chunk.tick_count
        if self._ticks >= PIECE_TICKS:
            self._step()

    def _step(self) -> None:
        if not self._pieces:
            return
        chunk, self._pieces, self._ticks = ImuChunk.join(self._pieces), [], 0
        try:
            frames = self._session.pipeline.step(chunk)
        except Exception as error:
            raise StoppedError(error) from error
        self._session.store_frames(frames)
