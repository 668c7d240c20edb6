"""Measured costs of a live session on many machines, and what follows from them for any number of sessions."""

from dataclasses import dataclass

SENSORS, RATE_HZ, TICKS_A_PACKET = 17, 100.0, 5


@dataclass(frozen=True)
class Costs:
    """Of one live session of 17 sensors at 100 Hz that is watched.

    Processor times and `detected_s` are measured (24 sessions, see `docs/scaling.md`); bytes, `take_s`
    and `resume_ms` are estimates.

    Attributes
    ----------
    edge_ms, broker_ms, worker_ms, database_ms : float
        Processor time a second of the session, ms.
    most_busy : float
        Share of a core up to which a part is planned.
    stream_bytes_s, raw_bytes_s, frame_bytes_s, checkpoint_bytes_s : float
        Bytes a second: into the stream, and into the database for packets, frames and checkpoints.
    view_bytes_s : float
        To one view.
    detected_s : tuple of float
        Between a worker's death and the moment its partitions are free, least and most.
    take_s : float
        To take a partition without sessions.
    resume_ms : float
        To take up one session: its checkpoint and the packets since.
    """

    edge_ms: float = 6.2
    broker_ms: float = 2.4
    worker_ms: float = 10.1
    database_ms: float = 1.0
    most_busy: float = 0.6
    stream_bytes_s: float = 31_000.0
    raw_bytes_s: float = 10_500.0
    frame_bytes_s: float = 2_500.0
    checkpoint_bytes_s: float = 27_000.0
    view_bytes_s: float = 60_000.0
    detected_s: tuple[float, float] = (0.3, 0.6)
    take_s: float = 0.1
    resume_ms: float = 30.0

    @property
    def sessions_a_worker(self) -> int:
        """Sessions that one core of a worker carries."""
        return int(1000.0 * self.most_busy / self.worker_ms)

    @property
    def sessions_an_edge(self) -> int:
        """Sessions that one core of an edge carries, each with one view."""
        return int(1000.0 * self.most_busy / self.edge_ms)


@dataclass(frozen=True)
class Plan:
    """What a number of sessions needs.

    Attributes
    ----------
    workers, edges : int
        Processes, each on a core.
    broker_cores, database_cores : float
        Busy, not installed.
    database_tb_day : float
        Of packets and frames, when every session lasts the whole day.
    """

    sessions: int
    workers: int
    edges: int
    broker_cores: float
    database_cores: float
    stream_mb_s: float
    database_mb_s: float
    view_mb_s: float
    database_tb_day: float


def plan(sessions: int, costs: Costs) -> Plan:
    """Return what so many live sessions need, each watched by one view."""
    lasting = costs.raw_bytes_s + costs.frame_bytes_s
    return Plan(
        sessions,
        -(-sessions // costs.sessions_a_worker),
        -(-sessions // costs.sessions_an_edge),
        1e-3 * sessions * costs.broker_ms,
        1e-3 * sessions * costs.database_ms,
        1e-6 * sessions * costs.stream_bytes_s,
        1e-6 * sessions * (lasting + costs.checkpoint_bytes_s),
        1e-6 * sessions * costs.view_bytes_s,
        1e-12 * 86_400.0 * sessions * lasting,
    )
