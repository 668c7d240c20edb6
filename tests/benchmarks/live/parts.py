"""Kinds of sessions that a live load is made of: what a session asks for, and what its gateway sends when."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, get_args

import numpy as np

from app.commands.simulation.walk import WalkOptions, walk_of
from app.gateway import DeviceStream, stream_of
from app.gateway.encoding import EPOCH_US
from app.network.messages import PROTOCOL_VERSION, HelloMessage
from app.network.packet import PacketFlag, encode_packet, with_flags
from app.recordings.schemas import SessionIn
from estimators import pipelines
from estimators.channels import Channel
from estimators.conventions import PLACEMENTS, Placement
from estimators.recording import ImuChunk
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from estimators.simulation.faults import LinkFaults, plan_delivery
from tests.benchmarks.estimation.bench_magnetic import PACKET_TICKS, RATE_HZ, session
from tests.benchmarks.live.sockets import client_frame

SHORTEST_S, REPEATED_S = 15.0, 60.0
"""So much of a movement is simulated, for at least one repetition; what is longer begins anew, with a jump."""
RESENT_AFTER_S = 1.1
"""A gateway brings what is missing a second after it sent it, see `app.gateway.client`."""


@dataclass(frozen=True)
class Part:
    """Sessions of one kind.

    Attributes
    ----------
    name : str
        For people.
    wanted : SessionIn
        What is created; the patient's id is filled in.
    hello : callable(ticket) -> HelloMessage
    packets : sequence of bytes
        The same for all sessions of the part.
    packet_s : float
    """

    name: str
    wanted: SessionIn
    hello: Callable[[str], HelloMessage]
    packets: Sequence[bytes]
    packet_s: float

    @cached_property
    def frames(self) -> list[bytes]:
        """Packets as WebSocket frames."""
        return [client_frame(data) for data in self.packets]

    def late(self, number: int) -> bytes:
        """Return a packet's frame marked as back-filled."""
        data = self.packets[number]
        return client_frame(with_flags(data, data[9] | PacketFlag.BACKFILLED))

    def events(self, loss: float, seed: int) -> Iterator[tuple[float, int, bytes]]:
        """Yield when each packet is sent, its number and its frame; the link loses some of them the first time.

        A link that loses packets swaps neighbours and delays packets besides; each packet is sent once in the end.
        """
        if loss == 0.0:
            yield from ((number * self.packet_s, number, frame) for number, frame in enumerate(self.frames))
            return
        faults = LinkFaults(loss_fraction=loss, reorder_fraction=loss, jitter_sd_s=0.2 * self.packet_s)
        plan = plan_delivery(len(self.frames), self.packet_s, faults, seed)
        events = [
            (float(due) - self.packet_s, int(number), self.frames[number])
            for due, number in zip(plan.send_s, plan.packet, strict=True)
        ]
        lost = np.flatnonzero(plan.is_lost).tolist()
        events += [(number * self.packet_s + RESENT_AFTER_S, number, self.late(number)) for number in lost]
        yield from sorted(events, key=lambda one: one[0])


def part_of(name: str, wanted: SessionIn, stream: DeviceStream, packet_count: int) -> Part:
    """Return a part whose sessions send the first packets of a stream."""
    packets = [stream.packet(number) for number in range(packet_count)]
    return Part(name, wanted, stream.hello, packets, stream.packet_s)


def longer(stream: DeviceStream, seconds: float) -> DeviceStream:
    """Return a stream that begins anew until it has lasted so long."""
    times = int(seconds * stream.rate_hz // len(stream.counts)) + 1
    return replace(stream, counts=np.tile(stream.counts, (times, 1, 1)))


def moving_arms(seconds: float) -> tuple[DeviceStream, dict[str, Any]]:
    """Return seventeen sensors of a body whose arms move, and its calibration from the pose before."""
    scenario = ArmScenario(
        both_arms=True,
        exercise="drinking",
        placements=PLACEMENTS,
        schedule=Schedule(
            n_pose_s=10.0, repetitions=None, duration_s=min(max(seconds, SHORTEST_S), REPEATED_S) + 10.0
        ),
    )
    simulated = simulate_arm(scenario)
    _, setup = pipelines.run(simulated.recording, simulated.setup, pose_s=(5.0, 9.0))
    stream = stream_of(simulated.recording)
    # Without the pose: the sessions begin calibrated, in the middle of the movement.
    rest = round(10.0 * stream.rate_hz)
    return longer(replace(stream, counts=stream.counts[rest:]), seconds), setup.to_dict()["calibration"]


def arms(seconds: float) -> tuple[Part, dict[str, Any]]:
    """Return sessions of calibrated arms, and the calibration that their patient must have."""
    stream, calibration = moving_arms(seconds)
    wanted = SessionIn(patient_id="", placements=list(PLACEMENTS))
    return part_of("arms", wanted, stream, int(seconds / stream.packet_s)), calibration


def walks(seconds: float) -> Part:
    """Return sessions of shoes with forces under them."""
    _, measured, apart_m = walk_of(WalkOptions(steps=60))
    stream = stream_of(measured)
    placements = [name for placed in stream.placements for name in get_args(Placement) if name == placed]
    wanted = SessionIn(
        patient_id="",
        pipeline="gait",
        placements=placements,
        rate_hz=stream.rate_hz,
        use_mounting=False,
        feet_apart_m=apart_m,
    )
    whole = len(stream.counts) // stream.ticks_per_packet * stream.ticks_per_packet
    stream = longer(replace(stream, counts=stream.counts[:whole]), seconds)
    return part_of("walks with forces", wanted, stream, int(seconds / stream.packet_s))


def magnetic_packets(whole: ImuChunk, packet_count: int) -> list[bytes]:
    """Return packets of a source and a sensor, float32; what is longer than the recording begins anew."""
    assert whole.magnetometer_t is not None
    assert whole.coil_state is not None
    parts = (
        whole.gyroscope_radps,
        whole.accelerometer_mps2,
        whole.magnetometer_t,
        whole.coil_state[..., None],
    )
    values = np.concatenate(parts, axis=2).transpose(1, 0, 2).astype("<f4")
    channels = Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.MAGNETOMETER | Channel.COIL_STATE
    there = len(values) // PACKET_TICKS
    return [
        encode_packet(
            values[PACKET_TICKS * (number % there) : PACKET_TICKS * (number % there + 1)],
            sequence=number,
            device_time_us=EPOCH_US + round(1e6 * PACKET_TICKS * number / RATE_HZ),
            tick_interval_us=round(1e6 / RATE_HZ),
            channels=channels,
        )
        for number in range(packet_count)
    ]


def magnetic(seconds: float) -> Part:
    """Return sessions of a source and a sensor at 120 Hz, with pulses as the filter asks for them."""
    setup, whole = session(1)
    placements = list(setup.placements)
    wanted = SessionIn(
        patient_id="", pipeline="relative_pose", placements=placements, rate_hz=RATE_HZ, use_mounting=False
    )
    packet_s = PACKET_TICKS / RATE_HZ

    def hello(ticket: str) -> HelloMessage:
        return HelloMessage(
            protocol_version=PROTOCOL_VERSION,
            ticket=ticket,
            placements=placements,
            rate_hz=RATE_HZ,
            device="bench",
            firmware="1",
        )

    packets = magnetic_packets(whole, int(seconds / packet_s))
    return Part("magnetic source", wanted, hello, packets, packet_s)
