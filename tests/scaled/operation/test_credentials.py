"""Edges and workers show NATS what its servers ask for; who shows something else is told why it is not let in."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import SecretStr

pytest.importorskip("nats", reason="the extra `scaled` is not installed")

from app.errors import InvalidInput
from app.scaled import broker as broker_module
from app.scaled.broker import connect, stream_name
from app.scaled.wire import subject
from app.settings import Settings
from tests.patience import PATIENCE_S
from tests.ports import free_port
from tests.said import codes
from tests.scaled.cluster import Cluster
from tests.scaled.killing import streaming, whole_service
from tests.scaled.operation.operator import Operator, User, launch, serving, write_credentials


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(broker_module, "START_S", 3.0)


def settings(port: int, credentials: Path | None, address: str = "") -> Settings:
    return Settings(
        _env_file=None,  # type: ignore[call-arg]
        demo=True,
        partitions=1,
        nats_url=SecretStr(f"nats://{address}127.0.0.1:{port}"),
        nats_credentials=credentials,
    )


async def let_in(port: int, credentials: Path | None, address: str = "") -> None:
    """See that a process with these may do what it must."""
    broker = await connect(settings(port, credentials, address), "test")
    try:
        before = (await broker.streams.stream_info(stream_name(0))).state.messages
        await broker.streams.publish(subject("in", 0), b"a packet")
        assert (await broker.streams.stream_info(stream_name(0))).state.messages == before + 1
        await broker.leases.put("lease", b"mine")
    finally:
        await broker.close()


async def refused(port: int, credentials: Path | None, address: str = "") -> tuple[str, str]:
    """Return the code and the reason with which a process is not let in."""
    with pytest.raises(InvalidInput) as found:
        await connect(settings(port, credentials, address), "test")
    return codes(found.value.message)[0], str(found.value.message)


def test_credentials_that_an_account_has_signed_are_let_in_and_no_others(tmp_path: Path) -> None:
    port, ours, theirs = free_port(), Operator(), Operator()
    user, other = User(), User()

    def written(name: str, token: str, seed: str) -> Path:
        return write_credentials(tmp_path / f"{name}.creds", token, seed)

    async def run() -> None:
        await let_in(port, written("right", ours.token(user), user.seed))
        nothing = {"pub": {"deny": ["$JS.>"]}}
        for credentials, reason in (
            (None, "authorization violation"),
            (written("another operator", theirs.token(user), user.seed), "authorization violation"),
            (written("another key", ours.token(user), other.seed), "authorization violation"),
            (written("expired", ours.token(user, lasts_s=-60.0), user.seed), "authorization violation"),
            (written("no right", ours.token(user, **nothing), user.seed), "permissions violation"),
        ):
            code, words = await refused(port, credentials)
            assert code == "scaled.no_broker_right", words
            assert reason in words.lower()
            assert user.seed not in words

    with serving(tmp_path, port, ours.lines()):
        asyncio.run(run())


def test_an_nkey_or_a_password_is_let_in_and_no_other(tmp_path: Path) -> None:
    port, user, other = free_port(), User(), User()
    file, wrong = tmp_path / "user.nk", tmp_path / "other.nk"
    file.write_text(user.seed + "\n")
    wrong.write_text(other.seed)

    async def run() -> None:
        await let_in(port, file)
        await let_in(port, None, "telemotion:pass-word@")
        for credentials, address in ((wrong, ""), (None, ""), (None, "telemotion:guessed@")):
            code, words = await refused(port, credentials, address)
            assert code == "scaled.no_broker_right", words
            assert other.seed not in words
            assert "guessed" not in words

    users = f'{{ nkey: {user.public} }}, {{ user: "telemotion", password: "pass-word" }}'
    with serving(tmp_path, port, [f"authorization {{ users: [{users}] }}"]):
        asyncio.run(run())


def test_credentials_that_are_replaced_before_they_expire_last(tmp_path: Path) -> None:
    port, operator, user = free_port(), Operator(), User()
    file = write_credentials(tmp_path / "user.creds", operator.token(user, lasts_s=3.0), user.seed)

    async def until(holds: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():  # noqa: ASYNC110
                await asyncio.sleep(0.02)

    async def run() -> None:
        broker = await connect(settings(port, file), "test")
        times_back = 0

        def back() -> None:
            nonlocal times_back
            times_back += 1

        broker.on_back(back)
        try:
            # Too late, and in between no credentials at all: it is tried again until they are right.
            file.unlink()
            await until(lambda: broker.trouble() is not None)
            file.write_text("being written")
            await asyncio.sleep(1.0)
            assert times_back == 0
            write_credentials(file, operator.token(user, lasts_s=4.0), user.seed)
            await until(lambda: times_back == 1)
            await broker.streams.publish(subject("in", 0), b"a packet")
            # In time: the connection ends once more, and is there again at once.
            write_credentials(file, operator.token(user), user.seed)
            await until(lambda: times_back == 2)
            await broker.streams.publish(subject("in", 0), b"a packet")
        finally:
            await broker.close()

    with serving(tmp_path, port, operator.lines()):
        asyncio.run(run())


@pytest.mark.parametrize("change", ["away", "empty", "cut", "mistyped", "public", "no text"])
def test_a_file_that_is_none_is_refused_at_once_and_not_shown(tmp_path: Path, change: str) -> None:
    user, file = User(), tmp_path / "user.creds"
    contents = {
        "empty": b"",
        "cut": user.seed[:-3].encode(),
        "mistyped": (user.seed[:20] + ("A" if user.seed[20] != "A" else "B") + user.seed[21:]).encode(),
        "public": user.public.encode(),
        "no text": b"\xff\xfe" + user.seed.encode(),
    }
    if change in contents:
        file.write_bytes(contents[change])
    code, words = asyncio.run(refused(free_port(), file))
    assert code == "scaled.no_credentials"
    assert str(file) in words
    assert user.seed[5:15] not in words


class WithCredentials(Cluster):
    """A service whose NATS lets in whom an operator's account has signed for."""

    operator, user = Operator(), User()

    @property
    def nats_url(self) -> str:
        return f"nats://127.0.0.1:{self.nats_port}"

    def edge_url(self, name: str) -> str:
        return self.nats_url

    def environment(self, port: int) -> dict[str, str]:
        file = self.folder / "user.creds"
        if not file.exists():
            write_credentials(file, self.operator.token(self.user), self.user.seed)
        own = {"TELEMOTION_NATS_CREDENTIALS": str(file), "TELEMOTION_MQTT": "false"}
        return super().environment(port) | own

    def start_broker(self) -> None:
        self.processes["nats"] = launch(self.folder, self.nats_port, self.operator.lines())


@pytest.mark.slow("a whole service starts at a broker with accounts")
@pytest.mark.postgres
def test_edges_and_workers_stream_with_credentials() -> None:
    with whole_service(kind=WithCredentials) as (cluster, database, stream, _):

        async def run() -> None:
            async with streaming(cluster, database, stream, 2) as going:
                await asyncio.sleep(3.0)
                stored = await going.finish()
            assert stored.sent > 0
            assert stored.is_whole, stored

        asyncio.run(run())
