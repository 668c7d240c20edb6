"""One writer a database: the second is refused in words, the first does not notice, and death frees the lock."""

import asyncio
import os
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import httpx
import pytest

from app.database import migrate
from app.database.engine import create_from_url
from app.database.writer_lock import DatabaseInUse, writer_lock
from app.errors import InvalidInput, Unavailable
from app.main import create_app
from tests.patience import PATIENCE_S
from tests.ports import free_port

ROOT = Path(__file__).resolve().parents[3]


@dataclass
class Command:
    """`telemotion ...` as its own process on a database of its own."""

    url: str
    folder: Path
    port: int = field(default_factory=free_port)

    def start(self, *words: str) -> "subprocess.Popen[str]":
        environment = {
            **os.environ,
            "TELEMOTION_DEMO": "true",
            "TELEMOTION_BASE_URL": f"http://127.0.0.1:{self.port}",
            "TELEMOTION_DATABASE_URL": self.url,
            "TELEMOTION_DATA_DIR": str(self.folder),
        }
        return subprocess.Popen(
            [sys.executable, "-m", "app.cli", *words],
            cwd=ROOT,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def end(self, *words: str) -> tuple[int, str]:
        """Run to its end; returns exit code and everything it said."""
        process = self.start(*words)
        said, _ = process.communicate(timeout=PATIENCE_S)
        return process.returncode, said


def wait_until_up(port: int, process: "subprocess.Popen[str]") -> None:
    deadline = time.monotonic() + PATIENCE_S
    while True:
        assert process.poll() is None, process.stdout and process.stdout.read()
        assert time.monotonic() < deadline
        try:
            if httpx.get(f"http://127.0.0.1:{port}/api/health", trust_env=False, timeout=2).is_success:
                return
        except httpx.TransportError:
            time.sleep(0.2)


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.postgres)])
def url(request, tmp_path):
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'telemotion.db'}"
    return request.getfixturevalue("postgresql_database")()


def test_the_second_is_refused_by_name_and_death_frees_the_lock(url):
    with writer_lock(url, "telemotion serve", "127.0.0.1:8000"):
        second = writer_lock(url, "telemotion migrate")
        with pytest.raises(DatabaseInUse, match="telemotion serve") as refusal:
            second.take()
        assert str(os.getpid()) in refusal.value.message
        assert "since 2" in refusal.value.message
    with second:
        assert second.trouble() is None
    program = (
        "import sys, time\n"
        "from app.database.writer_lock import writer_lock\n"
        "lock = writer_lock(sys.argv[1], 'telemotion serve')\n"
        "lock.take()\n"
        "print('held', flush=True)\n"
        "time.sleep(60)"
    )
    words = [sys.executable, "-c", program, url]
    with subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        with pytest.raises(DatabaseInUse, match=f"process {holder.pid}"):
            second.take()
        holder.kill()
    deadline = time.monotonic() + PATIENCE_S
    while second.trouble() is not None:
        assert time.monotonic() < deadline, "the lock outlived its process"
    second.release()


def test_another_name_of_the_file_is_the_same_database(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with (
        writer_lock(f"sqlite:///{tmp_path / 'real' / 'a.db'}", "telemotion serve"),
        pytest.raises(DatabaseInUse),
    ):
        writer_lock(f"sqlite:///{tmp_path / 'link' / 'a.db'}", "telemotion serve").take()


def test_a_lock_whose_file_is_gone_is_not_held(tmp_path):
    url = f"sqlite:///{tmp_path / 'a.db'}"
    said: list[str] = []
    with writer_lock(url, "telemotion serve") as first:
        first.on_taken_over = said.append
        next(tmp_path.glob("*.writer")).unlink()
        with writer_lock(url, "telemotion demo"):
            assert "telemotion demo" in (first.trouble() or "")
            assert said
        assert first.trouble() is None, "free again: taken again"


@pytest.mark.postgres
def test_a_lock_whose_connection_is_lost_is_noticed(postgresql_database):
    url = postgresql_database()
    said: list[str] = []
    with writer_lock(url, "telemotion serve") as first:
        first.on_taken_over = said.append
        cut_connections(url)
        assert first.trouble() is None, "nobody else has it: taken again"
        cut_connections(url)
        with writer_lock(url, "telemotion demo"):
            assert "telemotion demo" in (first.trouble() or "")
        assert len(said) == 1


def cut_connections(url: str) -> None:
    from sqlalchemy import text

    engine = create_from_url(url)
    with engine.begin() as connection:
        connection.execute(
            text(
                "SELECT pg_terminate_backend(pid) FROM pg_stat_activity"
                " WHERE datname = current_database() AND application_name LIKE 'telemotion%'"
            )
        )
    engine.dispose()


def test_what_cannot_be_reached_says_so(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InvalidInput, match="TELEMOTION_DATABASE_URL"):
        writer_lock(f"sqlite:///{tmp_path / 'file' / 'a.db'}", "telemotion serve").take()
    with pytest.raises(Unavailable, match="PostgreSQL runs") as refusal:
        writer_lock(f"postgresql://ada:secret@127.0.0.1:{free_port()}/x", "telemotion serve").take()
    assert "secret" not in refusal.value.message


def test_an_application_on_a_held_database_does_not_open(settings, cheap_passwords):
    application = create_app(settings, passwords=cheap_passwords)

    async def open_it() -> None:
        async with application.router.lifespan_context(application):
            pytest.fail("it opened")

    with (
        writer_lock(settings.database_url, "telemotion serve", "127.0.0.1:8000"),
        pytest.raises(DatabaseInUse, match=r"127\.0\.0\.1:8000"),
    ):
        asyncio.run(open_it())
    assert not (settings.data_dir / "uploads").exists(), "nothing was touched"


@pytest.mark.slow
def test_commands_say_in_one_line_why_they_do_not_begin(tmp_path):
    database = tmp_path / "telemotion.db"
    command = Command(f"sqlite:///{database}", tmp_path)
    with socket.socket() as other:
        other.bind(("127.0.0.1", command.port))
        other.listen()
        code, said = command.end("serve", "--port", str(command.port))
        assert (code, said.count("\n")) == (2, 1), said
        assert f"port {command.port}" in said
        code, said = command.end("demo", "--port", str(command.port), "--folder", str(tmp_path / "demo"))
        assert (code, said.count("\n")) == (2, 1), said
    assert not database.exists(), "a taken port leaves the database alone"
    migrate.upgrade(command.url)
    with sqlite3.connect(database) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999_future'")
    connection.close()
    code, said = command.end("migrate")
    assert (code, said.count("\n")) == (2, 1), said
    assert "newer version" in said


def test_only_the_owner_reads_the_database_wherever_the_folder_was(tmp_path):
    database = tmp_path / "open" / "telemotion.db"
    database.parent.mkdir(mode=0o755)
    database.touch(0o644)
    migrate.upgrade(f"sqlite:///{database}")
    engine = create_from_url(f"sqlite:///{database}")
    with engine.begin() as connection:
        connection.exec_driver_sql("CREATE TABLE more (x)")
        modes = {path.name: path.stat().st_mode & 0o777 for path in database.parent.iterdir()}
    engine.dispose()
    assert modes == dict.fromkeys(modes, 0o600)
    assert {"telemotion.db", "telemotion.db-wal"} <= modes.keys()


@pytest.mark.slow
def test_two_services_on_one_database(url, tmp_path):
    first = Command(url, tmp_path)
    running = first.start("serve", "--port", str(first.port))
    try:
        wait_until_up(first.port, running)
        upload = tmp_path / "uploads" / "in-passing"
        upload.write_bytes(b"half a recording")
        for words in (
            ("serve", "--port", str(free_port())),
            ("serve", "--port", str(first.port)),
        ):
            code, said = Command(url, tmp_path).end(*words)
            assert code == 2, said
            assert said.startswith("telemotion: "), said
            assert said.count("\n") == 1, said
        archive = tmp_path / "backup.zip"
        assert Command(url, tmp_path).end("backup", str(archive))[0] == 0, "reading goes on beside a service"
        code, said = Command(url, tmp_path).end("restore", str(archive))
        assert (code, "telemotion serve" in said) == (2, True), said
        assert upload.read_bytes() == b"half a recording"
        assert httpx.get(f"http://127.0.0.1:{first.port}/api/health", trust_env=False).is_success
    finally:
        running.send_signal(signal.SIGTERM)
        said, _ = running.communicate(timeout=PATIENCE_S)
    assert "Traceback" not in said
    second = Command(url, tmp_path)
    running = second.start("serve", "--port", str(second.port))
    try:
        wait_until_up(second.port, running)
    finally:
        running.kill()
        running.communicate()
