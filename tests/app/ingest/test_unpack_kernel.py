"""The compiled loop over a packet's values beside a plain reading of docs/packet.md."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.network.unpack_kernel import unpack, unpack_python
from estimators._clipping import at_levels
from estimators.recording import SampleQuality

STUCK_TICKS = 6
MISSING, SATURATED = int(SampleQuality.MISSING), int(SampleQuality.SATURATED)


def read_plainly(packets, scales, clips, levels, is_clipped, every):
    """All packets at once: SI values, flags of what clipped, NaN and a flag where nothing was measured."""
    sent = np.concatenate(packets).astype(float)
    ticks, sensors, _ = sent.shape
    signals = np.full((3, sensors, ticks, 3), np.nan)
    for channel, scale in enumerate(scales):
        signals[channel] = np.swapaxes(sent[:, :, 3 * channel : 3 * channel + 3] * scale, 0, 1)
    at_limit = (np.abs(signals[:2]) >= clips[:, None, None, None]).any(axis=(0, 3))
    for sensor in range(sensors):
        for triad in range(2):
            at_limit[sensor] |= at_levels(signals[triad, sensor], levels[sensor, triad])
    quality = np.where(at_limit, every | SATURATED, every).astype(np.uint8)
    end = 0
    for packet in packets:
        begin, end = end, end + len(packet)
        if is_clipped and not at_limit[:, begin:end].any():
            quality[:, begin:end] |= SATURATED
    for sensor in range(sensors):
        same = 0
        inertial = np.concatenate([signals[0, sensor], signals[1, sensor]], axis=1)
        for tick in range(ticks):
            same = same + 1 if tick and (inertial[tick] == inertial[tick - 1]).all() else 0
            if same >= STUCK_TICKS or (inertial[tick, 3:] == 0.0).all():
                quality[sensor, tick] |= MISSING
                signals[:, sensor, tick] = np.nan
    return signals, quality


@st.composite
def streams(draw):
    """Packets of one network; few different values, so that sensors repeat themselves, clip and send zeros."""
    sensors, channels = draw(st.integers(1, 3)), draw(st.integers(2, 3))
    kind = draw(st.sampled_from([np.int16, np.float32]))
    # A coil state or a quaternion may follow the three channels that are read here.
    width = 3 * channels + draw(st.sampled_from([0, 1]))
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    spread = draw(st.sampled_from([1, 3, 30_000]))
    packets = []
    for ticks in draw(st.lists(st.integers(1, 8), min_size=1, max_size=4)):
        values = generator.integers(-spread, spread + 1, (ticks, sensors, width))
        if packets and draw(st.booleans()):
            values[:, draw(st.integers(0, sensors - 1))] = packets[-1][-1, 0]
        packets.append(values.astype(kind))
    scales = np.array([1e-3, 2.5e-3, 1e-8][:channels])
    levels = np.full((sensors, 2, 2, 3), np.inf)
    if draw(st.booleans()):
        # Of some sensor, triad, side and axis, small enough to be met.
        levels[tuple(generator.integers(levels.shape))] = generator.uniform(1e-3, 20.0)
    return packets, scales, np.array([draw(st.sampled_from([2e-3, 20.0])), 70.0]), levels


@pytest.mark.parametrize("run", [unpack_python, unpack], ids=["plain", "compiled"])
@given(stream=streams(), is_clipped=st.booleans(), every=st.sampled_from([0, int(SampleQuality.BACKFILLED)]))
@settings(max_examples=60, deadline=None)
def test_values_and_flags_are_those_of_the_page(run, stream, is_clipped, every) -> None:
    packets, scales, clips, levels = stream
    sensors = packets[0].shape[1]
    last_sent, same_ticks = np.full((2, sensors, 3), np.nan), np.zeros(sensors, dtype=np.int64)
    found, flags = [], []
    for values in packets:
        signals = np.empty((3, sensors, len(values), 3))
        quality = np.empty((sensors, len(values)), dtype=np.uint8)
        state = last_sent, same_ticks
        run(values, scales, clips, levels, is_clipped, every, STUCK_TICKS, *state, signals, quality)
        found.append(signals)
        flags.append(quality)
    signals, quality = read_plainly(packets, scales, clips, levels, is_clipped, every)
    np.testing.assert_array_equal(np.concatenate(found, axis=2), signals)
    np.testing.assert_array_equal(np.concatenate(flags, axis=1), quality)
