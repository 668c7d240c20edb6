"""An experiment is skipped after it passed with the same code, and runs after a change of any module it imports."""

from pathlib import Path

import pytest

import validation
from tests.validation import passed_before

FILES = {
    "lab/__init__.py": "",
    "lab/trial.py": "from lab import scene\nfrom .tools import wrench\nimport numpy",
    "lab/scene.py": "FILTERS = {'one': ('filters.one', 'One')}",
    "lab/tools/__init__.py": "",
    "lab/tools/wrench.py": "def turn():\n    from lab.late import late",
    "lab/late.py": "late = 1",
    "lab/other.py": "other = 1",
    "filters/one.py": "class One: pass",
    "tests/validation/one_seed.py": "",
}


@pytest.fixture
def house(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small repository whose digests lie beside it."""
    monkeypatch.setenv("TELEMOTION_TEST_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("ALL", raising=False)
    for name, text in FILES.items():
        file = tmp_path / "house" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return tmp_path / "house"


def runs(house: Path, *, fails: bool = False) -> bool:
    """Return whether the experiment runs."""
    passed_before.imported.cache_clear()
    passed_before.needed.cache_clear()
    has_run = False
    try:
        with passed_before.unless_passed_before("trial", {"lab.trial"}, house):
            has_run = True
            assert not fails
    except (pytest.skip.Exception, AssertionError):
        pass
    return has_run


def test_the_same_code_runs_once(house: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert runs(house)
    assert not runs(house)
    monkeypatch.setenv("ALL", "1")
    assert runs(house)


@pytest.mark.parametrize(
    "name", sorted(FILES.keys() - {"lab/__init__.py", "lab/other.py", "lab/tools/__init__.py"})
)
def test_a_change_of_what_is_imported_runs_it_again(house: Path, name: str) -> None:
    assert runs(house)
    (house / name).write_text(FILES[name] + "\nchanged = True")
    assert runs(house)
    assert not runs(house)


def test_a_change_of_what_is_not_imported_does_not(house: Path) -> None:
    assert runs(house)
    (house / "lab/other.py").write_text("other = 2")
    assert not runs(house)


def test_what_failed_runs_again(house: Path) -> None:
    assert runs(house, fails=True)
    assert runs(house, fails=True)
    assert runs(house)


def test_another_version_or_processor_runs_it_again(house: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert runs(house)
    monkeypatch.setattr(passed_before.metadata, "version", lambda name: "0")
    assert runs(house)
    monkeypatch.setattr(passed_before, "processor", lambda: "another")
    assert runs(house)


def test_an_experiment_depends_on_its_filter_and_not_on_other_experiments() -> None:
    found = next(one for one in validation.protocols() if one.name == "orientation_honesty")
    modules = passed_before.closure(passed_before.modules_of(found))
    assert {"validation.orientation.honesty", "estimators.orientation", "published.marzouk"} <= modules
    assert "validation.foot.events" not in modules
    assert not any(name.startswith(("app", "tests")) for name in modules)
