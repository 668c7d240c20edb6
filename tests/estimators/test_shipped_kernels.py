"""Kernels that came with the package are used where they fit; elsewhere it is said why not."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from estimators.compiling import _shipped, label, why_unused

WORK = """
import sys
from pathlib import Path
from estimators.compiling import _shipped, compiled, only_cached

_shipped.FOLDER = Path("shipped")
_shipped.why_unused.__wrapped__.__defaults__ = (_shipped.FOLDER,)

@compiled("float64(float64)")
def shifted(x):
    return x + 1.0

with only_cached() if "only" in sys.argv else __import__("contextlib").nullcontext():
    print(shifted(1.0), sum(shifted.stats.cache_hits.values()), sys.argv[1:])
"""


def test_none_that_came_are_no_reason(tmp_path):
    assert why_unused(tmp_path) is None


def test_those_that_are_made_here_fit_here(tmp_path):
    label(tmp_path)
    assert (why_unused(tmp_path) or "processor").find("processor") >= 0


@pytest.mark.parametrize(
    ("name", "value"), [("numba", "0.1"), ("python", "3.2"), ("machine", "plan9 sparc")], ids=lambda one: one
)
def test_what_does_not_fit_is_named(name, value, tmp_path):
    label(tmp_path)
    file = tmp_path / "built.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {name: value}))
    assert value in (why_unused(tmp_path) or "")


def test_an_older_processor_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(_shipped.llvm, "get_host_cpu_features", lambda: {"avx": True, "avx2": False})
    label(tmp_path)
    assert "avx2" in (why_unused(tmp_path) or "")


@pytest.mark.slow
@pytest.mark.skipif(
    not _shipped.llvm.get_host_cpu_features().get("avx2"), reason="the processor is older than such kernels"
)
def test_a_carried_kernel_is_loaded_by_another_processor(tmp_path):
    """Compiled for the level x86-64-v3, loaded by a process that compiles for the processor it runs on."""
    (tmp_path / "work.py").write_text(WORK)
    shipped = tmp_path / "shipped"
    shipped.mkdir()

    def run(*words: str, **environment: str) -> str:
        done = subprocess.run(
            [sys.executable, "work.py", *words],
            cwd=tmp_path,
            env={"PATH": "", "NUMBA_CACHE_DIR": str(tmp_path / "cache"), **environment},
            capture_output=True,
            text=True,
            check=True,
        )
        return done.stdout

    run(NUMBA_CPU_NAME=_shipped.PROCESSOR, NUMBA_CPU_FEATURES="", NUMBA_CACHE_DIR=str(tmp_path / "made"))
    for file in Path(tmp_path, "made").rglob("*.nb[ci]"):
        file.rename(shipped / file.name)
    label(shipped)
    assert run("only").startswith("2.0 1")
