"""Frames packet by packet give a guide the bits that the whole trajectory gives it."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.comparison import trajectory
from estimators.compiling import Kernel
from estimators.guidance import Guide, signals
from estimators.guidance.live import ChannelSelector
from estimators.orientation import OrientationFlag
from validation.guidance.sessions import STEP_S, streamed

PACKET = 5


@pytest.fixture(scope="module")
def guided():
    """Reaching, whose wrist steers: with a sensor lost, a singular angle, and numbers that are none."""
    ready, frames = streamed("no rest", 4)
    random = np.random.default_rng(8)
    shown = random.random(frames.segment_flags.shape) < 0.1
    singular = random.random(frames.angle_flags.shape) < 0.1
    points, angles, scalars = frames.point_room_m.copy(), frames.angle_rad.copy(), frames.scalar.copy()
    for values, broken in ((points, np.nan), (angles, np.inf), (scalars, np.nan)):
        values[random.random(values.shape) < 0.05] = broken
    lost = np.where(shown, np.uint8(OrientationFlag.INVALID), np.uint8(OrientationFlag.BRIDGED))
    flags = np.where(singular, np.uint8(OrientationFlag.SINGULAR), np.uint8(0))
    return ready, replace(
        frames,
        segment_flags=lost,
        angle_flags=flags,
        point_room_m=points,
        angle_rad=angles,
        scalar=scalars,
    )


def packets(frames):
    return [frames.ticks(start, start + PACKET) for start in range(0, frames.tick_count, PACKET)]


def test_what_is_picked_is_what_the_trajectory_gives(guided) -> None:
    ready, frames = guided
    picking = ChannelSelector(ready)
    values, sigma = (np.concatenate(one) for one in zip(*map(picking.pick, packets(frames)), strict=True))
    wanted, doubt = signals(trajectory(frames), ready)
    assert np.isnan(wanted).any()
    assert np.isfinite(wanted).mean() > 0.5
    assert values.tobytes() == wanted.tobytes()
    assert sigma.tobytes() == doubt.tobytes()


def test_a_channel_that_the_session_lacks_is_unknown(guided) -> None:
    ready, frames = guided
    fewer = replace(
        frames,
        layout=replace(frames.layout, scalars=frames.layout.scalars[1:]),
        scalar=np.ascontiguousarray(frames.scalar[:, 1:]),
    )
    picking = ChannelSelector(ready)
    picking.pick(frames)
    values, _ = picking.pick(fewer)
    assert np.isnan(values[:, ready.channels.index(frames.layout.scalars[0])]).all()
    assert values.tobytes() == signals(trajectory(fewer), ready)[0].tobytes()


def test_the_guide_says_the_same_of_packets_as_of_the_whole(guided) -> None:
    ready, frames = guided
    picking, guide = ChannelSelector(ready), Guide(ready, STEP_S)
    chunks = [guide.feed(*picking.pick(one)) for one in packets(frames)]
    whole = Guide(ready, STEP_S).feed(*signals(trajectory(frames), ready))
    for name in ("phase", "sigma", "rest", "wrong", "size", "deviation", "deviation_sigma"):
        of_packets = np.concatenate([getattr(one, name) for one in chunks])
        assert of_packets.tobytes() == getattr(whole, name).tobytes()
    # In words: praise has no value, and NaN is not even equal to itself.
    assert repr([one for part in chunks for one in part.repetitions]) == repr(list(whole.repetitions))
    assert repr([one for part in chunks for one in part.cues]) == repr(list(whole.cues))
    assert whole.repetitions
    assert whole.cues


def test_types_are_looked_at_with_the_first_packet_alone(guided) -> None:
    """Numba looks at named tuples in Python, packet by packet."""
    ready, frames = guided
    picking, guide = ChannelSelector(ready), Guide(ready, STEP_S)
    first, second = packets(frames)[:2]
    for one in (first, second):
        assert isinstance(picking._write, Kernel) == isinstance(guide._run, Kernel) == (one is first)
        guide.feed(*picking.pick(one))
    guide.restore(guide.state())
    assert isinstance(guide._run, Kernel)
