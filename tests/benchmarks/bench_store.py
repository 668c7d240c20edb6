"""What storing costs: `python -m tests.benchmarks.bench_store`.

Fifty sessions of 17 nine-axis sensors at 100 Hz, 5 ticks a packet, with the frames that the live pipeline finds of
them. Printed are microseconds of processor time of this thread for a second of one session, by part, with every tick's
frames and with those that a live session of the arms keeps; what it costs to read them back; megabytes an hour by
stream, and what the database's file grew by.
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
from app.kinds.arm.kind import KIND
from app.network.raw_packet import RawPacket
from app.recordings.models import MotionSession, Result
from app.recordings.signals.chunks import (
    decode_frames,
    decode_packets,
    encode_frames,
    encode_packets,
)
from app.recordings.signals.group_commit import GroupCommitWriter
from estimators import pipelines
from estimators.conventions import PLACEMENTS
from estimators.pipelines import Frames, SessionSetup
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.benchmarks.machine import processor
from tests.benchmarks.service import make_patient

SESSIONS, SECONDS, PACKETS_A_SECOND = 50, 20, 20
RATE_HZ = 100.0
STRIDE = KIND.live_stride(RATE_HZ)


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


def sessions_of(url: str, patient_id: str, engine: Any, stride: int) -> list[tuple[str, str]]:
    """Make the sessions' rows; return the ids of each and of its live result."""
    with unit_of_work(engine) as session:
        from app.patients.models import Patient

        clinic_id = session.get_one(Patient, patient_id).clinic_id
        setup = SessionSetup("arm", PLACEMENTS, RATE_HZ).to_dict()
        pairs = [(new_id(), new_id()) for _ in range(SESSIONS)]
        fields = {"clinic_id": clinic_id, "patient_id": patient_id, "setup": setup, "created_by": "x" * 32}
        session.add_all(MotionSession(id=session_id, **fields) for session_id, _ in pairs)
        session.flush()
        version = {
            "pipeline": "arm",
            "pipeline_version": "1",
            "orientation": "vqf",
            "orientation_version": "1",
        }
        session.add_all(
            Result(
                id=result_id,
                session_id=session_id,
                kind="live",
                setup=setup,
                layout={},
                stride=stride,
                **version,
            )
            for session_id, result_id in pairs
        )
        return pairs


def second_of(items: list[Any], second: int) -> list[Any]:
    """Return the packets, or their frames, of a second."""
    return items[second * PACKETS_A_SECOND : (second + 1) * PACKETS_A_SECOND]


def stored(packets: list[RawPacket], parts: list[Frames], stride: int) -> tuple[float, float, float]:
    """Store all sessions; return us a session second to take and to commit, and MB a session hour of the file."""
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        url, patient_id = make_patient(Path(name))
        engine = create_from_url(url)
        sessions = sessions_of(url, patient_id, engine, stride)
        writer = GroupCommitWriter(engine)
        for session_id, _ in sessions:
            writer.open_session(session_id)
        before = file_bytes(Path(name))
        taken, committed = [], []
        for second in range(SECONDS):
            start = time.thread_time_ns()
            for session_id, result_id in sessions:
                for packet, part in zip(second_of(packets, second), second_of(parts, second), strict=True):
                    writer.append_packet(session_id, packet)
                    writer.append_frames(session_id, result_id, part)
            middle = time.thread_time_ns()
            # A tenth of the sessions a commit, as they fall due in service.
            due = writer._take_due(everything=True)
            for first in range(0, len(due), SESSIONS // 10):
                writer._commit(due[first : first + SESSIONS // 10])
            taken.append((middle - start) / 1e3 / SESSIONS)
            committed.append((time.thread_time_ns() - middle) / 1e3 / SESSIONS)
        assert writer.metrics.packets_stored == SESSIONS * SECONDS * PACKETS_A_SECOND
        engine.dispose()
        grown = (file_bytes(Path(name)) - before) / SESSIONS / SECONDS * 3600 / 1e6
    return median(taken), median(committed), grown


def file_bytes(folder: Path) -> int:
    """Return the size of the database; its journal is a buffer, not a store."""
    return sum(path.stat().st_size for path in folder.glob("*.db"))


def main() -> int:
    packets, parts = recorded()
    print(f"machine   {processor()}; {SESSIONS} sessions, {SECONDS} s, 17 sensors at 100 Hz\n")
    raw = [encode_packets(second_of(packets, s)) for s in range(SECONDS)]
    pack_raw = cost_us(lambda s: encode_packets(second_of(packets, s)))
    print(f"{'':<34}{'every tick':>14}{f'every {STRIDE}th':>14}")
    columns = []
    for stride in (1, STRIDE):
        kept = [encode_frames(*second_of(parts, s), stride=stride) for s in range(SECONDS)]
        pack = cost_us(lambda s, n=stride: encode_frames(*second_of(parts, s), stride=n))
        take, commit, grown = stored(packets, parts, stride)
        sizes = [sum(len(chunk.data) for chunk in chunks) / SECONDS * 3600 / 1e6 for chunks in (raw, kept)]
        columns.append(
            {
                "pack packets, us": pack_raw,
                "pack frames, us": pack,
                "take packets and frames, us": take,
                "commit, packing included, us": commit,
                "taken and committed, us": take + commit,
                "read packets back, us": cost_us(lambda s: decode_packets(raw[s])),
                "read frames back, us": cost_us(lambda s, k=kept: decode_frames(k[s], parts[0].layout)),
                "packets, MB an hour": sizes[0],
                "frames, MB an hour": sizes[1],
                "both, MB an hour": sum(sizes),
                "the file, MB an hour": grown,
            }
        )
    for title in columns[0]:
        print(f"{title:<34}" + "".join(f"{column[title]:14.1f}" for column in columns))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
