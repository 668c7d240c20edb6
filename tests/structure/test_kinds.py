"""Nothing outside `app/kinds` asks which kind a session is: its folder there says what differs."""

import ast
import re
from pathlib import Path

import pytest

from app.recordings.analysis.kinds import SessionKind, kind_of, kinds
from estimators import pipelines

ROOT = Path(__file__).resolve().parents[2]
WITH_A_REASON = {
    "app/assessment/walk_progress.py": "progress of walks alone, by the results of their pipeline",
    "app/commands/process.py": "bursts are analysed by a command only, without sessions",
    "app/commands/processing/estimate.py": "walks write other files than frames",
}


def asked(path: Path) -> list[int]:
    """Return the lines that compare something named `pipeline` with one kind's name."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Compare) and any(
            _is_pipeline(side) for side in (node.left, *node.comparators)
        ):
            found.append(node.lineno)
    return found


def _is_pipeline(node: ast.expr) -> bool:
    if isinstance(node, ast.Attribute):
        return node.attr == "pipeline"
    if isinstance(node, ast.Subscript):
        return isinstance(node.slice, ast.Constant) and node.slice.value == "pipeline"
    return isinstance(node, ast.Name) and node.id == "pipeline"


def test_nobody_outside_the_kinds_asks_for_one() -> None:
    paths = [path for path in sorted((ROOT / "app").rglob("*.py")) if "kinds" not in path.parts]
    found = {str(path.relative_to(ROOT)): lines for path in paths if (lines := asked(path))}
    assert set(found) == set(WITH_A_REASON), found


def test_no_page_names_a_kind() -> None:
    # `arm` is also a point of view, `orientation` also what is estimated.
    names = "|".join(set(pipelines.available()) - {"arm", "orientation"})
    client = ROOT / "web" / "src"
    found = [
        str(path.relative_to(client))
        for path in client.rglob("*.ts*")
        if path.relative_to(client).parts[0] not in ("kinds", "api", "i18n")
        and re.search(rf"['\"]({names})['\"]", path.read_text())
    ]
    assert found == []


def test_every_pipeline_has_its_kind() -> None:
    assert {name: kind.pipeline for name, kind in kinds().items()} == pipelines.available()
    assert all(isinstance(kind, SessionKind) for kind in kinds().values())


def test_a_kind_is_found_by_a_setup_as_it_is_stored() -> None:
    setup = pipelines.SessionSetup("gait", ("foot_left", "foot_right"), 100.0)
    assert kind_of(setup) is kind_of(setup.to_dict()) is kinds()["gait"]
    with pytest.raises(KeyError):
        kind_of({"pipeline": "nothing"})


def test_a_question_is_found(tmp_path: Path) -> None:
    example = tmp_path / "example.py"
    example.write_text(
        "if setup.pipeline == 'gait': pass\nif found.setup['pipeline'] in NAMES: pass\nx = pipeline\n"
    )
    assert asked(example) == [1, 2]
