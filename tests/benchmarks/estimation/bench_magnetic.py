"""Cost of relative pose by a magnetic source on one core: fields a second, and a live session at 120 Hz.

Run: `python -m tests.benchmarks.estimation.bench_magnetic` from the root, or `make bench-magnetic`.
Ends with status 1 if field and gradient of a coil are evaluated less often than `REQUIRED_FIELDS` a second, or if the
pipeline of a session at 120 Hz, as the product sets it up and in packets of `PACKET_TICKS` as the network sends them,
takes more than `REQUIRED_SHARE` of a core. Beside it stands what the same packets cost where `POOLED` sessions share a
pool, as in the live engine, whose calls take a packet of each. Times are those of the processor, best of several runs.
"""

import argparse
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import numpy as np

from estimators import pipelines
from estimators.conventions import Placement
from estimators.magnetic import RelativeFlag, coil_state, perpendicular_source
from estimators.magnetic import _loop_kernel as kernel
from estimators.magnetic.published import predict
from estimators.magnetic.relative import layout as at
from estimators.pipelines import RelativePosePipeline, SessionSetup
from estimators.pipelines.pooled import STRETCH, StepPool
from estimators.pipelines.relative.pool import RelativePool
from estimators.recording import ImuChunk
from estimators.simulation.coils import relative_motion, relative_scene, run_closed_loop
from tests.benchmarks.machine import processor

REQUIRED_FIELDS = 1e6
REQUIRED_SHARE = 0.01
POINTS, SECONDS, RATE_HZ, PACKET_TICKS = 100_000, 20.0, 120.0, 5
POOLED = 20


@dataclass(frozen=True)
class Share:
    """What a session takes: of a core, and for a packet; and whether that is judged."""

    name: str
    core: float
    packet_us: float
    is_judged: bool


def best(call: Callable[[], object], repetitions: int) -> float:
    """Return the least processor time of a call."""
    times = []
    for _ in range(repetitions):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return min(times)


def field_rates(repetitions: int) -> dict[str, float]:
    """Return evaluations a second: field and gradient of a loop, and prediction of a pulse with its Jacobian."""
    rng = np.random.default_rng(1)
    direction = rng.normal(size=(POINTS, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    points = np.ascontiguousarray(direction * rng.uniform(0.15, 0.8, (POINTS, 1)))
    q = rng.normal(size=(POINTS, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    coil, current = np.arange(POINTS) % 3, np.ones(POINTS)
    rates = {}
    for name, source in (
        ("exact loop", perpendicular_source(0.06)),
        ("dipole", perpendicular_source(0.06).with_model("dipole")),
    ):
        field, gradient = np.empty((POINTS, 3)), np.empty((POINTS, 3, 3))
        loops = source.loops
        spent = best(lambda: kernel.coil_fields(loops, coil, current, points, field, gradient), repetitions)  # noqa: B023
        rates[f"{name}, field and gradient"] = POINTS / spent
    source = perpendicular_source(0.06)
    spent = best(lambda: predict(source, coil, current, points, q), repetitions)
    rates["exact loop, pulse and Jacobian in sensor axes"] = POINTS / spent
    return rates


def session(sensors: int) -> tuple[SessionSetup, ImuChunk]:
    """Return a walk as the network would deliver it, pulses as the product's own filter asks for them."""
    names: tuple[Placement, ...] = ("pelvis", "thigh_right", "thigh_left")[: sensors + 1]
    setup = SessionSetup("relative_pose", names, RATE_HZ)
    pipeline = pipelines.create(setup)
    assert isinstance(pipeline, RelativePosePipeline)
    one = pipeline.filters["thigh_right"]
    scene = relative_scene(one.source, relative_motion("walk_leg", SECONDS, 1), SECONDS, RATE_HZ, seed=1)
    _, samples = run_closed_loop(scene, one, seed=1)
    # The second sensor goes with the first: the same work, and the pulses suit both.
    columns = (
        [at.SOURCE_GYROSCOPE, *[at.GYROSCOPE] * sensors],
        [at.SOURCE_ACCELEROMETER, *[at.ACCELEROMETER] * sensors],
    )
    rate, force = (np.stack([samples[:, c : c + 3] for c in each]) for each in columns)
    field = np.stack([scene.source_ambient_t, *[samples[:, at.FIELD : at.FIELD + 3]] * sensors])
    state = np.zeros((sensors + 1, len(samples)))
    state[0] = coil_state(samples[:, at.COIL].astype(int), samples[:, at.CURRENT])
    quality = np.zeros(state.shape, dtype=np.uint8)
    return setup, ImuChunk(0, scene.time_step_s, rate, force, field, quality, coil_state=state)


def session_shares(repetitions: int) -> list[Share]:
    """Return shares of a core that whole sessions take, from aligned samples to frames, in packets of some ticks."""
    shares = []
    for sensors in (1, 2):
        setup, whole = session(sensors)
        frames = pipelines.create(setup).step(whole)
        state = frames.scalar[:, frames.layout.scalars.index("thigh_right_state")].astype(int)
        tracked = float(np.mean((state & (RelativeFlag.INVALID | RelativeFlag.INERTIAL_ONLY)) == 0))
        assert tracked > 0.8, (
            f"this session has a pose only {100 * tracked:.0f} % of the time, so it costs too little"
        )
        for ticks in (1, PACKET_TICKS, 10):
            parts = [
                whole.ticks(k, min(k + ticks, whole.tick_count)) for k in range(0, whole.tick_count, ticks)
            ]

            def run() -> None:
                pipeline = pipelines.create(setup)  # noqa: B023
                for part in parts:  # noqa: B023
                    pipeline.step(part)

            spent = best(run, repetitions)
            name = f"sensors beside the source {sensors}, ticks a packet {ticks}"
            shares.append(Share(name, spent / SECONDS, 1e6 * spent / len(parts), ticks == PACKET_TICKS))
    return shares


def pooled_shares(repetitions: int) -> list[Share]:
    """Return what each of many sessions takes in a pool: called one by one, and in one compiled call."""
    setup, whole = session(1)
    parts = [
        whole.ticks(k, k + PACKET_TICKS) for k in range(0, whole.tick_count - PACKET_TICKS, PACKET_TICKS)
    ]
    assert whole.magnetometer_t is not None
    assert whole.coil_state is not None
    modules, rows = whole.sensor_count, 2 * PACKET_TICKS
    samples = modules * PACKET_TICKS
    stretches = np.zeros(POOLED, dtype=STRETCH)
    stretches["slot"], stretches["ticks"] = np.arange(POOLED), PACKET_TICKS
    for name, step in (("signals_at", 9 * samples), ("quality_at", samples), ("tick_at", rows)):
        stretches[name] = step * np.arange(POOLED)
    packets = []
    for part in parts:
        signals = np.stack([part.gyroscope_radps, part.accelerometer_mps2, part.magnetometer_t])
        given = (signals, part.quality, part.coil_state)
        packets.append((part.first_tick, *(np.tile(values.ravel(), POOLED) for values in given)))

    def spent(kind: type[RelativePool] | type[StepPool]) -> float:
        sessions = [pipelines.create(setup) for _ in range(POOLED)]
        pool = kind(sessions[0], 3, POOLED, POOLED * rows, {"coil_state": slice(0, 1)})
        for slot, one in enumerate(sessions):
            pool.join(slot, one)
        begin = time.process_time()
        for first_tick, signals, quality, carried in packets:
            stretches["first_tick"] = first_tick
            pool.step(stretches, POOLED, signals, quality, carried)
        taken = time.process_time() - begin
        assert not pool.errors
        for one in sessions:
            pool.stepped(one, whole.tick_count)
        return taken

    shares = []
    for kind, how in ((StepPool, "one by one"), (RelativePool, "compiled")):
        each = min(spent(kind) for _ in range(repetitions)) / POOLED
        name = f"one of {POOLED} in a pool, sensors 1, {how}"
        shares.append(Share(name, each / SECONDS, 1e6 * each / len(packets), False))
    return shares


def main() -> int:
    """Print both tables; return 1 if a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=5)
    repetitions = parser.parse_args().repetitions
    print(f"machine: {processor()}, Python {platform.python_version()}, one core, best of {repetitions}")
    rates = field_rates(repetitions)
    shares = session_shares(repetitions) + pooled_shares(repetitions)
    slow = [name for name, rate in rates.items() if "gradient" in name and rate < REQUIRED_FIELDS]
    print(f"\n{'fields':<48} {'1/s':>12} {'required':>12}")
    for name, rate in rates.items():
        required = f"{REQUIRED_FIELDS:,.0f}" if "gradient" in name else "-"
        print(f"{name:<48} {rate:>12,.0f} {required:>12}")
    title = f"relative pose at {RATE_HZ:.0f} Hz"
    print(f"\n{title:<48} {'% of a core':>12} {'required':>12} {'us / packet':>12}")
    for share in shares:
        required = f"<= {100 * REQUIRED_SHARE:g}" if share.is_judged else "-"
        print(f"{share.name:<48} {100 * share.core:>12.2f} {required:>12} {share.packet_us:>12.0f}")
        if share.is_judged and share.core > REQUIRED_SHARE:
            slow.append(share.name)
    print("required: " + (f"missed by {slow}" if slow else "met"))
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())
