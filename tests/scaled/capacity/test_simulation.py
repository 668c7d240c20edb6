"""Placement and failover on paper obey the rules of the service itself."""

import numpy as np
import pytest

from app.scaled.capacity.costs import Costs, plan
from app.scaled.capacity.simulation import fail, place

COSTS = Costs(worker_ms=6.0, take_s=0.1, resume_ms=20.0, detected_s=(0.3, 0.3))


def test_every_session_has_one_place_and_no_worker_more_than_its_share() -> None:
    placement = place(10_000, 512, 100)
    assert placement.sessions_of_partition.sum() == 10_000
    held = np.bincount(placement.worker_of_partition, minlength=100)
    assert held.sum() == 512
    assert held.max() <= 6


def test_the_sessions_of_a_dead_worker_and_only_those_come_back_elsewhere() -> None:
    placement = place(10_000, 512, 100)
    lost = int(placement.sessions_of_partition[placement.worker_of_partition == 7].sum())
    found = fail(placement, 100, 7, COSTS, np.random.default_rng(0))
    assert found.shown_s.size == lost
    # Noticed, and the one partition taken: nobody is faster than that.
    assert found.shown_s.min() > 0.4
    assert found.level_s > found.shown_s.max() - COSTS.take_s


def test_two_workers_whose_sessions_do_not_fit_into_one_never_become_level() -> None:
    # 240 sessions of 6 ms are 1.44 cores.
    placement = place(240, 16, 2)
    found = fail(placement, 2, 0, COSTS, np.random.default_rng(0))
    assert found.level_s == np.inf
    assert found.busiest == pytest.approx(1.44)


def test_ten_thousand_sessions_come_back_within_two_seconds() -> None:
    costs = Costs()
    workers = plan(10_000, costs).workers
    placement, generator = place(10_000, 2048, workers), np.random.default_rng(0)
    shown = np.concatenate([fail(placement, workers, one, costs, generator).shown_s for one in range(20)])
    assert np.quantile(shown, 0.95) < 2.0


def test_a_plan_grows_with_its_sessions() -> None:
    small, large = plan(100, COSTS), plan(10_000, COSTS)
    assert (small.workers, large.workers) == (1, 100)
    assert large.stream_mb_s == pytest.approx(100.0 * small.stream_mb_s)
