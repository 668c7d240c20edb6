"""Tries a wheel as somebody does who has nothing else: an empty environment, an empty home, an empty folder.

`make try-wheel` calls it. It prints how large the wheel is, how soon the demonstration answers and shows its live
patient, and whether a kernel was compiled. It fails where one was, where the past sessions do not appear, or where a
strict check does not find the types of the package `telemotion`.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
PATIENCE_S: Final = 600.0
PORT: Final = 8460
NOTEBOOK: Final = '''"""A notebook of ten lines, checked strictly."""

from pathlib import Path

import telemotion

found: telemotion.Processed = telemotion.process(telemotion.read(Path("walk.csv")))
table = found.table()
smoothed: telemotion.Processed = telemotion.smooth(telemotion.read("walk.csv"))
print(table, smoothed)
'''


def main(wheel: Path) -> int:
    """Try one wheel; return the exit code."""
    print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB")
    with tempfile.TemporaryDirectory(prefix="telemotion-wheel-") as name:
        folder = Path(name)
        binaries = installed(wheel, folder / "environment")
        home = folder / "home"
        home.mkdir()
        is_well = types_are_found(binaries, home) and demonstrates(binaries, home)
    return 0 if is_well else 1


def installed(wheel: Path, environment: Path) -> Path:
    """Install the wheel and what the service needs into a new environment; return the folder of its commands."""
    began_s = time.monotonic()
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    pip = [environment / "bin" / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "--require-hashes", "-r", ROOT / "requirements-service.lock"], check=True)
    subprocess.run([*pip, "--no-deps", wheel], check=True)
    print(f"installed after {time.monotonic() - began_s:.0f} s")
    return environment / "bin"


def types_are_found(binaries: Path, home: Path) -> bool:
    """Whether a strict check of a notebook knows the types of the package."""
    notebook = home / "notebook.py"
    notebook.write_text(NOTEBOOK, "utf-8")
    mypy = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--cache-dir", home / "types"]
    found = subprocess.run(
        [*mypy, "--python-executable", binaries / "python", notebook],
        cwd=home,
        capture_output=True,
        text=True,
        check=False,
    )
    print(f"types: {found.stdout.strip()}")
    return found.returncode == 0


def demonstrates(binaries: Path, home: Path) -> bool:
    """Start the demonstration; return whether the live patient and past sessions appear and nothing is compiled."""
    folder, log = home / "demonstration", home / "log.txt"
    surroundings = {"HOME": str(home), "PATH": os.defpath, "LANG": "C.UTF-8", "PYTHONUNBUFFERED": "1"}
    command = [binaries / "telemotion", "demo", "--port", str(PORT), "--folder", folder]
    with log.open("w") as output:
        demo = subprocess.Popen(command, cwd=home, env=surroundings, stdout=output, stderr=subprocess.STDOUT)
    wanted = {
        "answers": r"answers after (\d+) s",
        "live patient": r"live patient.*after (\d+) s",
        "past sessions": r"past sessions.*after (\d+) s",
    }
    try:
        seen = waited_for(demo, log, wanted)
    finally:
        demo.terminate()
        try:
            demo.wait(timeout=60)
        except subprocess.TimeoutExpired:
            demo.kill()
            demo.wait()
    # Numba stores what it compiles beside the source, or under the home.
    stored = [*binaries.parent.rglob("*.nbi"), *home.rglob("*.nbi")]
    compiled = [path for path in stored if "_compiled" not in path.parts]
    for what in wanted:
        print(f"{what}: {f'after {seen[what]} s' if what in seen else 'NOT SEEN'}")
    print(f"kernels compiled: {len(compiled)}")
    if len(seen) < len(wanted):
        print(log.read_text("utf-8", "replace"))
    return len(seen) == len(wanted) and not compiled


def waited_for(demo: subprocess.Popen[bytes], log: Path, wanted: dict[str, str]) -> dict[str, str]:
    """Return the seconds that the demonstration printed for each of what is wanted, as far as it came in time."""
    seen: dict[str, str] = {}
    began_s = time.monotonic()
    while len(seen) < len(wanted) and time.monotonic() - began_s < PATIENCE_S and demo.poll() is None:
        time.sleep(0.5)
        text = log.read_text("utf-8", "replace")
        found = {what: re.search(pattern, text, re.IGNORECASE) for what, pattern in wanted.items()}
        seen = {what: one.group(1) for what, one in found.items() if one}
    return seen


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: try_wheel.py WHEEL")
    sys.exit(main(Path(sys.argv[1])))
