"""A kernel is compiled again when anything changes that goes into its machine code, and for nothing else."""

import json
import pkgutil
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import estimators
from estimators.compiling import Kernel
from estimators.compiling._digest import digest

HELPER = '''
"""Of a test."""
import enum
import numpy as np

PLACE = 3.0
UNREAD = "a sentence"

class Flag(enum.IntFlag):
    GAP = 1

LAYOUT = np.dtype([("speed", "f8")])

def nothing():
    """Say {words}."""
    return PLACE
'''
WORK = '''
from estimators._kernels import step

@step()
def shifted(x, record):
    """Add {words}."""
    return x + at.PLACE + Flag.GAP + record[0].speed + LAYOUT.itemsize

def outer(x, record):
    return shifted(x, record) * 2.0
'''


def digest_of(helper: str = HELPER, work: str = WORK) -> bytes:
    """Digest of a kernel `outer` that takes in `shifted`, which reads constants of a helper."""
    at = ModuleType("estimators.helper_of_a_test")
    exec(compile(helper, "helper.py", "exec"), at.__dict__)
    names: dict[str, Any] = {"__name__": "estimators.work_of_a_test", "at": at}
    names |= {name: vars(at)[name] for name in ("Flag", "LAYOUT")}
    exec(compile(work, "work.py", "exec"), names)
    return digest(names["outer"])


@pytest.mark.parametrize(
    "change",
    [("PLACE = 3.0", "PLACE = 5.0"), ("GAP = 1", "GAP = 2"), ('"f8"', '"f4"'), ("speed", "pace")],
    ids=["constant", "flag", "type", "field"],
)
def test_a_changed_constant_of_another_file_counts(change):
    work = WORK.replace(*change) if change[0] == "speed" else WORK
    assert digest_of(HELPER.replace(*change), work) != digest_of()


@pytest.mark.parametrize(
    "change",
    [("x + at", "x - at"), ("* 2.0", "* 3.0"), ("@step()", "@step(inlined=True)")],
    ids=["operation", "constant", "option"],
)
def test_changed_code_of_the_kernel_or_of_its_steps_counts(change):
    assert digest_of(work=WORK.replace(*change)) != digest_of()


def of_text(text: str, name: str = "outer") -> bytes:
    names: dict[str, Any] = {"__name__": "estimators.work_of_a_test"}
    exec(compile(text, "work.py", "exec"), names)
    return digest(names[name])


SWAPPED = """
from estimators._kernels import step

@step()
def one(x):
    return 1.0 * x

@step()
def two(x):
    return 2.0 * x

def made(f, g):
    def outer(x):
        return f(x) - g(x)
    return outer

f, g = {order}

def outer(x):
    return f(x) - g(x)

closed = made({order})
"""


@pytest.mark.parametrize("name", ["outer", "closed"])
def test_steps_that_change_places_count(name):
    assert of_text(SWAPPED.format(order="one, two"), name) != of_text(SWAPPED.format(order="two, one"), name)


def test_steps_of_one_factory_that_change_places_count():
    text = """
from estimators._kernels import step

def scaled(by):
    @step()
    def inner(x):
        return by * x
    return inner

f, g = {order}

def outer(x):
    return f(x) - g(x)
"""
    assert of_text(text.format(order="scaled(1.0), scaled(2.0)")) != of_text(
        text.format(order="scaled(2.0), scaled(1.0)")
    )


@pytest.mark.parametrize(
    ("text", "change"),
    [
        (
            "import enum\nclass F(enum.IntFlag):\n A = 1\n B = 2\n C = 3\ndef outer(x): return x + F.C",
            ("C = 3", "C = 1"),
        ),
        (
            "import enum\nclass F(enum.IntEnum):\n A = 1\n B = 2\n C = 1\ndef outer(x): return x + F.C",
            ("C = 1", "C = 2"),
        ),
        ("def outer(x):\n 'ab'\n return len('ab')", ("len('ab')", "len('abc')")),
        (
            "import numpy as np\nT = (np.array([1.0]),)\ndef outer(x): return T[0][0]",
            ("[1.0]", "[1.00000000001]"),
        ),
        ("S = frozenset((1, 2))\ndef outer(x): return x in S", ("(1, 2)", "(1, 3)")),
    ],
    ids=["composite flag", "alias", "equal to the docstring", "array in a tuple", "set"],
)
def test_constants_of_every_kind_count(text, change):
    assert of_text(text) != of_text(text.replace(*change))


def test_a_constant_two_modules_away_counts():
    def found(value: float) -> bytes:
        inner, outer = ModuleType("estimators.inner_of_a_test"), ModuleType("estimators.outer_of_a_test")
        inner.CONST, outer.sub = value, inner  # type: ignore[attr-defined]
        names: dict[str, Any] = {"__name__": "estimators.work_of_a_test", "at": outer}
        exec("def f(x): return x + at.sub.CONST", names)
        return digest(names["f"])

    assert found(1.0) != found(2.0)


def test_words_lines_and_what_is_not_read_do_not_count():
    helper = "# A comment.\n\n" + HELPER.replace("{words}", "more").replace("a sentence", "another one")
    work = "import math\n# Moved down.\n\n" + WORK.replace("{words}", "other words")
    assert digest_of(helper, work) == digest_of()


def test_functions_that_call_each_other_end():
    names: dict[str, Any] = {"__name__": "estimators.work_of_a_test"}
    exec("def even(n): return n == 0 or odd(n - 1)\ndef odd(n): return n != 0 and even(n - 1)\n", names)
    assert digest(names["even"]) != digest(names["even"], "option")


NAMES = """
import json, sys
sys.path.insert(0, {root!r})
from tests_of_digests import digests
print(json.dumps(digests()))
"""
DIGESTS = """
def digests():
    import pkgutil
    from importlib import import_module
    import estimators
    from estimators.compiling._digest import digest
    from estimators.compiling import Kernel

    for module in pkgutil.walk_packages(estimators.__path__, "estimators."):
        import_module(module.name)
    return {
        f"{one.py_func.__module__}.{one.py_func.__name__}": digest(one.py_func, one.targetoptions, one.signature).hex()
        for one in Kernel.made
    }
"""


@pytest.mark.slow
def test_a_changed_sentence_recompiles_nothing_and_a_changed_filter_only_its_own(tmp_path):
    """The library with a comment on top of every file, another sentence, another error and another constant of VQF."""
    house = Path(estimators.__file__).parents[1]
    for package in ("estimators", "messages"):
        unneeded = shutil.ignore_patterns("__pycache__", "*.nb?")
        shutil.copytree(house / package, tmp_path / package, ignore=unneeded)
    for file in tmp_path.rglob("*.py"):
        if file.parent.name != "compiling":
            file.write_text("# Moved down by a line.\n" + file.read_text())
    edits = {
        "messages/en.json": ("steps", "paces"),
        "estimators/errors.py": (
            "class ShapeError",
            "class AnotherError(Exception):\n    pass\n\n\nclass ShapeError",
        ),
        "estimators/orientation/vqf/_steps.py": ("0.5 *", "0.25 *"),
    }
    for name, (before, after) in edits.items():
        text = (tmp_path / name).read_text()
        assert before in text, name
        (tmp_path / name).write_text(text.replace(before, after, 1))
    (tmp_path / "tests_of_digests.py").write_text(DIGESTS)
    done = subprocess.run(
        [sys.executable, "-c", NAMES.format(root=str(tmp_path))],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
    )
    edited: dict[str, str] = json.loads(done.stdout)

    for module in pkgutil.walk_packages(estimators.__path__, "estimators."):
        import_module(module.name)
    now = {
        f"{one.py_func.__module__}.{one.py_func.__name__}": digest(
            one.py_func, one.targetoptions, one.signature
        )
        for one in Kernel.made
        if one.py_func.__module__.startswith("estimators.")
    }
    changed = {name for name in now if edited.get(name) != now[name].hex()}
    assert len(now) > 50
    assert changed == {
        "estimators.orientation.vqf._kernel.run",
        "estimators.pipelines.relative.pooled_kernel.step_relative",
    }


@pytest.mark.slow
def test_an_edited_helper_is_compiled_again(tmp_path):
    """In processes of their own, as after an update of the service."""
    package = tmp_path / "estimators"
    package.mkdir()
    (package / "__init__.py").touch()
    house = Path(estimators.__file__).parent
    shutil.copy(house / "_kernels.py", package)
    shutil.copytree(house / "compiling", package / "compiling")
    (package / "helper.py").write_text("PLACE = 3.0\n")
    (package / "work.py").write_text(
        "from estimators._kernels import kernel\n"
        "from estimators.helper import PLACE\n\n\n"
        '@kernel("float64(float64)")\n'
        "def shifted(x):\n"
        "    return x + PLACE\n"
    )

    def run() -> list[str]:
        code = "from estimators.work import shifted as s; print(s(1.0), sum(s.stats.cache_hits.values()))"
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return done.stdout.split()

    assert run() == ["4.0", "0"]
    assert run() == ["4.0", "1"]
    (package / "helper.py").write_text('"""Only words."""\n\nPLACE = 3.0\n')
    assert run() == ["4.0", "1"]
    (package / "helper.py").write_text("PLACE = 5.0\n")
    assert run() == ["6.0", "0"]
