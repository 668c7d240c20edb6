"""Compiled kernels are out of date when anything changes that went into them."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from estimators import _kernel_cache
from estimators._kernel_cache import imported_files


def tree(root: Path) -> Path:
    room = root / "room"
    room.mkdir()
    (room / "__init__.py").write_text("from room.outside import something\n")
    (room / "outside.py").write_text("something = 1\n")
    (room / "layout.py").write_text("PLACE = 3\n")
    (room / "helper.py").write_text("import math\nfrom room import layout\n")
    (room / "kernel.py").write_text("import numpy as np\nfrom room.helper import step\n")
    return room


def test_imports_are_followed_and_no_further(tmp_path):
    room = tree(tmp_path)
    assert imported_files(room / "kernel.py", tmp_path) == tuple(
        room / name for name in ("helper.py", "kernel.py", "layout.py")
    )
    (room / "other.py").write_text("from room import something\n")
    assert imported_files(room / "other.py", tmp_path) == tuple(
        room / name for name in ("__init__.py", "other.py", "outside.py")
    )


def files_that(imports: str, folder: Path) -> set[str]:
    """Names of the modules of a small package that a file with this text imports."""
    package = folder / "p"
    package.mkdir(exist_ok=True)
    for name in ("a", "b", "c"):
        (package / f"{name}.py").touch()
    file = folder / "file.py"
    file.write_text(imports)
    return {one.stem for one in _kernel_cache._direct(file, folder)}


@pytest.mark.parametrize(
    "text",
    [
        "import p.a, p.b as x\n",
        "from p import a, b\n",
        "from p import a as y, b  # and no more\n",
        "from p import (\n    a,  # of f(x)\n    b,\n)\n",
        "from p import a, \\\n    b\n",
        "import p.a; import p.b\n",
        "def f():\n    from p import a\n    if f: import p.b\n",
        "from p.a import(x)\nfrom p.b import *\n",
        "\ufefffrom p import a\r\nfrom p import (b)\r\n",
        "'As\n    from p import (\nsaid.'\nfrom p import (a, b)\n",
    ],
)
def test_every_form_of_import_is_seen(text, tmp_path):
    assert files_that(text, tmp_path) == {"a", "b"}


def test_what_only_looks_like_an_import_is_none(tmp_path):
    text = "# from p import a\nimportant = 1\nfrom pathlib import Path\nx = 'import p.b'\n"
    assert files_that(text, tmp_path) == set()


def test_no_import_of_the_house_is_missed():
    """As the syntax trees of its files have them."""
    root = Path(_kernel_cache.__file__).parents[1]
    files = [file for room in ("estimators", "app") for file in (root / room).rglob("*.py")]
    assert len(files) > 500
    for file in files:
        wanted: set[Path] = set()
        for node in ast.walk(ast.parse(file.read_bytes())):
            if isinstance(node, ast.Import):
                wanted.update(path for name in node.names for path in _kernel_cache._module(name.name, root))
            elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
                for name in node.names:
                    whole = f"{node.module}.{name.name}"
                    wanted.update(
                        _kernel_cache._module(whole, root) or _kernel_cache._module(node.module, root)
                    )
        assert wanted <= set(_kernel_cache._direct(file, root)), file


def test_installed_beside_numba_only_our_own_files_count(tmp_path):
    room = tree(tmp_path)
    (tmp_path / "numpy").mkdir()
    (tmp_path / "numpy" / "__init__.py").touch()
    assert room / "kernel.py" in imported_files(room / "kernel.py", tmp_path)
    assert not any("numpy" in file.parts for file in imported_files(room / "kernel.py", tmp_path))


def test_modules_that_import_each_other_end(tmp_path):
    room = tree(tmp_path)
    (room / "layout.py").write_text("import room.helper\n")
    assert room / "helper.py" in imported_files(room / "helper.py", tmp_path)


@pytest.mark.slow
def test_an_edited_helper_is_compiled_again(tmp_path):
    """In processes of their own, as after an update of the service."""
    package = tmp_path / "estimators"
    package.mkdir()
    (package / "__init__.py").touch()
    for name in ("_kernels.py", "_kernel_cache.py", "compiling.py"):
        (package / name).write_bytes((Path(_kernel_cache.__file__).parent / name).read_bytes())
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
    (package / "helper.py").write_text("PLACE = 5.0\n")
    assert run() == ["6.0", "0"]
