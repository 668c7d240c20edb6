"""Kernels are compiled or loaded when they are first needed, for the declared signature, once for every process."""

import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import codegen

from estimators.compiling import Kernel, NotCompiled, _kernel, _units, compiled, only_cached


def fresh(signature: str | None = "float64(float64)") -> Any:
    @compiled(signature)
    def doubled(x: float) -> float:
        return x + x

    return doubled


@pytest.fixture(autouse=True)
def nothing_is_remembered(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    made = len(Kernel.made)
    yield
    del Kernel.made[made:]


def test_nothing_is_compiled_before_the_first_call(monkeypatch, tmp_path):
    kernel = fresh()
    assert not kernel.signatures
    assert kernel(2.0) == 4.0
    assert len(kernel.signatures) == 1


def test_other_types_are_converted_or_refused_never_compiled():
    kernel = fresh()
    assert kernel(2) == 4.0
    assert isinstance(kernel(2), float)
    with pytest.raises(TypeError):
        kernel("two")
    assert len(kernel.signatures) == 1


def test_a_kernel_becomes_part_of_its_caller_and_no_machine_code_of_its_own():
    inner = fresh()

    @compiled("float64(float64)")
    def outer(x: float) -> float:
        return float(inner(x)) + 1.0

    assert outer(2.0) == 5.0
    assert not inner.signatures
    assert len(inner.part.overloads) == 1
    assert inner(4.0) == 8.0, "called from Python it is compiled all the same"


def test_a_step_without_a_signature_takes_what_its_callers_hand_over():
    inner = fresh(None)

    @compiled("float64(float64)")
    def outer(x: float) -> float:
        return float(inner(x)) + inner(1)

    assert outer(2.0) == 6.0
    assert len(inner.part.overloads) == 2


def test_a_step_that_several_parts_call_is_linked_wherever_it_is_called():
    @compiled(is_entry=False)
    def whole(x: float) -> int:
        return int(x)

    @compiled("float64(float64)", is_entry=False)
    def first(x: float) -> float:
        # The call is dropped by the optimiser; the other one is not.
        return x + (whole(x) if x != x and x == x else 0)

    @compiled("float64(float64)", is_entry=False)
    def second(x: float) -> float:
        return x + whole(x)

    @compiled("float64(float64)")
    def outer(x: float) -> float:
        return first(x) + second(x) + whole(x)

    assert outer(2.5) == 2.5 + 4.5 + 2.0


def test_code_of_others_is_compiled_as_ever_beside_kernels():
    """What numba made for a kernel, its own helpers among it, is taken in by a function of somebody else as well."""
    inner = fresh()

    @compiled("float64[::1](int64)")
    def filled(count: int) -> Any:
        found = np.zeros(count)
        found[:] = np.arange(count)
        return np.linalg.solve(np.eye(count), found) + inner(1.0)

    assert filled(3).tolist() == [2.0, 3.0, 4.0]

    @numba.njit
    def theirs(count: int) -> Any:
        found = np.zeros(count)
        found[:] = np.arange(count)
        return np.linalg.solve(np.eye(count), found) + inner(1.0) + filled(count)

    assert theirs(3).tolist() == [4.0, 6.0, 8.0]


def test_the_shorter_ways_were_tried_with_this_numba():
    """Else compiling takes half as long again, and nothing would say it: try them with the new one, then name it."""
    assert numba.__version__.startswith(f"{_units.TRIED_NUMBA}.")


def test_with_another_numba_its_own_ways_are_taken(monkeypatch):
    monkeypatch.setattr(_units, "TRIED_NUMBA", "0.1")
    assert fresh()(2.0) == 4.0


def test_numba_is_as_it_was_after_a_kernel_that_cannot_be_compiled():
    @compiled("float64(float64)")
    def wrong(x: float) -> float:
        return x.no_such_thing  # type: ignore[attr-defined]

    before = codegen.JITCPUCodegen._library_class
    with pytest.raises(numba.TypingError):
        wrong(1.0)
    assert codegen.JITCPUCodegen._library_class is before


def test_a_slice_of_another_length_is_refused():
    @compiled("float64[::1](float64[::1])")
    def written(values: Any) -> Any:
        found = np.zeros(3)
        found[:] = values
        return found

    assert written(np.ones(3)).tolist() == [1.0, 1.0, 1.0]
    with pytest.raises(ValueError, match="cannot assign slice from input of different size"):
        written(np.ones(4))


def test_only_entries_are_made_ready_beforehand():
    @compiled("float64(float64)", is_entry=False)
    def inner(x: float) -> float:
        return x

    entry = fresh()
    assert Kernel.made[-1] is entry
    assert inner not in Kernel.made


def test_a_failed_compilation_can_be_tried_again():
    @compiled("float64(float64)")
    def wrong(x: float) -> float:
        return x.nothing  # type: ignore[attr-defined]

    for _ in range(2):
        with pytest.raises(Exception, match="nothing"):
            wrong(1.0)


def test_a_step_has_its_signature_still_after_an_interrupted_compilation(monkeypatch):
    @compiled("float64(float64)", is_entry=False)
    def squared(x: float) -> float:
        return x * x

    @compiled("float64(int64)")
    def outer(n: int) -> float:
        return squared(n * 4_000_000_000)

    compile_extra = _units._PartCompiler.compile_extra

    def interrupted(*arguments: Any) -> Any:
        monkeypatch.setattr(_units._PartCompiler, "compile_extra", compile_extra)
        raise KeyboardInterrupt

    monkeypatch.setattr(_units._PartCompiler, "compile_extra", interrupted)
    with pytest.raises(KeyboardInterrupt):
        outer(2)
    # As an integer the square would overflow.
    assert outer(2) == 6.4e19


def test_two_threads_compile_once():
    kernel, answers = fresh(), []
    threads = [threading.Thread(target=lambda: answers.append(kernel(3.0))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == [6.0] * 4
    assert sum(kernel.stats.cache_misses.values()) + sum(kernel.stats.cache_hits.values()) <= 1


WORK = """
import sys
from estimators.compiling import NotCompiled, compiled, only_cached

@compiled("float64(float64)")
def shifted(x):
    return x + 1.0

if "only" in sys.argv:
    try:
        with only_cached():
            print(shifted(1.0))
    except NotCompiled:
        print("not compiled")
else:
    print(shifted(1.0), sum(shifted.stats.cache_hits.values()))
"""


def start(tmp_path: Path, *words: str) -> "subprocess.Popen[str]":
    script = tmp_path / "work.py"
    if not script.exists():
        script.write_text(WORK)
    return subprocess.Popen(
        [sys.executable, str(script), *words], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    )


def said(process: "subprocess.Popen[str]") -> str:
    text, _ = process.communicate(timeout=120)
    return text.strip()


@pytest.mark.slow("four processes import numba, and two of them compile")
def test_two_processes_compile_a_kernel_once(tmp_path):
    assert said(start(tmp_path, "only")) == "not compiled"
    both = [start(tmp_path), start(tmp_path)]
    assert sorted(said(one) for one in both) == ["2.0 0", "2.0 1"]
    assert said(start(tmp_path, "only")) == "2.0"


def test_compiling_is_refused_where_only_the_cache_may_be_used(monkeypatch):
    kernel = fresh()
    monkeypatch.setattr(_kernel._Cache.__mro__[1], "load_overload", lambda *_: None)
    with only_cached(), pytest.raises(NotCompiled):
        kernel(1.0)
    assert kernel(1.0) == 2.0
