"""What live sessions with a magnetic source cost the service, by part. No limit is set; a lost packet fails it.

Run: `python -m tests.benchmarks.bench_magnetic_live` from the root. Starts the real service (one process, as
`telemotion serve` does, on a fresh SQLite file) and sends it sessions at 120 Hz from this other process: a source and a
sensor, float32, 5 ticks a packet, pulses as the filter asks for them, storage on, each watched by a dashboard. Every
two milliseconds of its processor time the service notes what its event loop is at, hence the parts.
"""

import argparse
import json
import signal
import sys
import tempfile
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
import psutil

from tests.benchmarks.estimation.bench_magnetic import PACKET_TICKS, SECONDS
from tests.benchmarks.live.load import WARM_UP_S, Load, open_all
from tests.benchmarks.live.parts import magnetic
from tests.benchmarks.live.watching import stored
from tests.benchmarks.machine import processor
from tests.benchmarks.service import make_patient, start_server
from tests.ports import free_port

OTHER = "threads of the store; web server"
PARTS = (
    ("pipeline", "app/live/session/estimation.py"),
    ("actuation", "app/live/session/actuation.py"),
    ("alignment", "app/network/alignment.py"),
    ("packet to values", "app/network/packet.py"),
    ("values to signals", "app/network/unpack.py"),
    ("store, on the loop", "app/recordings/signals/group_commit.py"),
    ("frame blocks", "app/live/blocks.py"),
    ("checks of the first seconds", "app/live/checks/first_seconds.py"),
    ("health", "app/live/checks/health.py"),
    ("acknowledging", "app/live/session/ledger.py"),
    ("rest of the session", "app/live/session/runner.py"),
    ("to dashboards", "app/live/watch_socket.py"),
    ("from and to gateways", "app/ingest/websocket.py"),
    ("housekeeping", "app/live/housekeeping.py"),
    ("manager", "app/live/manager.py"),
)
"""A stack is of the part that its innermost file among these is of."""
SAMPLER = """
import collections, json, signal
stacks = collections.Counter()

def take(_number, frame):
    files = []
    while frame is not None:
        files.append(frame.f_code.co_filename)
        frame = frame.f_back
    stacks["|".join(dict.fromkeys(files))] += 1

def write(*_):
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    with open({path!r}, "w") as file:
        json.dump(stacks, file)

signal.signal(signal.SIGPROF, take)
signal.signal(signal.SIGUSR1, lambda *_: signal.setitimer(signal.ITIMER_PROF, 0.002, 0.002))
signal.signal(signal.SIGUSR2, write)
"""


def by_part(stacks: dict[str, int]) -> dict[str, float]:
    """Return the share of each part of all stacks; what has none is of other threads, or within the web server."""
    shares = dict.fromkeys([name for name, _ in PARTS], 0.0)
    total = sum(stacks.values())
    for stack, count in stacks.items():
        files = stack.split("|")
        part = next(
            (name for file in files for name, ending in PARTS if file.endswith(ending) and ending), OTHER
        )
        shares[part] = shares.get(part, 0.0) + count / total
    return shares


def main() -> int:
    """Print the cost of a session by part."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sessions", type=int, default=10)
    given = parser.parse_args()
    part = magnetic(SECONDS)
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        folder = Path(name)
        url, patient_id = make_patient(folder)
        port = free_port()
        told = folder / "stacks.json"
        process = start_server(url, folder, port, SAMPLER.format(path=str(told)))
        server = psutil.Process(process.pid)
        try:
            opened = open_all(port, patient_id, [(part, given.sessions)])
            begin = threading.Timer(WARM_UP_S + 0.5, process.send_signal, [signal.SIGUSR1])
            begin.start()
            before = {one.id: one.user_time + one.system_time for one in server.threads()}
            outcome = Load(opened, server).run(until_s=SECONDS)
            process.send_signal(signal.SIGUSR2)
            threads = sorted(
                (one.user_time + one.system_time - before.get(one.id, 0.0), one.id == process.pid)
                for one in server.threads()
            )
            time.sleep(1.0)
            stacks = json.loads(told.read_text())
        finally:
            process.terminate()
            process.wait(30)
        kept = stored(folder)["raw"][1] // PACKET_TICKS
    each = 100.0 * outcome.server_cpu / given.sessions
    print(f"machine: {processor()}, {given.sessions} sessions, {SECONDS:.0f} s")
    print(f"of one core: {100 * outcome.server_cpu:.1f} % in all, {each:.2f} % a session")
    spent = sum(seconds for seconds, _ in threads)
    print(f"on the event loop: {100 * sum(s for s, is_loop in threads if is_loop) / spent:.0f} % of it")
    print(f"\n{'part':<48} {'share':>8} {'% of a core a session':>24}")
    for part, share in sorted(by_part(stacks).items(), key=lambda one: -one[1]):
        print(f"{part:<48} {100 * share:>7.1f}% {share * each:>24.3f}")
    latency = np.percentile(outcome.published_ms, [50, 99])
    print(f"\npacket sent -> frame published: median {latency[0]:.1f} ms, 99 % {latency[1]:.1f} ms")
    print(f"packets {outcome.sent} sent, {kept} stored")
    return 0 if kept == outcome.sent else 1


if __name__ == "__main__":
    sys.exit(main())
