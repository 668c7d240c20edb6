"""Every worker and then every edge is upgraded while sessions stream, one of three by MQTT."""

import asyncio
from pathlib import Path

import pytest
from sqlalchemy import select

from app.database.engine import create_from_url
from app.live.session import checkpoint
from app.recordings.models import LiveCheckpoint
from tests.patience import PATIENCE_S
from tests.scaled.embedded import embedded_shown
from tests.scaled.killing import streaming, whole_service
from tests.scaled.upgrading import VERSION, Upgrade, parts_of, upgrade, version_of

pytest.importorskip("nats", reason="the extra `scaled` is not installed")
pytest.importorskip("paho.mqtt", reason="the extra `scaled` is not installed")
pytestmark = [
    pytest.mark.slow(
        "each of four processes is replaced while sessions stream, and one is estimated again to compare every bit"
    ),
    pytest.mark.postgres,
]

SESSIONS = 3


def layouts(url: str) -> list[int]:
    engine = create_from_url(url)
    with engine.connect() as connection:
        found = connection.scalars(select(LiveCheckpoint.layout)).all()
    engine.dispose()
    return list(found)


async def until_noted(url: str, layout: int) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while await asyncio.to_thread(layouts, url) != [layout] * SESSIONS:  # noqa: ASYNC110
            await asyncio.sleep(0.5)


def test_an_upgrade_of_every_part_loses_nothing_and_no_bit_differs(tmp_path: Path) -> None:
    with whole_service() as (cluster, database, stream, calibration):
        steps: list[Upgrade] = []

        async def run() -> None:
            async with streaming(cluster, database, stream, SESSIONS, by_mqtt={1}) as going:
                # There is something that the next version cannot read.
                await until_noted(cluster.url, checkpoint.LAYOUT)
                for name in parts_of(cluster):
                    steps.append(await upgrade(going, name))
                    print(steps[-1])
                await until_noted(cluster.url, checkpoint.LAYOUT + 1)
                ours = dict(going.sessions[0].shown)
                stored = await going.finish()
            assert stored.is_whole, stored
            assert not any(one.contradictions for one in going.sessions)
            assert all(one.gateway.report.unacknowledged == 0 for one in going.sessions)
            (tmp_path / "one").mkdir(mode=0o700)
            theirs = await asyncio.to_thread(
                embedded_shown, tmp_path / "one", calibration, stream, going.sessions[0]
            )
            both = ours.keys() & theirs.keys()
            assert len(both) > 0.9 * len(ours)
            assert not [tick for tick in both if ours[tick] != theirs[tick]]

        asyncio.run(run())
        assert [one.name for one in steps] == ["worker0", "worker1", "edge0", "edge1"]
        assert {version_of(cluster, one.name) for one in steps} == {VERSION}
