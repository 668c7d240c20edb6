"""What storing costs: `python -m tests.benchmarks.bench_store`.

Sessions of 17 nine-axis sensors at 100 Hz, 5 ticks a packet, with the frames that the live pipeline finds of them.
Printed are microseconds of processor time of this thread for a second of one session, by part, bytes an hour, and
what it costs to read it back.
"""

import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from app import tables as tables
from app.database.base import new_id
from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.gateway import stream_of
from app.network.raw_packet import RawPacket
from app.recordings.models import MotionSession
from app.recordings.signals.chunks import (
    decode_frames,
    decode_packets,
    encode_frames,
    encode_packets,
)
from app.recordings.signals.group_commit import GroupCommitWriter
from estimators import pipelines
from estimators.conventions import PLACEMENTS
from estimators.pipelines import Frames
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.benchmarks.machine import processor
from tests.benchmarks.service import make_patient

SESSIONS, SECONDS, PACKETS_A_SECOND = 20, 20, 20


def recorded() -> tuple[list[RawPacket], list[Frames]]:
    """Return packets and their frames of `SECONDS` of movement."""
    schedule = Schedule(n_pose_s=4.0, repetitions=None, duration_s=8.0 + SECONDS)
    made = simulate_arm(
        ArmScenario(both_arms=True, exercise="drinking", placements=PLACEMENTS, schedule=schedule)
    )
    frames, _ = pipelines.run(made.recording, made.setup, pose_s=(1.0, 3.5))
    frames = replace(frames, segment_sigma_rad=None)
    counts = stream_of(made.recording).counts
    packets, parts = [], []
    for number in range(SECONDS * PACKETS_A_SECOND):
        tick = 800 + 5 * number
        packets.append(
            RawPacket(
                sequence=number,
                device_time_us=number * 50_000,
                tick_interval_us=10_000,
                sensor_count=len(PLACEMENTS),
                tick_count=5,
                channel_mask=7,
                encoding=1,
                flags=0,
                payload=np.ascontiguousarray(counts[tick : tick + 5], "<i2").tobytes(),
                arrival_ns=1_700_000_000_000_000_000 + number * 50_000_000 + number * 7919 % 100_003,
            )
        )
        part = frames.ticks(tick, tick + 5)
        # As the pipeline gives them: arrays of their own.
        parts.append(
            replace(part, **{n: v.copy() for n, v in vars(part).items() if isinstance(v, np.ndarray)})
        )
    return packets, parts


def cost_us(work: Callable[[int], Any]) -> float:
    """Return the median processor time of this thread for each of the seconds."""
    work(0)
    times = []
    for second in range(SECONDS):
        start = time.thread_time_ns()
        work(second)
        times.append((time.thread_time_ns() - start) / 1e3)
    return median(times)


def sessions_of(url: str, patient_id: str, engine: Any) -> list[str]:
    """Make the sessions' rows."""
    with unit_of_work(engine) as session:
        from app.patients.models import Patient

        clinic_id = session.get_one(Patient, patient_id).clinic_id
        found = [
            MotionSession(
                id=new_id(), clinic_id=clinic_id, patient_id=patient_id, setup={}, created_by="x" * 32
            )
            for _ in range(SESSIONS)
        ]
        session.add_all(found)
        return [one.id for one in found]


def main() -> int:
    packets, parts = recorded()

    def second_of(items: list[Any], second: int) -> list[Any]:
        return items[second * PACKETS_A_SECOND : (second + 1) * PACKETS_A_SECOND]

    print(f"machine   {processor()}; {SESSIONS} sessions, {SECONDS} s, 17 sensors at 100 Hz\n")
    rows = [
        ("pack packets", cost_us(lambda s: encode_packets(second_of(packets, s)))),
        ("pack frames", cost_us(lambda s: encode_frames(*second_of(parts, s)))),
    ]
    raw = [encode_packets(second_of(packets, s)) for s in range(SECONDS)]
    kept = [encode_frames(*second_of(parts, s)) for s in range(SECONDS)]
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        url, patient_id = make_patient(Path(name))
        engine = create_from_url(url)
        sessions = sessions_of(url, patient_id, engine)
        writer = GroupCommitWriter(engine)
        for session_id in sessions:
            writer.open_session(session_id)

        def take(second: int) -> None:
            for session_id in sessions:
                for packet, part in zip(second_of(packets, second), second_of(parts, second), strict=True):
                    writer.append_packet(session_id, packet)
                    writer.append_frames(session_id, "0" * 32, part)

        taken, committed = [], []
        for second in range(SECONDS):
            start = time.thread_time_ns()
            take(second)
            middle = time.thread_time_ns()
            # A tenth of the sessions a commit, as they fall due in service.
            due = writer._take_due(everything=True)
            for first in range(0, len(due), SESSIONS // 10):
                writer._commit(due[first : first + SESSIONS // 10])
            taken.append((middle - start) / 1e3 / SESSIONS)
            committed.append((time.thread_time_ns() - middle) / 1e3 / SESSIONS)
        assert writer.metrics.packets_stored == SESSIONS * SECONDS * PACKETS_A_SECOND
        engine.dispose()
    rows += [
        ("take packets and frames (event loop)", median(taken)),
        ("commit, packing included", median(committed)),
        ("read packets back", cost_us(lambda s: decode_packets(raw[s]))),
        ("read frames back", cost_us(lambda s: decode_frames(kept[s], parts[0].layout))),
    ]
    for title, value in rows:
        print(f"{title:<40}{value:9.0f} us a session second")
    for title, chunks in (("packets", raw), ("frames", kept)):
        size = sum(len(chunk.data) for chunk in chunks) / SECONDS * 3600 / 1e6
        print(f"{title:<40}{size:9.1f} MB a session hour")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
