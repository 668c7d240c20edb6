"""Cost of a moving body in the 3D view: share of one core at 60 pictures a second, with one watcher.

Run: `python -m tests.benchmarks.bench_viewer` from the root, or `python tests/benchmarks/bench_viewer.py`.
Figures include viser's own thread, which encodes and sends; the watcher runs in a process of its own.
"""

import argparse
import multiprocessing
import platform
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
import viser

from app.viewer.pose import PoseTrack, track_from_room
from app.viewer.scene import BodyScene
from estimators import rotation
from estimators.body import BodyDimensions
from estimators.conventions import SIDES

RATE_HZ = 60.0


def both_arms(duration_s: float) -> PoseTrack:
    """Trunk and both arms moving all the time: every segment turns at every picture."""
    time_s = np.arange(int(duration_s * RATE_HZ)) / RATE_HZ
    wave = 0.5 - 0.5 * np.cos(2 * np.pi * 0.4 * time_s)
    room = {"sternum": rotation.about_y(0.15 * wave)}
    for side in SIDES:
        room[f"upper_arm_{side}"] = rotation.about_y(-1.3 * wave)
        room[f"forearm_{side}"] = rotation.about_y(-1.3 * wave - 0.4)
        room[f"hand_{side}"] = rotation.about_y(-1.3 * wave - 0.5)
    return track_from_room(room, time_s, BodyDimensions())


def watch(port: int, received: Any) -> None:
    """Drain the socket as a browser would."""
    from websockets.sync.client import connect
    from websockets.typing import Subprotocol

    protocol = Subprotocol(f"viser-v{viser.__version__}")
    with connect(
        f"ws://127.0.0.1:{port}", subprotocols=[protocol], max_size=None, compression=None
    ) as socket:
        for message in socket:
            received.value += len(message)


def measure(duration_s: float, with_ghost: bool) -> tuple[float, float, float]:
    """Return share of a core, bytes a second, and milliseconds of one `draw` call."""
    track = both_arms(duration_s)
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    measured = frozenset(f"{s}_{side}" for side in SIDES for s in ("upper_arm", "forearm", "hand")) | {
        "sternum"
    }
    scene = BodyScene(server, BodyDimensions(), measured, "right", track if with_ghost else None, "right")
    context = multiprocessing.get_context("spawn")
    received = context.Value("q", 0)
    watcher = context.Process(target=watch, args=(server.get_port(), received), daemon=True)
    watcher.start()
    while received.value == 0:
        time.sleep(0.05)
    time.sleep(1.5)
    bytes_before, cpu_before, start = received.value, time.process_time(), time.perf_counter()
    drawing = 0.0
    for tick in range(len(track)):
        before = time.perf_counter()
        trail = track.hand_m[max(0, tick - 120) : tick + 1 : 2] if tick % 4 == 0 else None
        scene.draw(track, tick, trail)
        if with_ghost:
            scene.draw_ghost(100.0 * (tick % 150) / 150)
        drawing += time.perf_counter() - before
        time.sleep(max(0.0, start + (tick + 1) / RATE_HZ - time.perf_counter()))
    elapsed = time.perf_counter() - start
    share = (time.process_time() - cpu_before) / elapsed
    rate = (received.value - bytes_before) / elapsed
    watcher.terminate()
    server.stop()
    return share, rate, 1e3 * drawing / len(track)


def main() -> None:
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seconds", type=float, default=10.0)
    seconds = arguments.parse_args().seconds
    print(f"{platform.machine()}, Python {platform.python_version()}, viser {viser.__version__}")
    print(f"{'two arms and trunk at 60 Hz':32s} {'core':>7s} {'kB/s':>7s} {'ms a draw':>10s}")
    for with_ghost in (False, True):
        share, rate, draw_ms = measure(seconds, with_ghost)
        name = "with template ghost" if with_ghost else "without ghost"
        print(f"{name:32s} {share:7.1%} {rate / 1e3:7.1f} {draw_ms:10.2f}")


if __name__ == "__main__":
    main()
