from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from app.errors import PacketError
from app.network.alignment import Aligner, align_all, align_chunks
from app.network.clock import PacketClock, SkewEstimator
from app.network.declaration import ClockEpoch, Declaration
from app.network.packet import Packet, PacketFlag, decode_packet, encode_packet
from estimators.recording import ImuChunk, SampleQuality

SENSORS = ("sternum", "upper_arm_right", "forearm_right")
NETWORK = Declaration(
    SENSORS,
    100.0,
    {"gyroscope": 1e-3, "accelerometer": 1e-2, "magnetometer": 1e-8},
    {"gyroscope": 30.0},
)
START_US = 5_000_000_000
TICKS = 5


def counts(tick: np.ndarray) -> np.ndarray:
    """A straight line in time with its own slope per sensor and channel: interpolation is exact."""
    slope = 1 + np.arange(27).reshape(3, 9) % 7
    return (tick[:, None, None] * slope + 10).astype(np.int16)


def packet(sequence: int, time_us: int | None = None, *, interval_us: int = 10_000, flags: int = 0) -> Packet:
    tick = TICKS * sequence + np.arange(TICKS)
    return decode_packet(
        encode_packet(
            counts(tick),
            sequence=sequence % 2**32,
            device_time_us=(START_US + 50_000 * sequence if time_us is None else time_us) % 2**64,
            tick_interval_us=interval_us,
            flags=flags,
        )
    )


def live(packets: list[Packet], declaration: Declaration = NETWORK) -> tuple[ImuChunk, Aligner, list[int]]:
    """Feed packets as they come; return all ticks, the aligner, and after which packet each chunk came."""
    clock, aligner = PacketClock(declaration), Aligner(declaration)
    chunks, moments = [], []
    for number, one in enumerate(packets):
        place = clock.admit(one)
        chunk = None if place.is_duplicate else aligner.push(one, place.sequence, place.time_us)
        if chunk is not None:
            chunks.append(chunk)
            moments.append(number)
    rest = aligner.drain()
    if rest is not None:
        chunks.append(rest)
    for before, after in pairwise(chunks):
        assert after.first_tick == before.first_tick + before.tick_count, "ticks are consecutive"
    return ImuChunk.join(chunks), aligner, moments


def same(a: ImuChunk, b: ImuChunk) -> bool:
    assert a.magnetometer_t is not None
    assert b.magnetometer_t is not None
    return (
        a.first_tick == b.first_tick
        and np.array_equal(a.gyroscope_radps, b.gyroscope_radps, equal_nan=True)
        and np.array_equal(a.accelerometer_mps2, b.accelerometer_mps2, equal_nan=True)
        and np.array_equal(a.magnetometer_t, b.magnetometer_t, equal_nan=True)
        and np.array_equal(a.quality, b.quality)
    )


def test_packets_in_order_come_out_at_once_in_si_units() -> None:
    chunk, _, moments = live([packet(i) for i in range(4)])
    assert moments == [0, 1, 2, 3]
    assert (chunk.first_tick, chunk.tick_count, chunk.time_step_s) == (0, 20, 0.01)
    expected = counts(np.arange(20)).transpose(1, 0, 2)
    assert np.allclose(chunk.gyroscope_radps, expected[:, :, :3] * 1e-3)
    assert np.allclose(chunk.accelerometer_mps2, expected[:, :, 3:6] * 1e-2)
    assert np.allclose(chunk.magnetometer_t, expected[:, :, 6:] * 1e-8)
    assert not chunk.quality.any()


def test_the_step_is_that_of_the_declaration_to_the_last_bit() -> None:
    slower = replace(NETWORK, rate_hz=104.0)
    chunk, _, _ = live([packet(i, START_US + 48_077 * i, interval_us=9_615) for i in range(4)], slower)
    assert chunk.time_step_s == slower.time_step_s


def test_reordered_and_repeated_packets_change_nothing() -> None:
    whole = [packet(i) for i in range(12)]
    order = [0, 1, 3, 2, 2, 4, 7, 5, 6, 6, 0, 8, 9, 11, 10]
    shuffled, _, _ = live([whole[i] for i in order])
    assert same(shuffled, live(whole)[0])


def test_a_missing_packet_is_awaited_for_the_reorder_window_then_bridged() -> None:
    """Packet 2 is missing: 3, 4 and 5 start 50, 100 and 150 ms after it, so 5 ends the wait."""
    chunk, aligner, moments = live([packet(i) for i in (0, 1, 3, 4, 5, 6)])
    assert moments == [0, 1, 4, 5]
    assert [(gap.first_tick, gap.tick_count, gap.is_bridged) for gap in aligner.gaps] == [(10, 5, True)]
    bridged = (chunk.quality & SampleQuality.BRIDGED) != 0
    assert bridged[:, 10:15].all()
    assert bridged.sum() == 15
    expected = counts(np.arange(35)).transpose(1, 0, 2)[:, :, :3] * 1e-3
    assert np.allclose(chunk.gyroscope_radps, expected), "a line is bridged exactly"


@pytest.mark.parametrize(("lost", "is_bridged"), [(4, True), (5, False)])
def test_gaps_up_to_200_ms_are_bridged_and_longer_ones_are_missing(lost: int, is_bridged: bool) -> None:
    chunk, aligner, _ = live([packet(i) for i in range(20) if not 5 <= i < 5 + lost])
    gap = slice(25, 25 + 5 * lost)
    flag = SampleQuality.BRIDGED if is_bridged else SampleQuality.MISSING
    assert (chunk.quality[:, gap] == flag).all()
    assert np.isnan(chunk.gyroscope_radps[:, gap]).all() == (not is_bridged)
    assert not np.isnan(chunk.gyroscope_radps[:, gap.stop :]).any()
    assert chunk.tick_count == 100, "a lost sample is never ignored"
    assert [g.is_bridged for g in aligner.gaps] == [is_bridged]


def test_a_late_packet_is_counted_live_and_used_off_line() -> None:
    order = [*range(8), *range(9, 20), 8]
    chunk, aligner, _ = live([packet(i) for i in order])
    assert aligner.late_packets == 1
    assert (chunk.quality & SampleQuality.BRIDGED).any()
    off_line = align_all([packet(i) for i in sorted(order)], NETWORK.to_dict())
    assert same(off_line, live([packet(i) for i in range(20)])[0])


def test_off_line_equals_live_when_nothing_was_late() -> None:
    kept = [i for i in range(200) if i % 17 not in (3, 4) and not 100 <= i < 112]
    packets = [packet(i) for i in kept]
    swapped = packets.copy()
    for i in range(1, len(kept) - 1, 3):
        # A packet that overtakes one just after a long gap ends the wait for it; live and stored then differ.
        if kept[i + 1] - kept[i - 1] == 2:
            swapped[i], swapped[i + 1] = swapped[i + 1], swapped[i]
    on_line, _, _ = live(swapped)
    assert same(on_line, align_all(packets, NETWORK.to_dict()))
    pieces = list(align_chunks(packets, NETWORK, piece_ticks=37))
    assert len(pieces) > 10
    assert same(on_line, ImuChunk.join(pieces))


def test_the_sequence_number_may_wrap() -> None:
    start = 2**32 - 3
    clock = PacketClock(NETWORK)
    found = [clock.admit(packet(start + i)).sequence for i in (0, 1, 3, 2, 4, 5)]
    assert found == [start + i for i in (0, 1, 3, 2, 4, 5)]


@pytest.mark.parametrize("bits", [32, 64])
def test_the_device_clock_may_wrap(bits: int) -> None:
    """A 64-bit counter, or one of 32 bits (71 minutes) in the field of 64."""
    start = 2**bits - 120_000
    times = [(start + 50_000 * i) % 2**bits for i in range(8)]
    clock = PacketClock(NETWORK)
    found = [clock.admit(packet(i, times[i])).time_us for i in (0, 1, 2, 4, 3, 5, 6, 7)]
    assert found == [50_000 * i for i in (0, 1, 2, 4, 3, 5, 6, 7)]


def test_ticks_between_the_common_ticks_are_interpolated() -> None:
    """The device's ticks drift by a tenth of a tick a packet against its own stated rate."""
    drifting = [packet(i, START_US + 51_000 * i, interval_us=10_200) for i in range(40)]
    chunk, aligner, _ = live(drifting)
    assert not chunk.quality.any()
    assert not aligner.gaps
    # Device tick n was taken at 1.02 n common ticks: common tick t holds the line's value at n = t / 1.02.
    tick = np.arange(chunk.tick_count) / 1.02
    expected = (tick[None, :, None] * (1 + np.arange(27).reshape(3, 1, 9) % 7) + 10)[:, :, :3] * 1e-3
    # Snapping within 0.05 ticks moves a value by at most 0.05 of its slope per tick.
    assert np.abs(chunk.gyroscope_radps - expected).max() <= 0.051 * 7e-3


def test_a_gap_between_ticks_off_the_grid_is_bridged_or_missing() -> None:
    for lost, flag in ((2, SampleQuality.BRIDGED), (6, SampleQuality.MISSING)):
        packets = [
            packet(i, START_US + 50_000 * i + (3_000 if i else 0)) for i in range(20) if not 5 <= i < 5 + lost
        ]
        chunk, aligner, _ = live(packets)
        flagged = np.flatnonzero((chunk.quality[0] & flag) != 0)
        assert abs(flagged.size - 5 * lost) <= 1
        assert flagged[0] >= 24
        assert len(aligner.gaps) == 1


def test_time_running_backwards_is_a_typed_error_and_the_session_lives_on() -> None:
    clock = PacketClock(NETWORK)
    clock.admit(packet(0))
    with pytest.raises(PacketError) as caught:
        clock.admit(packet(1, START_US - 1_000_000))
    assert caught.value.details["reason"] == "time_backwards"
    with pytest.raises(PacketError) as caught:
        clock.admit(packet(1, START_US + 3_600_000_000))
    assert caught.value.details["reason"] == "time_jump"
    assert clock.time_errors == 2
    assert clock.admit(packet(1)).time_us == 50_000
    with pytest.raises(PacketError) as caught:
        clock.admit(packet(1, START_US + 51_000))
    assert caught.value.details["reason"] == "sequence_reused"
    clock.admit(packet(3))
    with pytest.raises(PacketError):
        clock.admit(packet(2, START_US + 500_000))
    assert clock.admit(packet(2)).time_us == 100_000


def test_a_device_that_was_switched_off_starts_a_new_clock_after_a_hello() -> None:
    clock = PacketClock(NETWORK)
    for i in range(3):
        clock.admit(packet(i), arrival_s=0.05 * i)
    clock.begin_connection()
    place = clock.admit(packet(3, 77), arrival_s=10.1)
    assert place.time_us == 150_000 + 10_000_000, "ten seconds passed at the server"
    assert clock.admit(packet(4, 50_077)).time_us == place.time_us + 50_000
    assert [epoch.first_sequence for epoch in clock.declaration.clock_epochs] == [0, 3]
    again = PacketClock(Declaration.from_dict(clock.declaration.to_dict()))
    stored = [packet(0), packet(1), packet(2), packet(3, 77), packet(4, 50_077)]
    assert [again.admit(one).time_us for one in stored] == [0, 50_000, 100_000, 10_150_000, 10_200_000]


def test_an_origin_that_is_stored_keeps_its_ticks() -> None:
    known = replace(NETWORK, clock_epochs=(ClockEpoch(0, START_US, 0),))
    chunk = align_all([packet(i) for i in range(4, 8)], known)
    assert (chunk.first_tick, chunk.tick_count) == (0, 40)
    assert (chunk.quality[:, :20] == SampleQuality.MISSING).all()


def test_saturation_is_flagged_at_the_clip_level_and_at_full_counts() -> None:
    tick = np.arange(TICKS)
    values = counts(tick)
    values[1, 0, 0] = 30_100  # 30.1 rad/s, above the declared clip level
    values[2, 1, 4] = -32_768
    data = encode_packet(values, sequence=0, device_time_us=0, tick_interval_us=10_000)
    chunk, _, _ = live([decode_packet(data)])
    found = {tuple(map(int, place)) for place in np.argwhere(chunk.quality & SampleQuality.SATURATED)}
    assert found == {(0, 1), (1, 2)}


def test_a_device_that_says_saturated_without_a_value_at_clip_flags_the_packet() -> None:
    chunk, _, _ = live([packet(0), packet(1, flags=PacketFlag.SATURATED | PacketFlag.BACKFILLED)])
    assert (chunk.quality[:, :5] == 0).all()
    assert (chunk.quality[:, 5:] == SampleQuality.SATURATED | SampleQuality.BACKFILLED).all()


def test_a_sensor_that_sends_zeros_or_stands_still_to_the_last_bit_is_missing() -> None:
    generator = np.random.default_rng(1)
    packets = []
    for i in range(40):
        values = generator.integers(-500, 500, (TICKS, 3, 9)).astype(np.int16)
        if 10 <= i < 30:
            values[:, 1] = 321
        if 20 <= i < 25:
            values[:, 2] = 0
        data = encode_packet(values, sequence=i, device_time_us=50_000 * i, tick_interval_us=10_000)
        packets.append(decode_packet(data))
    chunk, _, _ = live(packets)
    missing = (chunk.quality & SampleQuality.MISSING) != 0
    assert not missing[0].any()
    assert np.flatnonzero(missing[2]).tolist() == list(range(100, 125))
    stuck = np.flatnonzero(missing[1])
    assert 100 <= stuck[0] <= 105, "half a second, to a packet, after it stopped at tick 50"
    assert stuck[-1] == 149
    assert np.isnan(chunk.accelerometer_mps2[missing]).all()


def test_packets_without_an_accelerometer_are_refused() -> None:
    values = np.zeros((1, 3, 3), dtype="<f4")
    data = encode_packet(values, sequence=0, device_time_us=0, tick_interval_us=10_000, channels=1)
    with pytest.raises(PacketError) as caught:
        Aligner(NETWORK).push(decode_packet(data), 0, 0)
    assert caught.value.details["reason"] == "missing_channels"


def test_networks_without_magnetometer_have_none() -> None:
    values = np.ones((1, 3, 6), dtype="<f4")
    data = encode_packet(values, sequence=0, device_time_us=0, tick_interval_us=10_000, channels=3)
    chunk, _, _ = live([decode_packet(data)])
    assert chunk.magnetometer_t is None


def test_the_skew_is_found_under_the_jitter() -> None:
    seed = 7
    generator = np.random.default_rng(seed)
    estimator = SkewEstimator()
    for i in range(2400):
        device_s = 0.05 * i
        delay_s = 0.02 + generator.exponential(0.01)
        estimator.add([(device_s, device_s * (1 + 80e-6) + delay_s)])
    # One minimum of 20 exponential delays a second scatters by 0.5 ms; over 120 s the line under the lowest
    # of them is good to about 0.5 ms / 60 s = 8 ppm.
    assert estimator.skew_ppm == pytest.approx(80, abs=10)


def test_no_skew_is_told_when_the_stream_is_not_sent_in_real_time() -> None:
    estimator = SkewEstimator()
    assert estimator.skew_ppm is None
    for i in range(2400):
        estimator.add([(0.05 * i, 0.005 * i)])
    assert estimator.skew_ppm is None
