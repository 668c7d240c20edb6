"""Taking a session up again after the service was restarted: the stored packets through the same live chain.

With magnetometers the last minute is enough: orientation converges within it. Without them heading is what
was integrated since calibration, so the whole session runs again.
"""

from collections import deque

from sqlalchemy import Engine

from app.errors import PacketError
from app.ingest.alignment import Aligner
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
    tail: deque[Packet] = deque()
    is_whole = False
    for raw in read_packets_in_order(engine, session.id):
        packet = decoded(raw)
        is_whole = is_whole or not packet.channels & Channel.MAGNETOMETER
        tail.append(packet)
        if is_whole:
            while tail:
                _feed(session, tail.popleft())
        elif len(tail) > _packets_in(packet, TAIL_S):
            tail.popleft()
    if tail:
        _start_at(session, tail[0])
    for packet in tail:
        _feed(session, packet)
    session.aligner.gaps.clear()


def _packets_in(packet: Packet, duration_s: float) -> int:
    return max(1, int(duration_s * 1e6 / (packet.tick_count * packet.tick_interval_us)))


def _start_at(session: LiveSession, packet: Packet) -> None:
    """Let alignment begin at the first packet of the tail instead of filling up from tick 0."""
    first_us = packet.device_time_us + session.clock.offset_us(packet.sequence)
    session.aligner = Aligner(
        session.declaration, first_tick=max(0, round(first_us * 1e-6 * session.declaration.rate_hz))
    )


def _feed(session: LiveSession, packet: Packet) -> None:
    try:
        place = session.clock.admit(packet)
        chunk = session.aligner.push(packet, place.sequence, place.time_us)
    except PacketError:
        return
    if chunk is not None:
        session.store_frames(session.pipeline.step(chunk))
