"""The service's folder and database are its own account's, whatever rights they were made with."""

import os
import stat
from pathlib import Path

import pytest

from app.commands import private_folder
from app.commands.private_folder import make_private
from app.commands.serve import claim
from app.errors import InvalidInput
from app.settings import Settings
from tests.ports import free_port


def settings_in(folder: Path) -> Settings:
    return Settings(
        _env_file=None, demo=True, data_dir=folder, database_url=f"sqlite:///{folder / 'motion.db'}"
    )


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder and a database as `mkdir` and `cp` of an administrator leave them."""
    folder = tmp_path / "data"
    folder.mkdir()
    for name in ("motion.db", "motion.db-wal", "motion.db-shm"):
        (folder / name).write_bytes(b"")
        (folder / name).chmod(0o644)
    folder.chmod(0o755)
    return folder


def test_others_lose_their_rights_when_the_service_starts(folder: Path) -> None:
    with claim(settings_in(folder), "127.0.0.1", free_port(), "tests"):
        assert mode(folder) == 0o700
        assert {path.name: mode(path) for path in folder.glob("motion.db*")} == dict.fromkeys(
            (path.name for path in folder.glob("motion.db*")), 0o600
        )


def test_a_folder_is_made_for_its_own_account(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        make_private(settings_in(tmp_path / "new" / "data"))
    finally:
        os.umask(before)
    assert mode(tmp_path / "new" / "data") == 0o700


@pytest.mark.parametrize("name", ["", "lost+found"])
def test_an_empty_folder_is_taken_as_the_services_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """A disk of its own too, in which its file system has made a folder."""
    monkeypatch.setattr(private_folder.os, "geteuid", lambda: 0)
    folder = tmp_path / "data"
    (folder / name).mkdir(parents=True)
    folder.chmod(0o755)
    with claim(settings_in(folder), "127.0.0.1", free_port(), "tests"):
        assert mode(folder) == 0o700


def test_narrower_rights_stay(folder: Path) -> None:
    folder.chmod(0o500)
    make_private(settings_in(folder))
    assert mode(folder) == 0o500


def test_a_folder_of_everybody_is_refused_and_left(folder: Path) -> None:
    folder.chmod(0o1777)
    with pytest.raises(InvalidInput, match="TELEMOTION_DATA_DIR"):
        make_private(settings_in(folder))
    assert mode(folder) == 0o1777


def test_root_closes_no_folder_that_is_not_the_services_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(private_folder.os, "geteuid", lambda: 0)
    shared = tmp_path / "lib"
    (shared / "postgresql").mkdir(parents=True)
    shared.chmod(0o755)
    with pytest.raises(InvalidInput, match="TELEMOTION_DATA_DIR"):
        make_private(settings_in(shared))
    assert mode(shared) == 0o755


def test_what_another_account_owns_is_refused_in_words(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, wanted: int) -> None:
        raise PermissionError(1, "Operation not permitted", str(path))

    monkeypatch.setattr(Path, "chmod", refuse)
    with pytest.raises(InvalidInput, match=f"chmod 700 {folder}"):
        make_private(settings_in(folder))


def test_a_database_on_another_machine_has_no_file_here(tmp_path: Path) -> None:
    settings = Settings(
        _env_file=None, demo=True, data_dir=tmp_path / "data", database_url="postgresql://a:b@example/motion"
    )
    make_private(settings)
    assert mode(tmp_path / "data") == 0o700
