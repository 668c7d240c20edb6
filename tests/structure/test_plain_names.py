"""Words that say the same thing in two ways stay out of the code, and folders and columns stay readable.

What the field calls it is in `docs/words.md`; the lists here are what is left, each with its reason.
"""

import ast
import re
import subprocess
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
WORDS = re.compile(r"\b(told|kept|taken back|takes? back)\b", re.IGNORECASE)
"""We say report, store or retain, withdraw or revoke."""
WORD_LEFT = {
    "app/assessment/comparisons.py": "a parameter of a stored sentence: rows of earlier sessions hold it",
    "app/sentences/clinical.py": "the same, in its English words",
    "app/sentences/german/accounts.py": "the same, in its German words",
    "docs/words.md": "the table of what we do not say",
    "docs/decisions/0006-signals-are-kept-in-rice-code.md": "the title of a decision, which others link to",
    "docs/decisions/0011-live-frames-are-kept-at-25-hz.md": "the title of a decision, which others link to",
}
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
    "estimators/orientation/marzouk/_angles.py": "halves of three angles, sines then cosines",
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


def test_words_say_what_the_field_says() -> None:
    code = tracked(
        "app/*.py", "estimators/*.py", "validation/*.py", "web/src/*.ts", "web/src/*.tsx", "docs/*.md"
    )
    code = [path for path in code if not path.startswith("web/src/api/")]
    found = {path for path in code if WORDS.search((ROOT / path).read_text(encoding="utf-8"))}
    check(found, WORD_LEFT, "say stored, retained, reported or withdrawn")


def test_folders_hold_what_a_reader_can_survey() -> None:
    files = tracked("app/*.py", "estimators/*.py", "validation/*.py", "tests/*.py", "web/*.ts", "web/*.tsx")
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
    modules = tracked("app/*.py", "estimators/*.py")
    found = {path for path in modules if numbered_columns((ROOT / path).read_text(encoding="utf-8"))}
    check(found, COLUMN_LEFT, "name the column")


@pytest.mark.parametrize(
    ("source", "count"), [("x[7]", 1), ("x[a, 5]", 1), ("x[3]", 0), ("x[:40]", 0), ("x[V + 4]", 0)]
)
def test_a_numbered_column_is_found(source: str, count: int) -> None:
    assert len(numbered_columns(source)) == count
