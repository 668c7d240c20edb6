"""What the service tells people has a code: no refusal, event or reason is plain English put together in place.

Found in the syntax trees: what errors are made of, what events and tasks are told, what fields of answers and rows
are set to. A name is followed to what it was given in its function, else in its module.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXEMPT = {
    "app/commands/": "the command line speaks English, as its options do",
    "app/demo/": "makes the demonstration, on the command line",
    "app/gateway/": "programs of the command line that send what a gateway would",
    "app/database/": "starting, migrating and restoring, read in a terminal before anybody can sign in",
}
"""Rooms whose errors nobody reads in a browser, with the reason."""
LAST = {"_tell": 3, "tell": 3, "progress": 1, "_change": 1, "answer": 2}
"""Functions that tell people something, and the place of the words among their arguments."""
FIELDS = {"text", "message", "reason", "reason_text", "state_reason", "hint", "trouble", "warning", "title"}
FIELDS |= {"instruction", "summary", "calibration_hint"}
"""Fields of rows and answers that people read."""
Found = tuple[int, str]


@cache
def bases_of_classes() -> dict[str, set[str]]:
    """Bases by class, of the whole tree."""
    found: dict[str, set[str]] = {}
    for room in ("app", "estimators"):
        for path in (ROOT / room).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.ClassDef):
                    names = {ast.unparse(base).rpartition(".")[2] for base in node.bases}
                    found.setdefault(node.name, set()).update(names - {node.name})
    return found


def descendants(of: set[str]) -> set[str]:
    bases, found = bases_of_classes(), set(of)
    while more := {name for name, parents in bases.items() if parents & found} - found:
        found |= more
    return found


@cache
def errors() -> set[str]:
    return descendants({"TelemotionError", "EstimationError"})


@cache
def spoken() -> set[str]:
    return descendants({"Spoken"}) | {"SessionEvent", "add_event"}


def is_plain(node: ast.expr | None, given: dict[str, list[ast.expr]]) -> bool:
    """Whether an expression is English text put together in place."""
    match node:
        case ast.Constant():
            return isinstance(node.value, str) and " " in node.value
        case ast.JoinedStr() | ast.BinOp():
            return True
        case ast.IfExp():
            return is_plain(node.body, given) or is_plain(node.orelse, given)
        case ast.BoolOp():
            return any(is_plain(value, given) for value in node.values)
        case ast.Call():
            called = ast.unparse(node.func)
            # The words of another error are its `message`, with their code; `str` loses it.
            return called == "str" or (called[0] in "'\"" and called.endswith((".join", ".format")))
        case ast.Subscript():
            return isinstance(node.slice, ast.Slice) and is_plain(node.value, given)
        case ast.Name():
            values = given.get(node.id, [])
            return any(is_plain(value, {**given, node.id: []}) for value in values)
    return False


def given_names(body: ast.AST, *, deep: bool) -> dict[str, list[ast.expr]]:
    found: dict[str, list[ast.expr]] = {}
    for node in ast.walk(body) if deep else ast.iter_child_nodes(body):
        targets = node.targets if isinstance(node, ast.Assign) else []
        if isinstance(node, ast.AnnAssign | ast.AugAssign) and node.value is not None:
            targets = [node.target]
        for target in targets:
            if isinstance(target, ast.Name):
                found.setdefault(target.id, []).append(node.value)
    return found


def told(node: ast.AST) -> Iterator[ast.expr]:
    """Yield the words that a node tells somebody."""
    if isinstance(node, ast.Call):
        name = ast.unparse(node.func).rpartition(".")[2]
        if name in errors():
            yield from [*node.args[:1], *(k.value for k in node.keywords if k.arg == "message")]
        elif name in LAST and len(node.args) > LAST[name]:
            yield node.args[LAST[name]]
        elif name in spoken():
            yield from (k.value for k in node.keywords if k.arg in FIELDS)
    elif isinstance(node, ast.Assign):
        names = {target.attr for target in node.targets if isinstance(target, ast.Attribute)}
        if names & FIELDS:
            yield node.value


def plain_words(source: str) -> list[Found]:
    """Return line and expression of everything that a module tells people in plain words."""
    tree = ast.parse(source)
    of_module = given_names(tree, deep=False)
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    found: dict[tuple[int, int], Found] = {}
    for body, given in [(tree, of_module)] + [
        (function, {**of_module, **given_names(function, deep=True)}) for function in functions
    ]:
        for node in ast.walk(body):
            for words in told(node):
                if is_plain(words, given):
                    found[words.lineno, words.col_offset] = (words.lineno, ast.unparse(words)[:120])
    return sorted(found.values())


@cache
def found_in_app() -> dict[str, list[Found]]:
    return {
        str(path.relative_to(ROOT)): found
        for path in sorted((ROOT / "app").rglob("*.py"))
        if (found := plain_words(path.read_text()))
    }


def test_nobody_is_told_anything_in_plain_words():
    wrong = [
        f"{path}:{line} {words}"
        for path, found in found_in_app().items()
        for line, words in found
        if not path.startswith(tuple(EXEMPT))
    ]
    assert not wrong, "use `say` of estimators.sentences:\n" + "\n".join(wrong)


@pytest.mark.parametrize("room", EXEMPT)
def test_no_room_is_exempt_for_nothing(room):
    assert any(path.startswith(room) for path in found_in_app())


@pytest.mark.parametrize(
    "line",
    [
        "raise NotFound('There is none.')",
        "raise InvalidInput(f'Row {row} is wrong.', field='row')",
        "raise Conflict('This ' + state + ' cannot be.')",
        "raise InvalidInput(str(error)) from error",
        "return RecordingFormatError('; '.join(problems))",
        "raise Unavailable(message='Try again later.')",
        "raise Conflict(say('live.closed') if closed else 'Not closed.')",
        "GONE = 'It is gone.'\nraise NotFound(GONE)",
        "def f(n):\n    text = f'{n} are wrong.'\n    raise InvalidInput(text)",
        "raise CalibrationError(f'{name}: not still', redo=['rest'])",
        "session.add_event('error', 1.0, text='Something failed.')",
        "row = SessionEvent(kind='mark', text='; '.join(reasons)[:500])",
        "context.progress(0.1, 'Reading the file')",
        "self._change('failed', 'The link broke.')",
        "self.hint = f'Hold {name} still.'",
        "return SeriesOut(reason='No sensors on the thighs.')",
    ],
)
def test_plain_words_are_found(line):
    assert plain_words(line)


@pytest.mark.parametrize(
    "line",
    [
        "raise NotFound(say('session.not_found'))",
        "raise InvalidInput(error.message, field='setup') from error",
        "GONE = say('session.not_found')\nraise NotFound(GONE)",
        "raise PacketError(say('packet.crc'), reason='not_finite')",
        "raise ValueError('a programmer reads this')",
        "self.hint = ''",
        "session.add_event('mark', 1.0, text=note)",
        "found.message = CATALOGUE.together([one, other])",
        "log.warning('session %s is closed', name)",
    ],
)
def test_sentences_are_let_pass(line):
    assert not plain_words(line)


def test_a_module_says_what_it_is() -> None:
    """Its first line is a noun phrase; one that begins with "What" leaves the noun to the reader."""
    paths = [
        path
        for room in ("app", "estimators", "messages", "published", "validation")
        for path in (ROOT / room).rglob("*.py")
    ]
    asks = [path for path in paths if path.read_text().lstrip().startswith('"""What ')]
    assert not asks, "CONTRIBUTING.md, Plain English"
