"""Functions stay readable: at most twelve parameters, and one screen of code without the docstring."""

import ast
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
MOST_PARAMETERS = 12
MOST_LINES = 60
MOST_LONG = 20
"""So many functions may be longer, each named below with its reason."""

MANY_PARAMETERS: dict[str, str] = {}
_ONE_PASS = "one pass of a kernel over its state: what it carries on would go through every step's parameters"
LONG = {
    "estimators/balance/_live_balance_kernel:balance_live": _ONE_PASS,
    "estimators/balance/mass_centre/_worn_kernel:mass_centre": _ONE_PASS,
    "estimators/kinetics/_live_shoes_kernel:shoes_live": _ONE_PASS,
    "estimators/magnetic/relative/pulse:predict_path": "one derivation, line by line, with its Jacobian",
    "estimators/magnetic/relative/pulse:pulse_value": "walks outwards from the middle of a pulse; all sums are its own",
    "estimators/magnetic/relative/run:end_pulse": "the states of a source, one after the other",
    "estimators/magnetic/relative/run:tick": "the order of a tick, most lines a call",
    "estimators/magnetic/relative/update:update_pulse": "an iterated correction with its early ends",
    "estimators/orientation/_frozen:frozen": "one test of freezing; its notes explain it as a whole",
    "estimators/orientation/_screen:_judge": _ONE_PASS,
    "estimators/orientation/smoother/_kernel:backward": _ONE_PASS,
    "estimators/orientation/telemotion/_field:find_north": "one search with its fallbacks",
    "estimators/orientation/telemotion/_kernel:end_block": "the order of a block, most lines a call",
    "estimators/orientation/telemotion/_block:predict": "one prediction of all states, a block of the matrix a line",
    "estimators/orientation/telemotion/_kernel:follow": "the filter's loop over ticks",
    "estimators/orientation/telemotion/_parameters:settings_of": "one line a setting",
    "estimators/orientation/telemotion/_start:collect": "collects a start, sample by sample",
}

Function = ast.FunctionDef | ast.AsyncFunctionDef


def functions(tree: ast.AST, prefix: str = "") -> Iterator[tuple[str, Function]]:
    """Yield every function with its dotted name inside the module, classes and outer functions before it."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | Function):
            name = f"{prefix}{node.name}"
            if isinstance(node, Function):
                yield name, node
            yield from functions(node, f"{name}.")
        else:
            yield from functions(node, prefix)


def parameters(function: Function) -> int:
    a = function.args
    each = len(a.posonlyargs) + len(a.args) + len(a.kwonlyargs)
    return each + (a.vararg is not None) + (a.kwarg is not None)


def lines(function: Function) -> int:
    """Return the lines from `def` to the end, the docstring not counted."""
    whole = (function.end_lineno or 0) - function.lineno + 1
    first = function.body[0]
    is_docstring = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
    if is_docstring and isinstance(first.value.value, str):
        whole -= (first.end_lineno or 0) - first.lineno + 1
    return whole


def measured(most: int, size: Callable[[Function], int]) -> dict[str, int]:
    found = {}
    for top in ("app", "estimators"):
        for path in sorted((ROOT / top).rglob("*.py")):
            module = path.relative_to(ROOT).with_suffix("").as_posix()
            for name, function in functions(ast.parse(path.read_text(encoding="utf-8"))):
                count = size(function)
                if count > most:
                    found[f"{module}:{name}"] = count
    return found


def check(found: dict[str, int], excused: dict[str, str], what: str) -> None:
    new = {name: count for name, count in found.items() if name not in excused}
    assert not new, f"{what}: divide them, or say in the list why not: {new}"
    stale = sorted(set(excused) - set(found))
    assert not stale, f"excused, but short by now or gone: take them off the list: {stale}"


def test_no_function_has_more_parameters_than_a_reader_can_hold():
    check(measured(MOST_PARAMETERS, parameters), MANY_PARAMETERS, f"more than {MOST_PARAMETERS} parameters")


def test_functions_fit_on_one_screen():
    check(measured(MOST_LINES, lines), LONG, f"more than {MOST_LINES} lines without docstring")
    assert len(LONG) <= MOST_LONG, f"{len(LONG)} long functions; {MOST_LONG} are allowed"


def test_what_is_measured_is_what_is_said():
    source = """
class A:
    async def f(self, /, a, *b, c=1, **d):
        'Two
        lines.'
        return 1
""".replace("'", '"' * 3)
    [(name, function)] = functions(ast.parse(source))
    assert (name, parameters(function), lines(function)) == ("A.f", 5, 2)
