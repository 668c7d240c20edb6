"""Taking a session up again after the service was restarted: the stored packets through the same live chain.

With magnetometers the last minute is enough: orientation converges within it. Without them heading is what
was integrated since calibration, so the whole session runs again.
"""

from collections import deque

from sqlalchemy import Engine

from app.errors import PacketError
from app.ingest.alignment import Aligner
from app.ingest.clock import Admitted
from app.ingest.packet import Channel, Packet
from app.live.runner import LiveSession
from app.recordings.reprocess import decoded
from app.recordings.store import read_packets_in_order

TAIL_S = 60.0


def rebuild(session: LiveSession, engine: Engine) -> None:
    """Bring clock, alignment and pipeline to where the stored packets end; blocks, so call it in a thread.

    Parameters
    ----------
    session : LiveSession
        Not yet given to anybody; open at the writer.
    engine : Engine
    """
    tail: deque[tuple[Packet, Admitted]] = deque()
    is_whole = False
    for raw in read_packets_in_order(engine, session.id):
        packet = decoded(raw)
        try:
            tail.append((packet, session.clock.admit(packet)))
        except PacketError:
            continue
        is_whole = is_whole or not packet.channels & Channel.MAGNETOMETER
        if is_whole:
            while tail:
                _feed(session, *tail.popleft())
        elif tail[-1][1].time_us - tail[0][1].time_us > 1e6 * TAIL_S:
            tail.popleft()
    if tail:
        # Alignment begins at the tail instead of filling up from tick 0.
        first_tick = max(0, round(tail[0][1].time_us * 1e-6 * session.declaration.rate_hz))
        session.aligner = Aligner(session.declaration, first_tick=first_tick)
    while tail:
        _feed(session, *tail.popleft())
    session.aligner.gaps.clear()


def _feed(session: LiveSession, packet: Packet, place: Admitted) -> None:
    try:
        chunk = session.aligner.push(packet, place.sequence, place.time_us)
    except PacketError:
        return
    if chunk is not None:
        session.store_frames(session.pipeline.step(chunk))
