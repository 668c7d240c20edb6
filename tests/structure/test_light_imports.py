"""A command loads what it needs: explaining itself and refusing a file take no seconds of imports."""

import json
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


REFUSED = {
    "nonsense": ("file.bin", bytes(range(256)) * 80, ()),
    "ending of no format": ("file.csv.old", b"time,x", ()),
    "text": ("file.csv", b"no recording", ()),
    "table without a mapping": ("file.csv", b"a,b\n1,2\n", ()),
    "table that says nothing": ("file.csv", b"a,b\n1,2\n", ("--guess",)),
    "broken table": ("file.csv", b"t,x,y,z\n1,2,3,word\n2,3,word,4\n", ("--mapping",)),
    "missing": ("file.csv", None, ()),
}
MAPPING = {
    "time_column": "t",
    "signals": [
        {"quantity": quantity, "columns": ["x", "y", "z"], "unit": unit}
        for quantity, unit in (("gyroscope", "rad/s"), ("accelerometer", "m/s^2"))
    ],
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_refused_file_loads_neither_estimators_nor_the_service(tmp_path, case: str) -> None:
    name, content, options = REFUSED[case]
    file = tmp_path / name
    if content is not None:
        file.write_bytes(content)
    if "--mapping" in options:
        (tmp_path / "mapping.json").write_text(json.dumps(MAPPING))
        options = ("--mapping", str(tmp_path / "mapping.json"))
    command = ["process", str(file), *options, "--out", str(tmp_path / "out")]
    # As the installed command begins, refusal and all.
    code = (
        "import sys\nfrom app.cli import main\n"
        f"sys.argv = ['telemotion', *{command!r}]\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert end.code == 2, end.code\n"
        "else:\n    raise SystemExit('not refused')"
    )
    found = imported_by(code)
    packages = {name.partition(".")[0] for name in found}
    assert not packages & {"numba", "scipy", "sqlalchemy", "fastapi", "viser", "h5py"}
    assert not found & {"pyarrow.parquet", "estimators.orientation", "app.settings"}
    if case in ("nonsense", "ending of no format", "missing"):
        assert "pyarrow" not in packages


def test_estimating_a_file_loads_nothing_of_the_service() -> None:
    found = imported_by("import app.commands.processing.estimate")
    assert not {name.partition(".")[0] for name in found} & {
        "fastapi",
        "sqlalchemy",
        "viser",
        "pyarrow",
        "h5py",
    }


@pytest.mark.slow
def test_the_service_starts_without_what_only_analyses_need() -> None:
    found = imported_by("import app.main")
    assert not found & (SCIENCE | {"httpx", "validation", "estimators.simulation"})
