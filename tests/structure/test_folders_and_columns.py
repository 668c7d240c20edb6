"""Folders stay small enough to survey, and columns are read by their names."""

import ast
import subprocess
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MOST_FILES = 15
COLUMN = 4
"""An index from here on is a column that wants a name; below are axes, quaternions and rows of a rotation."""
COLUMN_LEFT = {
    "app/network/placing/crc.py": "eight tables, one for each byte of a word",
    "app/gateway/client.py": "a wire format, by its offset",
    "estimators/gait/foot/step_kernel.py": "a rotation matrix row by row",
    "estimators/orientation/telemotion/_gaps.py": "a matrix of nine, column by column",
    "estimators/orientation/telemotion/_samples.py": "a matrix of nine, column by column",
    "estimators/orientation/vqf/_steps.py": "matrices of nine, row by row",
    "published/marzouk/_angles.py": "halves of three angles, sines then cosines",
}


def tracked(*patterns: str) -> list[str]:
    listing = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    return [line for line in listing.splitlines() if (ROOT / line).is_file()]


def check(found: set[str], excused: dict[str, str], what: str) -> None:
    assert not found - set(excused), f"{what}, or say in the list why not"
    assert not set(excused) - found, "excused, but clean by now or gone: take them off the list"


def test_folders_hold_what_a_reader_can_survey() -> None:
    files = tracked(
        "app/*.py",
        "estimators/*.py",
        "published/*.py",
        "validation/*.py",
        "tests/*.py",
        "web/*.ts",
        "web/*.tsx",
    )
    counts = Counter(Path(path).parent.as_posix() for path in files if Path(path).name != "__init__.py")
    assert not {folder: count for folder, count in counts.items() if count > MOST_FILES}, "divide it by idea"


def numbered_columns(source: str) -> list[str]:
    """Return the places of a module that read one number of a row by a bare integer."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Subscript) and not isinstance(node.slice, ast.Slice):
            parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
            numbers = (part.value for part in parts if isinstance(part, ast.Constant))
            if any(type(number) is int and number >= COLUMN for number in numbers):
                found.append(ast.unparse(node))
    return found


def test_columns_are_read_by_their_names() -> None:
    modules = tracked("app/*.py", "estimators/*.py", "published/*.py")
    found = {path for path in modules if numbered_columns((ROOT / path).read_text(encoding="utf-8"))}
    check(found, COLUMN_LEFT, "name the column")


@pytest.mark.parametrize(
    ("source", "count"), [("x[7]", 1), ("x[a, 5]", 1), ("x[3]", 0), ("x[:40]", 0), ("x[V + 4]", 0)]
)
def test_a_numbered_column_is_found(source: str, count: int) -> None:
    assert len(numbered_columns(source)) == count
