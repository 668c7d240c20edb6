"""Every sentence that is said stands in the catalogue with exactly its parameters, and none is left over."""

import ast
import functools
import json
from pathlib import Path

import pytest

from estimators.sentences._formats import UNITS, parts
from estimators.sentences._message import Plural, parsed, places
from tests.words import ENGLISH, GERMAN, titles

ROOT = Path(__file__).resolve().parents[2]
LANGUAGES = {"en": ENGLISH, "de": GERMAN}
SAID_BY_LIBRARY = ("text.lines",)
"""By `Catalogue.together`."""
KINDS = {"place", "side", "level", "state"}
"""Names that places may refer to as whole lists, or that the client says labels with; others where a place does."""
ALIKE = {"estimator_title.telemotion", "estimator_title.vqf"}
"""Titles that are the same in German."""


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


def test_what_is_said_is_in_the_catalogue_with_its_parameters():
    for where, code, names in said():
        assert code is not None, f"{where}: write the code out, so that it can be found"
        assert code in ENGLISH, f"{where}: no sentence {code}"
        expected = {place.name for place in places(parsed(ENGLISH[code]))}
        assert names == expected, f"{where}: {code} has the parameters {sorted(expected)}"


def test_nothing_in_the_catalogue_is_left_over():
    kinds = {
        place.style.partition(" ")[0]
        for words in ENGLISH.values()
        for place in places(parsed(words))
        if place.kind == "code"
    }
    names = {code for code in ENGLISH if code.rpartition(".")[0] in kinds | KINDS}
    assert set(ENGLISH) - names - {code for _, code, _ in said()} - set(SAID_BY_LIBRARY) == set()
    assert kinds <= {code.rpartition(".")[0] for code in names}, "a place refers to names that nobody wrote"


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_file_has_each_code_once_and_in_order(language):
    words = json.dumps(LANGUAGES[language], indent=2, sort_keys=True, ensure_ascii=False) + "\n"
    assert (ROOT / "messages" / f"{language}.json").read_text("utf-8") == words


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_place_is_of_a_known_kind_and_style(language):
    styles = {"": {""}, "plural": {""}, "list": {"", "or", "lines"}}
    for code, words in LANGUAGES[language].items():
        assert "#" not in words, f"{code}: write the name of the number, the parser does not know #"
        for place in places(parsed(words)):
            if place.kind == "number":
                assert parts(place.style)[0] in UNITS, code
            elif place.kind == "code":
                assert place.style.partition(" ")[2] in ("", "or"), code
            else:
                assert place.style in styles[place.kind], code


def test_every_sentence_is_said_in_german_with_the_same_places():
    of_classes = titles()
    assert set(GERMAN) == {*ENGLISH, *of_classes}
    assert not set(ENGLISH) & set(of_classes)
    assert {code for code, title in of_classes.items() if GERMAN[code] == title} == ALIKE
    for code in of_classes:
        assert not list(places(parsed(GERMAN[code]))), code
    for code, words in ENGLISH.items():
        ours, theirs = parsed(words), parsed(GERMAN[code])
        assert set(places(theirs)) == set(places(ours)), code
        plurals = [[one for one in message if isinstance(one, Plural)] for message in (ours, theirs)]
        assert len(plurals[0]) == len(plurals[1]), code
        for plural, other in zip(*plurals, strict=True):
            assert plural.branches.keys() == other.branches.keys() == {"one", "other"}, code
            most = set(places(plural.branches["other"]))
            assert set(places(other.branches["other"])) == most, code
            assert set(places(other.branches["one"])) <= most, code


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
