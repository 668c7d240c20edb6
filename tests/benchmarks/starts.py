"""How long a service takes to its first session: `python -m tests.benchmarks.starts`.

The real service on a fresh SQLite file and an empty folder for compiled kernels; then the same again, with the kernels
of the first start. Asked for again and again is a session of an arm, of a walk with forces and of a magnetic source: it
is admitted when all its kernels are there. At last every kernel is compiled into an empty folder, as tests and images
do. Times are of this machine with all that it does beside: for figures that count let it do nothing else.

Required: the arm is admitted within 45 s of a first start, and a second start is ready within 6 s.
"""

import argparse
import asyncio
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import psutil

from app.recordings.schemas import SessionIn
from estimators.conventions import PLACEMENTS
from tests.app.live.live_load import swaying
from tests.benchmarks.live.load import Refusal, connect_one, create
from tests.benchmarks.live.parts import Part, magnetic, part_of, walks
from tests.benchmarks.live.report import judge, machine
from tests.benchmarks.service import (
    ROOT,
    environment_of,
    launch,
    make_patient,
    new_ticket,
    wait_until,
)
from tests.ports import free_port

FIRST_START_S, SECOND_START_S = 45.0, 6.0
SECONDS = 10.0
"""Of what sessions would send."""
LONGEST_S = 600.0
AGAIN_S = 0.2


def parts() -> tuple[list[Part], dict[str, object]]:
    """Return what is asked for, and the calibration of the patient."""
    calibration, stream = swaying(SECONDS)
    wanted = SessionIn(patient_id="", placements=list(PLACEMENTS))
    arm = part_of("arm", wanted, stream, stream.packet_count)
    return [arm, walks(SECONDS), magnetic(SECONDS)], calibration


@contextmanager
def started(environment: Mapping[str, str]) -> Iterator[tuple[float, float]]:
    """Start a service; yields the monotonic time of its start, and after how many seconds it is ready."""
    began_s = time.monotonic()
    process = launch(environment)
    try:
        wait_until(process, environment["TELEMOTION_BASE_URL"], "/api/ready")
        yield began_s, time.monotonic() - began_s
    finally:
        process.terminate()
        process.wait(60)


def admitted_s(port: int, patient_id: str, wanted: Sequence[Part], began_s: float) -> dict[str, float]:
    """Return after how many seconds a session of each part is admitted, one after the other."""
    found = {}
    made = asyncio.run(create(port, patient_id, [(part, 1) for part in wanted]))
    for one in made:
        ticket = one.ingest
        while isinstance(answer := connect_one(port, one, 0, ticket), Refusal):
            if time.monotonic() - began_s > LONGEST_S:
                raise TimeoutError(answer.message)
            time.sleep(AGAIN_S)
            ticket = asyncio.run(new_ticket(port, one.id))
        found[one.part.name] = time.monotonic() - began_s
        for connection in answer:
            connection.connection.close()
    return found


def compiled_s(environment: Mapping[str, str], processes: int) -> float:
    """Return how long every kernel takes into an empty folder."""
    began_s = time.monotonic()
    words = [sys.executable, "-m", "app.cli", "compile", "--processes", str(processes)]
    subprocess.run(words, cwd=ROOT, env=environment, check=True)
    return time.monotonic() - began_s


def main() -> int:
    """Print how long the starts take; return 1 when that is too long."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--processes", type=int, default=2, help="that compile every kernel at last; 0 for none"
    )
    arguments = parser.parse_args()
    wanted, calibration = parts()
    ready: list[float] = []
    first_s: list[dict[str, float]] = []
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        folder = Path(name)
        url, patient_id = make_patient(folder, calibration)
        for what in ("first", "second"):
            port = free_port()
            environment = environment_of(url, folder, port) | {"NUMBA_CACHE_DIR": str(folder / "kernels")}
            with started(environment) as (began_s, ready_s):
                ready.append(ready_s)
                print(f"{what} start: ready after {ready_s:.1f} s", flush=True)
                first_s.append(admitted_s(port, patient_id, wanted, began_s))
            for part, seconds in first_s[-1].items():
                print(f"{what} start: {part} admitted after {seconds:.1f} s", flush=True)
        if arguments.processes:
            environment |= {"NUMBA_CACHE_DIR": str(folder / "all kernels")}
            seconds = compiled_s(environment, arguments.processes)
            print(f"compile --processes {arguments.processes}: {seconds:.1f} s")
    print(f"machine   {machine()}, load {psutil.getloadavg()[0]:.1f}")
    arm_s = first_s[0]["arm"]
    found = {
        f"arm within {FIRST_START_S:.0f} s of a first start": (arm_s <= FIRST_START_S, f"{arm_s:.1f} s"),
        f"ready within {SECOND_START_S:.0f} s of a second start": (
            ready[1] <= SECOND_START_S,
            f"{ready[1]:.1f} s",
        ),
    }
    return 0 if judge(found) else 1


if __name__ == "__main__":
    sys.exit(main())
