"""`/metrics`: the format, who may read it, that each name is documented and that what happens is counted."""

import re
from pathlib import Path

import pytest
from pydantic import SecretStr

from app.edge.registry import Histogram, Registry
from app.live.checks.health import LinkHealth

PAGE = Path(__file__).resolve().parents[2] / "docs" / "operations.md"
TOKEN = "0123456789abcdefghijklmnopqrstuvwxyz"


def test_the_format_of_prometheus():
    registry = Registry()
    registry.counter("a_total", "Of a.", lambda: 3)
    registry.gauge("b", "Of b.", lambda: {(("kind", 'x"\\\n'),): 1.5})
    histogram = Histogram((0.1, 1.0))
    for value in (0.05, 0.1, 0.5, 7.0):
        histogram.observe(value)
    registry.histogram("c_seconds", "Of c.", histogram)
    assert registry.text().splitlines() == [
        "# HELP telemotion_a_total Of a.",
        "# TYPE telemotion_a_total counter",
        "telemotion_a_total 3",
        "# HELP telemotion_b Of b.",
        "# TYPE telemotion_b gauge",
        'telemotion_b{kind="x\\"\\\\\\n"} 1.5',
        "# HELP telemotion_c_seconds Of c.",
        "# TYPE telemotion_c_seconds histogram",
        'telemotion_c_seconds_bucket{le="0.1"} 2',
        'telemotion_c_seconds_bucket{le="1"} 3',
        'telemotion_c_seconds_bucket{le="+Inf"} 4',
        "telemotion_c_seconds_sum 7.65",
        "telemotion_c_seconds_count 4",
    ]


def test_latencies_are_taken_once_and_still_known():
    health = LinkHealth(["hand_right"], 0.01)
    health.latencies_s.extend([0.01] * 5)
    assert health.take_latencies() == [0.01] * 5
    assert health.take_latencies() == []
    assert health.latency_ms() == (10.0, 10.0)


@pytest.fixture
def token(services):
    object.__setattr__(services.settings, "metrics_token", SecretStr(TOKEN))
    return {"Authorization": f"Bearer {TOKEN}"}


@pytest.mark.parametrize(
    "headers",
    [{}, {"Authorization": "Bearer wrong"}, {"Authorization": f"Basic {TOKEN}"}, {"Authorization": TOKEN}],
)
def test_strangers_read_nothing(nobody, therapist, token, headers):
    for client in (nobody, therapist):
        answer = client.get("/metrics", headers=headers)
        assert (answer.status_code, answer.json()["code"]) == (403, "not_allowed")


def test_without_a_token_only_this_machine_reads(nobody):
    # The client of these tests is called `testclient`, which is no address of this machine.
    assert nobody.get("/metrics").status_code == 403
    nobody._transport.client = ("127.0.0.1", 50000)
    assert nobody.get("/metrics").status_code == 200
    assert nobody.get("/metrics", headers={"X-Forwarded-For": "203.0.113.9"}).status_code == 403
    assert nobody.get("/metrics", headers={"Origin": "https://evil.example"}).status_code == 403
    object.__setattr__(nobody.app.state.services.settings, "base_url", "https://clinic.example")
    assert nobody.get("/metrics").status_code == 403, "behind a proxy everybody seems to come from here"


def test_what_happens_is_counted_and_documented(nobody, world, token):
    def value(name: str, text: str) -> float:
        found = re.search(rf"^{re.escape(name)} (\S+)$", text, re.MULTILINE)
        return float(found[1]) if found else 0.0

    before = nobody.get("/metrics", headers=token).text
    nobody.post(
        "/api/sign-in",
        json={"email": "stranger@nowhere.example", "password": "wrong-horse"},
        headers={"Origin": "http://127.0.0.1:8000"},
    )
    answer = nobody.get("/metrics", headers=token)
    assert answer.headers["content-type"].startswith("text/plain; version=0.0.4")
    after = answer.text
    for name in ("telemotion_sign_ins_refused_total", 'telemotion_http_requests_total{status="401"}'):
        assert value(name, after) == value(name, before) + 1, name
    assert value('telemotion_tasks{status="queued"}', after) == 0
    page = PAGE.read_text()
    for name in nobody.app.state.services.get(Registry).names:
        assert f"`{name}`" in page, name
    assert "stranger" not in after
