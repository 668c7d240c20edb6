"""Live load on one machine: `make bench-live`.

Starts the real service (one process, as `telemotion serve` does, on a fresh SQLite file) and, in this other
process, the load: sessions of 17 nine-axis sensors at 100 Hz, 5 ticks a packet as int16 counts, calibrated,
with estimation and storage on, each watched by a dashboard. Every packet is encoded before and sent when its
last tick would have been measured; the sessions begin one after the other within five seconds of warming up.

Printed latencies use one clock, that of the machine. "Published" is the time stamp that the service puts into
a frame block when it gives the frames to the bus; it is compared with the moment before the packet was
written to the socket, so time in sockets and queues on the way in is included. The service's own figure
begins when it has read the packet. On a machine that does other work latencies are upper bounds.

`--mix` is 100 arms, 20 walks with forces under the shoes and 20 magnetic sessions, times `--scale`. `--minutes`
goes on for longer and prints the service's memory each minute, with the least that it held in it; growth is judged by
the least. `--loss 0.05` runs twice: with a sound link, then with one that loses packets, which come again a second
later, and swaps others; it compares what both cost.
"""

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import psutil

from tests.benchmarks.live.load import WARM_UP_S, Load, Outcome, open_all
from tests.benchmarks.live.parts import Part, arms, magnetic, walks
from tests.benchmarks.live.report import judge, judge_load, judge_memory, list_slow, print_load, stored_mb
from tests.benchmarks.live.watching import Memory, idle_mb, metrics, rare_share, stored
from tests.benchmarks.service import make_patient, start_server
from tests.ports import free_port

MIX = (100, 20, 20)
"""Arms, walks and magnetic sessions."""
MOST_FOR_A_BAD_LINK = 2.0
"""Times what a session costs over a sound one."""


def parts_of(
    arguments: argparse.Namespace, seconds: float
) -> tuple[list[tuple[Part, int]], dict[str, object]]:
    """Return the parts of the load with how many sessions of each, and the patient's calibration."""
    part, calibration = arms(seconds)
    if not arguments.mix:
        return [(part, arguments.sessions)], calibration
    counts = [max(1, round(arguments.scale * count)) for count in MIX]
    return list(zip((part, walks(seconds), magnetic(seconds)), counts, strict=True)), calibration


def measure(
    arguments: argparse.Namespace,
    parts: Sequence[tuple[Part, int]],
    calibration: dict[str, object],
    seconds: float,
    loss: float,
) -> tuple[bool, Outcome, int]:
    """Run a load on a service of its own, and print; returns whether all was met, what was found, and sessions."""
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        folder = Path(name)
        url, patient_id = make_patient(folder, calibration)
        port = free_port()
        process = start_server(url, folder, port)
        server = psutil.Process(process.pid)
        if arguments.server_pid_file:
            arguments.server_pid_file.write_text(str(process.pid))
        try:
            memory = Memory(server, idle_mb(server))
            opened = open_all(port, patient_id, parts)
            if opened.refusals:
                print(f"refused   {len(opened.refusals)} sessions: {opened.refusals[0].message}")
            print(f"running for {seconds:.0f} s ...", flush=True)
            load = Load(opened, server, loss=loss, together=arguments.together)
            begun: dict[str, float] = {}
            outcome = load.run(
                memory.note, lambda: (memory.note(0.0), begun.update(metrics(port))), until_s=seconds
            )
            memory.note((seconds - WARM_UP_S) / 60.0)
            rare = rare_share(begun, metrics(port))
        finally:
            process.terminate()
            process.wait(60)
        kept = stored(folder)
    sessions = len(opened.parts)
    print_load(outcome, opened, seconds)
    print(f"rare      {100 * rare:.2f} % of the packets took the general way")
    mb_an_hour = stored_mb(kept, outcome.streamed_s)
    found = judge_load(outcome, sessions, kept["raw"][1] // 5, mb_an_hour) | judge_memory(memory, sessions)
    if arguments.slow:
        list_slow(outcome)
    return judge(found), outcome, sessions


def main() -> int:
    """Print the table; return 1 when something that is required is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sessions", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=30.0, help="measured time, after 10 s of warming up")
    parser.add_argument("--minutes", type=float, help="measured time instead of --seconds")
    parser.add_argument("--mix", action="store_true", help="arms, walks with forces and magnetic sessions")
    parser.add_argument("--scale", type=float, default=1.0, help="times the sessions of --mix")
    parser.add_argument(
        "--loss", type=float, default=0.0, help="share of packets that a second run's link loses"
    )
    parser.add_argument("--together", action="store_true", help="all sessions send at the same moment")
    parser.add_argument("--slow", action="store_true", help="list the moments with latencies above 25 ms")
    parser.add_argument("--server-pid-file", type=Path, help="where to write the service's process id")
    arguments = parser.parse_args()
    measured_s = arguments.seconds if arguments.minutes is None else 60.0 * arguments.minutes
    seconds = measured_s + WARM_UP_S
    print("preparing the stream and the database ...", flush=True)
    parts, calibration = parts_of(arguments, seconds)
    is_met, sound, sessions = measure(arguments, parts, calibration, seconds, 0.0)
    if arguments.loss > 0.0:
        _, bad, admitted = measure(arguments, parts, calibration, seconds, arguments.loss)
        times = (bad.server_cpu / admitted) / (sound.server_cpu / sessions)
        what = (
            f"a link that loses {100 * arguments.loss:.0f} % costs at most"
            f" {MOST_FOR_A_BAD_LINK:.0f} times a sound one"
        )
        is_met = judge({what: (times <= MOST_FOR_A_BAD_LINK, f"{times:.2f} times")}) and is_met
    return 0 if is_met else 1


if __name__ == "__main__":
    sys.exit(main())
