"""What edges and workers say of themselves while NATS or PostgreSQL is away, and what they count together."""

import re
import time
from collections.abc import Iterator

import httpx
import pytest

from app.accounts.credentials.rate_limit import PER_ACCOUNT
from tests.patience import PATIENCE_S
from tests.scaled.cluster import Cluster
from tests.scaled.database import Database
from tests.scaled.killing import whole_service

pytest.importorskip("nats", reason="the extra `scaled` is not installed")
pytestmark = [
    pytest.mark.slow("a whole service starts, and its parts are taken away one after the other"),
    pytest.mark.postgres,
]

PARTS = ("edge0", "worker0")
OWN_METRICS = {"edge0": "gateways", "worker0": "partitions_held"}


@pytest.fixture(scope="module")
def started() -> Iterator[tuple[Cluster, Database]]:
    """One service for all tests here: each leaves it whole."""
    with whole_service() as (cluster, database, _, _):
        yield cluster, database


def ask(cluster: Cluster, name: str, path: str) -> httpx.Response:
    return httpx.get(f"{cluster.address(name)}{path}", trust_env=False, timeout=10.0)


def metric(cluster: Cluster, name: str, of: str) -> float:
    answer = ask(cluster, name, "/metrics")
    assert answer.status_code == 200, answer.text
    [found] = re.findall(rf"^telemotion_{of} (\S+)$", answer.text, re.MULTILINE)
    return float(found)


def until_missing(cluster: Cluster, name: str, what: set[str]) -> dict[str, str]:
    """Return the reasons of a part once it names exactly what is missing."""
    until_s = time.monotonic() + PATIENCE_S
    while True:
        answer = ask(cluster, name, "/api/ready")
        reasons: dict[str, str] = answer.json()["reasons"]
        if reasons.keys() == what:
            assert answer.status_code == 503
            return reasons
        assert time.monotonic() < until_s, reasons
        time.sleep(0.1)


def is_observed(cluster: Cluster) -> None:
    """See that each part is alive and shows its metrics, also that it is not ready."""
    for name in PARTS:
        assert ask(cluster, name, "/api/health").json()["status"] == "ok"
        assert metric(cluster, name, "ready") == 0.0
        assert metric(cluster, name, OWN_METRICS[name]) >= 0.0


def test_health_names_the_broker_that_is_away(started: tuple[Cluster, Database]) -> None:
    cluster, _ = started
    cluster.kill("nats")
    try:
        for name in PARTS:
            assert "NATS" in until_missing(cluster, name, {"broker"})["broker"]
        is_observed(cluster)
    finally:
        cluster.start_broker()
    cluster.until_ready(*PARTS)
    assert [metric(cluster, name, "ready") for name in PARTS] == [1.0, 1.0]


def test_health_names_the_database_that_is_away(started: tuple[Cluster, Database]) -> None:
    cluster, database = started
    database.kill()
    try:
        for name in PARTS:
            reasons = until_missing(cluster, name, {"database", "lock"})
            assert all(reasons.values())
            assert cluster.url not in str(reasons)
        is_observed(cluster)
    finally:
        database.start()
    cluster.until_ready(*PARTS)
    assert [metric(cluster, name, "ready") for name in PARTS] == [1.0, 1.0]


def test_failed_sign_ins_at_two_edges_are_one_count(started: tuple[Cluster, Database]) -> None:
    cluster, _ = started
    body = {"email": "somebody@else.example", "password": "a guess"}

    def attempt(edge: str) -> int:
        address = f"{cluster.address(edge)}/api/sign-in"
        return httpx.post(address, json=body, trust_env=False, timeout=30.0).status_code

    tried = [attempt(f"edge{number % 2}") for number in range(PER_ACCOUNT.capacity)]
    assert tried == [401] * PER_ACCOUNT.capacity
    assert [attempt("edge0"), attempt("edge1")] == [429, 429]
