"""A command loads what it needs: explaining itself and refusing a file take no seconds of imports."""

import subprocess
import sys

import pytest

SCIENCE = {"scipy.signal", "scipy.stats", "scipy.optimize", "scipy.spatial", "h5py", "vqf", "trimesh"}
HEAVY = SCIENCE | {"numba", "numpy", "pyarrow", "sqlalchemy", "fastapi", "viser"}


def imported_by(code: str) -> set[str]:
    code += "\nimport sys; print(' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


def test_the_command_line_explains_itself_without_the_library() -> None:
    code = "from typer.testing import CliRunner\nfrom app.cli import cli\nCliRunner().invoke(cli, ['--help'])"
    assert not imported_by(code) & HEAVY


@pytest.mark.parametrize("content", ["no recording", "a,b\n1,2\n"], ids=["text", "csv"])
def test_a_refused_file_loads_no_web_framework(tmp_path, content: str) -> None:
    file = tmp_path / "file.csv"
    file.write_text(content)
    code = (
        "from app.cli import cli\nfrom app.errors import TelemotionError\n"
        f"try:\n    cli(['process', {str(file)!r}, '--out', {str(tmp_path)!r}], standalone_mode=False)\n"
        "except TelemotionError:\n    pass\nelse:\n    raise SystemExit('not refused')"
    )
    found = imported_by(code)
    assert not found & (SCIENCE | {"fastapi", "viser", "pyarrow.parquet"})


@pytest.mark.slow
def test_the_service_starts_without_what_only_analyses_need() -> None:
    found = imported_by("import app.main")
    assert not found & (SCIENCE | {"httpx", "estimators.validation", "estimators.simulation"})
