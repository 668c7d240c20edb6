"""The image has what the service needs, in the versions that were tested, and nothing that only its tests need."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_PINNED = re.compile(r"^([a-z0-9][a-z0-9._-]*)(?:\[[a-z,]+\])?==([^ \\;]+)", re.MULTILINE)
_NAME = re.compile(r"^[A-Za-z0-9._-]+")


def locked(file: str) -> dict[str, str]:
    return dict(_PINNED.findall((ROOT / file).read_text()))


def asked(extra: str | None = None) -> set[str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    listed = project["dependencies"] if extra is None else project["optional-dependencies"][extra]
    return {found[0].lower() for one in listed if (found := _NAME.match(one))}


def test_the_service_has_what_it_asks_for_as_it_was_tested() -> None:
    service, tested = locked("requirements-service.lock"), locked("requirements.lock")
    assert asked() <= service.keys()
    assert service.items() <= tested.items()


def test_the_image_has_nothing_that_only_tests_need() -> None:
    service = locked("requirements-service.lock")
    assert not asked("test") - asked() & service.keys()
    assert not {"schemathesis", "playwright", "mypy", "pytest", "hatchling"} & service.keys()
    installed = re.findall(r"--require-hashes[^\n]* -r (\S+)", (ROOT / "docker" / "Dockerfile").read_text())
    stages = (ROOT / "docker" / "Dockerfile").read_text().split("\nFROM ")
    assert "requirements.lock" in installed
    for stage in stages:
        if "requirements.lock" in re.findall(r"-r (\S+)", stage):
            assert " AS wheel\n" in stage, "the lock of the tests builds the wheel only"
    assert "--from=wheel /opt" not in stages[-1]
