"""Kernels that came with the package: compiled where it was built, for any x86-64 processor with AVX2."""

import functools
import json
import platform
import sys
from pathlib import Path
from typing import Any, Final

import llvmlite.binding as llvm
import numba
import numpy as np

FOLDER: Final = Path(__file__).parents[1] / "_compiled"
PROCESSOR: Final = "x86-64-v3"
_FEATURES: Final = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")
"""What that level of processors has beside its forerunner."""
_LABEL: Final = "built.json"


def built_here() -> dict[str, str]:
    """Return what kernels that are compiled here fit to, as `label` writes it."""
    return {
        "machine": f"{sys.platform} {platform.machine()}",
        "python": f"{sys.version_info.major}.{sys.version_info.minor}",
        "numba": numba.__version__,
        "numpy": np.__version__,
    }


def label(folder: Path) -> None:
    """Say in a folder of kernels what they fit to."""
    (folder / _LABEL).write_text(json.dumps(built_here(), indent=1) + "\n", encoding="utf-8")


def is_labelled(folder: Path) -> bool:
    """Say whether a folder is one of such kernels."""
    return (folder / _LABEL).is_file()


@functools.cache
def why_unused(folder: Path = FOLDER) -> str | None:
    """Return why the kernels that came with the package cannot be used here; None where they can, or none came."""
    try:
        fits = json.loads((folder / _LABEL).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except ValueError:
        return f"{_LABEL} cannot be read"
    here = built_here()
    for name, value in fits.items():
        if here.get(name) != value:
            return f"{name} is {here.get(name)} here, and they are for {value}"
    features = llvm.get_host_cpu_features()
    missing = [name for name in _FEATURES if not features.get(name)]
    if missing:
        return f"they need a processor with {', '.join(missing)}"
    return None


def is_used() -> bool:
    """Say whether kernels came with the package and fit, and those that are compiled are for this processor."""
    return numba.config.CPU_NAME is None and is_labelled(FOLDER) and why_unused() is None


def key_of(signature: Any) -> tuple[Any, ...]:
    """Return the key under which an index of these kernels has a signature."""
    return signature, (llvm.get_process_triple(), PROCESSOR, "")
