"""The first administrator's password: typed, in a file or in the environment, never on the command line."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli import cli
from app.commands import store

WORDS = ["create-clinic", "Harbour", "--email", "a@clinic.example", "--name", "Noor Haddad"]
PASSWORD = "four plain green words"


@pytest.fixture
def given(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    found: list[str] = []
    monkeypatch.delenv("TELEMOTION_PASSWORD", raising=False)
    monkeypatch.setattr(store, "create_clinic", lambda *words: found.append(words[-1]))
    return found


def test_a_password_on_the_command_line_is_refused(given: list[str]) -> None:
    done = CliRunner().invoke(cli, [*WORDS, "--password", PASSWORD])
    assert done.exit_code == 2
    assert "list of processes" in " ".join(done.output.replace("│", " ").split())
    assert given == []


def test_it_is_asked_for_read_from_a_file_or_from_the_environment(
    given: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert CliRunner().invoke(cli, WORDS, input=f"{PASSWORD}\n{PASSWORD}\n").exit_code == 0
    file = tmp_path / "password"
    file.write_text(f"{PASSWORD}\r\nsecond line\n")
    assert CliRunner().invoke(cli, [*WORDS, "--password-file", str(file)]).exit_code == 0
    monkeypatch.setenv("TELEMOTION_PASSWORD", PASSWORD)
    assert CliRunner().invoke(cli, WORDS).exit_code == 0
    assert given == [PASSWORD] * 3
