"""The tests that `make test-quick` leaves out and those that may run again exist, and are chosen as it says."""

import ast
from pathlib import Path

from tests.again import AGAIN_FILE, MOST_AGAIN, listed
from tests.costs import BUDGET_FILE, SLOW_FILE, beyond, budgets, by_folder, function_of, too_costly, written

ROOT = Path(__file__).parents[2]


def functions(file: Path) -> set[str]:
    """Return the names that a file defines, those of methods without their class."""
    tree = ast.parse(file.read_text())
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)}


def is_there(name: str) -> bool:
    """Return whether a test function exists; a method may be inherited from a contract in another file."""
    file, *_, function = name.split("::")
    return (ROOT / file).exists() and (name.count("::") > 1 or function in functions(ROOT / file))


def test_what_is_listed_is_there() -> None:
    names = SLOW_FILE.read_text().split()
    assert names == sorted(set(names))
    assert [name for name in names if not is_there(name)] == [], "`make test-costs` writes the list anew"


def test_few_may_run_again_each_with_its_reason() -> None:
    lines = AGAIN_FILE.read_text().splitlines()
    reasons = listed(AGAIN_FILE.read_text())
    assert len(reasons) == len(lines) <= MOST_AGAIN
    assert [name for name in reasons if not is_there(name)] == []
    assert [name for name, reason in reasons.items() if len(reason.split()) < 4] == []


def test_the_fewest_go_until_the_rest_fits() -> None:
    costs = {"a": 5.0, "b": 3.0, "c": 3.0, "d": 0.5}
    assert too_costly(costs, 12.0) == []
    assert too_costly(costs, 6.5) == ["a"]
    assert too_costly(costs, 4.0) == ["a", "b"]
    assert too_costly(costs, 0.4) == ["a", "b", "c", "d"]


def test_cases_of_a_test_count_as_one() -> None:
    assert function_of("tests/a.py::test_b[x::y[0]]") == "tests/a.py::test_b"


def test_a_folder_beyond_its_share_is_named() -> None:
    took = by_folder({"tests/a/b/c/test_x.py::test_x": 6.0, "tests/a/test_y.py::test_y": 4.0})
    assert took == {"tests/a/b": 6.0, "tests/a": 4.0}
    assert budgets(written(took)) == took
    # A slow machine takes three times as long for everything.
    assert beyond({"tests/a/b": 18.0, "tests/a": 12.0}, took) == []
    (line,) = beyond({"tests/a/b": 2.0, "tests/a": 4.0}, took)
    assert line.startswith("tests/a: 66.7%")
    (line,) = beyond({**took, "tests/new": 1.0}, took)
    assert line.startswith("tests/new: 9.1%")
    assert beyond({}, took) == beyond({"tests/a": 1.0}, took) == []


def test_folders_with_a_budget_are_there() -> None:
    budget = budgets(BUDGET_FILE.read_text())
    assert budget
    assert [name for name in budget if not (ROOT / name).is_dir()] == [], "`make test-costs` writes it anew"
