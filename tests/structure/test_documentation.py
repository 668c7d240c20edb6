"""Documentation that would rot by itself: settings, commands and links."""

import re
from pathlib import Path

from typer.main import get_command

from app.cli import cli
from app.settings import Settings

ROOT = Path(__file__).resolve().parents[2]


def test_every_setting_is_on_the_operations_page() -> None:
    page = (ROOT / "docs" / "operations.md").read_text()
    for name, field in Settings.model_fields.items():
        assert f"`TELEMOTION_{name.upper()}`" in page, name
        assert field.description


def test_every_command_explains_itself() -> None:
    commands = get_command(cli).commands  # type: ignore[attr-defined]
    wanted = [
        "serve",
        "migrate",
        "demo",
        "simulate",
        "upload",
        "process",
        "reprocess",
        "backup",
        "restore",
        "validate",
    ]
    assert set(wanted) <= set(commands)
    for name, command in commands.items():
        assert command.help, name
        for parameter in command.params:
            if parameter.name != "help":
                assert getattr(parameter, "help", None), f"{name} {parameter.name}"


def test_links_of_the_documentation_lead_somewhere() -> None:
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            if not target.startswith("http"):
                assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_make_help_names_the_two_commands() -> None:
    text = (ROOT / "Makefile").read_text()
    assert re.search(r"^run:.*## ", text, re.MULTILINE)
    assert re.search(r"^test:.*## ", text, re.MULTILINE)


def test_files_that_the_documentation_names_are_there() -> None:
    folders = "tests|app|estimators|messages|published|validation|web|migrations|docker"
    named = re.compile(rf"(?<![\w/.])(?:{folders})/[\w/.-]+\.(?:py|tsx?|json|yaml)")
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        for path in named.findall(page.read_text()):
            # NAME, KIND and LANG stand for a name of one's own.
            if not re.search("NAME|KIND|LANG", path):
                assert (ROOT / path).exists(), f"{page.name}: {path}"
