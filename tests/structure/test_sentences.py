"""Every sentence that is said stands in the catalogue with exactly its parameters, and none is left over."""

import ast
import functools
import importlib
import json
from pathlib import Path

import pytest

from app.ingest.client_words import english
from app.sentences import ENGLISH, german
from app.sentences.german import GERMAN
from estimators import sentences as of_estimators
from estimators.sentences._catalogue import places
from estimators.sentences._formats import is_of_codes

ROOT = Path(__file__).resolve().parents[2]
SAID_BY_LIBRARY = ("text.lines",)
"""By `Catalogue.together`."""
MEASURE_NAMES = {f"measure_name.{one}" for one in ("repetition", "uneven", "walk")}
KINDS = {"place", "side", "level", "state"} | MEASURE_NAMES
"""Names that places may refer to as whole lists, or that the client says labels with; others where a place does."""

CLIENT_WORDS = english()


@functools.cache
def said() -> list[tuple[str, str | None, frozenset[str]]]:
    """File and line, code, and names of the parameters of each call of `say`."""
    found = []
    for path in sorted([*(ROOT / "app").rglob("*.py"), *(ROOT / "estimators").rglob("*.py")]):
        if path.is_relative_to(ROOT / "estimators" / "sentences"):
            continue
        source = path.read_text()
        if "sentences import" not in source:
            continue
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "say":
                code = node.args[0].value if isinstance(node.args[0], ast.Constant) else None
                names = frozenset(keyword.arg or "**" for keyword in node.keywords)
                found.append((f"{path.relative_to(ROOT)}:{node.lineno}", code, names))
    return found


def expected(code: str) -> frozenset[str]:
    entry = ENGLISH[code]
    return frozenset(name for name, _ in places(entry)) | (
        frozenset() if isinstance(entry, str) else {"count"}
    )


def test_what_is_said_is_in_the_catalogue_with_its_parameters():
    for where, code, names in said():
        assert code is not None, f"{where}: write the code out, so that it can be found"
        words = of_estimators.ENGLISH if where.startswith("estimators") else ENGLISH
        assert code in words, f"{where}: no sentence {code}"
        assert names == expected(code), f"{where}: {code} has the parameters {sorted(expected(code))}"


def test_nothing_in_the_catalogue_is_left_over():
    kinds = {
        form.partition("|")[0] for entry in ENGLISH.values() for _, form in places(entry) if is_of_codes(form)
    }
    names = {code for code in ENGLISH if code.rpartition(".")[0] in kinds | KINDS}
    assert set(ENGLISH) - names - {code for _, code, _ in said()} - set(SAID_BY_LIBRARY) == set()
    assert kinds <= {code.rpartition(".")[0] for code in names}, "a place refers to names that nobody wrote"


def test_no_code_is_written_twice():
    rooms = [
        importlib.import_module(f"app.sentences.{path.stem}").ENGLISH
        for path in (ROOT / "app" / "sentences").glob("[!_]*.py")
    ]
    assert sum(len(room) for room in [of_estimators.ENGLISH, *rooms]) == len(ENGLISH)


@pytest.mark.parametrize(("language", "sentences"), [("en", CLIENT_WORDS), ("de", GERMAN)])
def test_the_client_has_the_same_sentences(language, sentences):
    shared = json.loads((ROOT / "web" / "src" / "i18n" / language / "sentences.json").read_text())
    assert shared == sentences, "run `npm run api` in web/ and commit the result"


def test_every_sentence_is_said_in_german_with_the_same_places():
    assert set(GERMAN) == set(CLIENT_WORDS)
    assert sum(len(room.GERMAN) for room in german.ROOMS) == len(GERMAN), "a code is written twice"
    for code, entry in CLIENT_WORDS.items():
        translated = GERMAN[code]
        assert isinstance(translated, str) == isinstance(entry, str), code
        if isinstance(entry, str) or isinstance(translated, str):
            assert set(places(translated)) == set(places(entry)), code
        else:
            assert set(places(translated["other"])) == set(places(entry["other"])), code
            assert set(places(translated["one"])) <= set(places(entry["other"])), code


TOLD_ERRORS = {"CalibrationError", "ComparisonError", "ContradictionError"}
"""Their messages reach people. Those of `ShapeError`, and of `SetupError` about parameters, are for programmers."""
TOLD_LISTS = {"reasons", "told", "said", "wanted", "wrong", "sentences", "findings", "doubts"}
FOR_PROGRAMMERS = ("simulation",)
"""Rooms of the library that nobody hears of on a screen."""
KERNELS_BESIDE = {"_coil_calibration.py", "_place_calibration.py"}
"""Kernels import these through their package: with sentences in them each changed word would compile kernels anew."""


def texts_put_together() -> list[str]:
    """Places of the library where people are told text without a code."""
    found = []
    for path in sorted((ROOT / "estimators").rglob("*.py")):
        if path.name in KERNELS_BESIDE or set(FOR_PROGRAMMERS) & set(path.parts):
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.Call) or not node.args:
                continue
            name = node.func
            is_error = isinstance(name, ast.Name) and name.id in TOLD_ERRORS
            is_list = (
                isinstance(name, ast.Attribute)
                and name.attr == "append"
                and isinstance(name.value, ast.Name | ast.Attribute)
                and (name.value.id if isinstance(name.value, ast.Name) else name.value.attr) in TOLD_LISTS
            )
            text = node.args[0]
            is_plain = isinstance(text, ast.JoinedStr | ast.BinOp) or (
                isinstance(text, ast.Constant) and isinstance(text.value, str) and " " in text.value
            )
            if (is_error or is_list) and is_plain:
                found.append(f"{path.relative_to(ROOT)}:{node.lineno}")
    return found


def test_what_the_library_tells_people_has_a_code():
    assert texts_put_together() == []
