"""TLS by settings: edges and workers to NATS and PostgreSQL, a gateway by MQTT; and who is refused."""

import asyncio
import ssl
from collections.abc import Callable
from pathlib import Path

import nats
import pytest
from pydantic import SecretStr
from sqlalchemy import make_url
from sqlalchemy.exc import OperationalError

pytest.importorskip("paho.mqtt", reason="the extra `scaled` is not installed")

from app.database.engine import create_from_url
from app.errors import InvalidInput
from app.gateway import ServiceClient
from app.gateway.mqtt_link import MqttLink
from app.scaled import broker as broker_module
from app.scaled.broker import connect
from app.settings import Settings
from tests.benchmarks.service import open_sessions
from tests.scaled.cluster import EMAIL, PASSWORD
from tests.scaled.killing import streaming, whole_service
from tests.scaled.tls.certificates import Authority

pytestmark = [pytest.mark.slow("a whole service starts with certificates of its own"), pytest.mark.postgres]

SESSIONS = 2
STREAMED_S = 3.0

Trust = Callable[[Authority], None]


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    return Authority(tmp_path / "ours")


@pytest.fixture
def another(tmp_path: Path) -> Authority:
    return Authority(tmp_path / "theirs")


@pytest.fixture
def trust(monkeypatch: pytest.MonkeyPatch) -> Trust:
    """Let gateways of this process trust one authority, as a gateway is set up with `SSL_CERT_FILE`."""
    return lambda one: monkeypatch.setenv("SSL_CERT_FILE", str(one.ca))


# Paho leaves a socket whose handshake failed to the garbage collector.
@pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <ssl.SSLSocket:pytest.PytestUnraisableExceptionWarning"
)
def test_everything_streams_by_tls_and_nothing_without_the_right_authority(
    authority: Authority, another: Authority, trust: Trust, monkeypatch: pytest.MonkeyPatch
) -> None:
    trust(authority)
    with whole_service(authority) as (cluster, database, stream, _):
        assert cluster.nats_url.startswith("tls://")
        assert cluster.mqtt_url.startswith("mqtts://")

        async def run() -> None:
            async with streaming(cluster, database, stream, SESSIONS, by_mqtt={1}) as going:
                await asyncio.sleep(STREAMED_S)
                stored = await going.finish()
            assert stored.is_whole, stored
            assert all(one.gateway.report.unacknowledged == 0 for one in going.sessions)
            async with ServiceClient(cluster.address("edge0")) as client:
                await client.sign_in(EMAIL, PASSWORD)
                [made] = await open_sessions(cluster.ports["edge0"], cluster.patient_id, stream, 1)
                ticket = await client.ticket(made["id"])
                trust(another)
                with pytest.raises(ssl.SSLCertVerificationError):
                    await MqttLink.open(cluster.mqtt_url, ticket)
                trust(authority)
                link = await MqttLink.open(cluster.mqtt_url, ticket)
                await link.close()
                # Without TLS the ticket would be in the clear: the listener does not speak so.
                with pytest.raises((OSError, TimeoutError)):
                    await MqttLink.open(cluster.mqtt_url.replace("mqtts", "mqtt"), ticket)

        asyncio.run(run())

        def settings(**changed: object) -> Settings:
            given = {"nats_url": SecretStr(cluster.nats_url), "nats_ca": authority.ca, "partitions": 4}
            return Settings(_env_file=None, demo=True, **(given | changed))  # type: ignore[call-arg,arg-type]

        monkeypatch.setattr(broker_module, "START_S", 3.0)

        async def refused() -> None:
            for changed in (
                {"nats_ca": another.ca},
                {"nats_ca": None, "nats_url": SecretStr(cluster.nats_url)},
                {"nats_url": SecretStr(cluster.nats_url.replace("only-for-tests", "guessed"))},
            ):
                if changed.get("nats_ca", "") is None:
                    trust(another)
                with pytest.raises(InvalidInput):
                    await connect(settings(**changed), "test")
            broker = await connect(settings(), "test")
            assert isinstance(broker.client._transport, nats.aio.transport.TcpTransport)
            assert broker.client._transport._io_writer.get_extra_info("ssl_object") is not None
            await broker.close()

        asyncio.run(refused())

        asked = make_url(cluster.url)
        assert asked.query["sslmode"] == "verify-full"
        for changes in ({"sslrootcert": str(another.ca)}, {"sslmode": "disable"}):
            changed = asked.update_query_dict(changes)
            engine = create_from_url(changed.render_as_string(hide_password=False))
            with pytest.raises(OperationalError), engine.connect():
                pass
            engine.dispose()
