"""Placement and failover of any number of sessions, computed with the measured costs.

Sessions fall into partitions, and partitions to workers, by the rules of the service itself (`partition_of`,
`share_of`). When a worker dies, each of the others takes what its share lets it take; its one core first brings the
sessions to where their packets end, side by side with those that it has, and then works off what came meanwhile.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.scaled.capacity.costs import Costs
from app.scaled.placement import share_of
from app.scaled.wire import partition_of


@dataclass(frozen=True)
class Placement:
    """Which worker has which sessions.

    Attributes
    ----------
    sessions_of_partition : ndarray, shape (partitions,)
    worker_of_partition : ndarray, shape (partitions,)
    """

    sessions_of_partition: NDArray[np.int64]
    worker_of_partition: NDArray[np.int64]

    def busy(self, workers: int, costs: Costs) -> NDArray[np.float64]:
        """Return the share of a core that each worker uses, shape (workers,)."""
        found = np.zeros(workers)
        np.add.at(found, self.worker_of_partition, 1e-3 * costs.worker_ms * self.sessions_of_partition)
        return found


@dataclass(frozen=True)
class Failover:
    """What the death of one worker does to its sessions.

    Attributes
    ----------
    shown_s : ndarray, shape (sessions,)
        From the death to the next frame of each of its sessions.
    level_s : float
        Until the last worker that took something has worked off what came meanwhile; infinite when it never does.
    busiest : float
        Share of a core that the busiest worker uses afterwards.
    """

    shown_s: NDArray[np.float64]
    level_s: float
    busiest: float


def place(sessions: int, partitions: int, workers: int) -> Placement:
    """Return where sessions are live when every worker has its share."""
    numbers = [partition_of(f"session-{number}", partitions) for number in range(sessions)]
    shares = [share_of(rank, workers, partitions)[1] for rank in range(workers)]
    return Placement(np.bincount(numbers, minlength=partitions), np.repeat(np.arange(workers), shares))


def fail(
    placement: Placement, workers: int, dead: int, costs: Costs, generator: np.random.Generator
) -> Failover:
    """Let one worker die.

    Parameters
    ----------
    workers : int
        Before its death, at least two.
    generator : Generator
        Draws how soon the death is noticed.
    """
    partitions = placement.worker_of_partition.size
    held = np.bincount(placement.worker_of_partition, minlength=workers)
    busy = placement.busy(workers, costs)
    detected_s = generator.uniform(*costs.detected_s)
    taken: dict[int, list[int]] = {}
    others = [one for one in range(workers) if one != dead]
    short = {
        one: share_of(rank, workers - 1, partitions)[1] - int(held[one]) for rank, one in enumerate(others)
    }
    takers = [one for one in others for _ in range(short[one])]
    for partition, taker in zip(
        np.flatnonzero(placement.worker_of_partition == dead), generator.permutation(takers), strict=True
    ):
        taken.setdefault(int(taker), []).append(int(partition))
    shown: list[float] = []
    level_s = busiest = 0.0
    for taker, own in taken.items():
        added = int(placement.sessions_of_partition[own].sum())
        spare = max(1e-9, 1.0 - busy[taker])
        work_s = len(own) * costs.take_s + 1e-3 * costs.resume_ms * added
        # Partitions of a worker are taken side by side: their sessions come back evenly until the last one.
        shown += [detected_s + costs.take_s + work_s / spare * (n + 1) / max(1, added) for n in range(added)]
        back_s = detected_s + work_s / spare
        more = 1e-3 * costs.worker_ms * added
        busy[taker] += more
        left = 1.0 - busy[taker]
        level_s = max(level_s, back_s + (more * back_s / left if left > 0.0 else math.inf))
        busiest = max(busiest, float(busy[taker]))
    return Failover(np.array(shown), level_s, busiest)
