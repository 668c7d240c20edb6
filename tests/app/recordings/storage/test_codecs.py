"""Codecs: exact round trips for any content, damage is seen, and the size that the design claims."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from app.network.raw_packet import RawPacket
from app.recordings.signals import codecs
from app.recordings.signals.chunks import EncodedChunk, decode_packets, encode_packets

SHAPES = st.tuples(st.integers(1, 40), st.integers(1, 12))


def encode_counts(counts: np.ndarray) -> bytes:
    """Counts as they were written before `int16-rice/1`."""
    return codecs._compress(codecs._shuffle(codecs._zigzag_differences(counts.astype("<i2"))))


@given(hnp.arrays(np.int16, SHAPES))
@settings(max_examples=50, deadline=None)
def test_counts_stored_before_come_back_exactly(counts: np.ndarray) -> None:
    restored = codecs.decode_counts(encode_counts(counts), *counts.shape)
    assert restored.dtype == np.int16
    assert np.array_equal(restored, counts)


@given(hnp.arrays(np.int64, SHAPES))
@settings(max_examples=100, deadline=None)
def test_any_whole_numbers_come_back_exactly(values: np.ndarray) -> None:
    assert np.array_equal(codecs.decode_integers(codecs.encode_integers(values), *values.shape), values)


@given(hnp.arrays(np.uint32, SHAPES))
@settings(max_examples=100, deadline=None)
def test_any_float_bits_come_back_exactly(bits: np.ndarray) -> None:
    # Every bit pattern is a float: signalling and negative NaN, infinities, denormals.
    restored = codecs.decode_floats(codecs.encode_floats(bits.view(np.float32)), *bits.shape)
    assert np.array_equal(restored.view(np.uint32), bits)


@given(hnp.arrays(np.uint8, SHAPES))
@settings(max_examples=50, deadline=None)
def test_any_flags_come_back_exactly(flags: np.ndarray) -> None:
    assert np.array_equal(codecs.decode_flags(codecs.encode_flags(flags), *flags.shape), flags)


@pytest.mark.parametrize("position", [0, 5, -1])
def test_a_changed_byte_changes_the_checksum(position: int) -> None:
    data = bytearray(encode_counts(np.arange(200, dtype=np.int16).reshape(20, 10)))
    before = codecs.checksum(bytes(data))
    data[position] ^= 0x10
    assert codecs.checksum(bytes(data)) != before


def test_the_wrong_size_is_refused_in_words() -> None:
    data = encode_counts(np.zeros((10, 3), np.int16))
    with pytest.raises(codecs.DamagedChunkError, match="instead of"):
        codecs.decode_counts(data, 11, 3)


def test_something_else_than_a_chunk_is_refused() -> None:
    with pytest.raises(codecs.DamagedChunkError, match="decompressed"):
        codecs.decode_counts(b"not compressed at all", 2, 3)


def walking_counts(ticks: int, sensors: int, seed: int) -> np.ndarray:
    """Counts of a moving person: 0.3 to 6 Hz movement of real size plus the noise of a consumer sensor.

    Scales: gyroscope 2000 degrees a second, accelerometer 16 g, magnetometer 0.15 uT a count. Movement and
    noise are those of the whole-body recording of qmt (median 0.9 rad/s, 2 m/s^2), where the same codec
    needs 49.9 MB an hour.
    """
    rng = np.random.default_rng(seed)
    time_s = np.arange(ticks) / 100.0
    columns = []
    for _ in range(sensors):
        strength = rng.uniform(0.3, 1.7)
        for size, noise in ((820.0, 3.0), (420.0, 12.0), (120.0, 2.7)):
            for _ in range(3):
                frequency = rng.uniform(0.3, 6.0, 6)
                share = rng.dirichlet(np.ones(6) * 0.5)
                wave = (
                    share[:, None]
                    * np.sin(2 * np.pi * frequency[:, None] * time_s + rng.uniform(0, 6, (6, 1)))
                ).sum(0)
                columns.append(strength * size * wave + rng.normal(0, noise, ticks))
    return np.round(np.stack(columns, axis=1)).astype(np.int16)


def test_an_hour_of_seventeen_sensors_takes_less_than_fifty_megabytes() -> None:
    # 17 nine-axis sensors at 100 Hz; raw counts alone are 110 MB an hour.
    counts = walking_counts(2000, 17, seed=4)
    size = 0
    for start in range(0, len(counts), 100):
        packets = [
            RawPacket(
                sequence=tick // 5,
                device_time_us=10_000 * tick,
                tick_interval_us=10_000,
                sensor_count=17,
                tick_count=5,
                channel_mask=7,
                encoding=1,
                flags=0,
                payload=counts[tick : tick + 5].tobytes(),
                arrival_ns=1_700_000_000_000_000_000 + 10_000_000 * tick + 12_345 * (tick % 7),
            )
            for tick in range(start, start + 100, 5)
        ]
        chunk = encode_packets(packets)
        assert decode_packets(chunk) == packets
        size += len(chunk.data)
    megabytes_an_hour = size * (360_000 / len(counts)) / 1e6
    assert 25.0 < megabytes_an_hour < 50.0, megabytes_an_hour


def test_packets_stored_before_are_still_read() -> None:
    counts = walking_counts(10, 2, seed=1)
    heads = np.array([(7, 1000, 10_000, 5, 0, 99), (8, 51_000, 10_000, 5, 1, 199)])
    head = codecs.encode_integers(heads)
    data = head + encode_counts(counts)
    scale = {
        "packets": 2,
        "ranges": [[7, 9]],
        "head_bytes": len(head),
        "sensor_count": 2,
        "channel_mask": 7,
        "encoding": 1,
        "values_per_tick": 18,
    }
    old = EncodedChunk(99, 10, codecs.SHUFFLED_COUNTS_CODEC, scale, codecs.checksum(data), data)
    first, second = decode_packets(old)
    assert (first.sequence, second.sequence, second.arrival_ns, second.flags) == (7, 8, 199, 1)
    assert first.payload + second.payload == counts.tobytes()
    # Written anew the same packets come back.
    assert decode_packets(encode_packets([first, second])) == [first, second]


def test_damaged_packets_are_refused_in_words() -> None:
    counts = walking_counts(5, 1, seed=2)
    chunk = encode_packets([RawPacket(1, 2, 10_000, 1, 5, 7, 1, 0, counts.tobytes(), 3)])
    for data in (chunk.data[:-4], chunk.data + b"\0\0\0\0", chunk.data + b"\0"):
        with pytest.raises(codecs.DamagedChunkError, match="cut off or damaged"):
            decode_packets(replace(chunk, data=data, crc=codecs.checksum(data)))
