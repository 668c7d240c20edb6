"""Coil states on their way: packet, store, common ticks."""

import json
from typing import Any

import numpy as np
import pytest

from app.errors import PacketError
from app.network.alignment import Aligner, align_all
from app.network.clock import PacketClock
from app.network.declaration import Declaration
from app.network.messages import JsonPacket
from app.network.packet import Packet, decode_packet, encode_packet, packet_from_json
from app.network.raw_packet import RawPacket
from app.recordings.analysis.offline import decoded
from app.recordings.signals.chunks import decode_packets, encode_packets
from estimators.channels import Channel
from estimators.magnetic import coil_state, read_coil_state
from estimators.recording import SampleQuality

PAIR = Declaration(("pelvis", "sternum"), 100.0)
TICKS = 5
MASK = Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.MAGNETOMETER | Channel.COIL_STATE
STATE = coil_state([0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 2, 2, 2, 0, 0, 0, 0, 3, 3, 3], 1.3).astype("<f4")


def packet(number: int, time_us: int | None = None, mask: int = MASK) -> Packet:
    values = np.random.default_rng(number).normal(0.0, 1.0, (TICKS, 2, 10)).astype("<f4")
    values[:, :, 9] = 0.0
    values[:, 0, 9] = STATE[TICKS * number : TICKS * (number + 1)]
    if not mask & Channel.COIL_STATE:
        values = values[:, :, :9]
    time_us = 1_000_000 + 50_000 * number if time_us is None else time_us
    return decode_packet(
        encode_packet(
            values, sequence=number, device_time_us=time_us, tick_interval_us=10_000, channels=mask
        ),
        PAIR,
    )


def test_the_state_has_its_place_and_the_store_gives_it_back_to_the_bit() -> None:
    one = packet(2)
    assert one.channel(Channel.COIL_STATE)[:, 0, 0].tobytes() == STATE[10:15].tobytes()
    raw = RawPacket.from_packet(one, 5)
    again = decoded(decode_packets(encode_packets([raw, RawPacket.from_packet(packet(3), 6)]))[0])
    assert again.values.tobytes() == one.values.tobytes()
    assert again.channels == MASK


def as_json(one: Packet) -> dict[str, Any]:
    sensors = [
        {
            "gyroscope": one.values[:, s, :3].tolist(),
            "accelerometer": one.values[:, s, 3:6].tolist(),
            "magnetometer": one.values[:, s, 6:9].tolist(),
            "coil_state": one.values[:, s, 9].tolist(),
        }
        for s in range(2)
    ]
    return {
        "sequence": one.sequence,
        "device_time_us": one.device_time_us,
        "tick_interval_us": one.tick_interval_us,
        "sensors": sensors,
    }


def test_the_same_as_json_is_the_same_packet_to_the_bit() -> None:
    for number in range(4):
        binary = packet(number)
        text = json.dumps({"type": "packet", **as_json(binary)})
        one = packet_from_json(JsonPacket.model_validate_json(text), PAIR)
        assert one.data == binary.data
        assert one.channels == MASK


@pytest.mark.parametrize("spoil", ["of one sensor only", "too few"])
def test_json_states_that_do_not_fit_are_refused(spoil: str) -> None:
    body = as_json(packet(2))
    sensor = body["sensors"][1]
    if spoil == "too few":
        sensor["coil_state"].pop()
    else:
        del sensor["coil_state"]
    with pytest.raises(PacketError, match="coil") as caught:
        packet_from_json(JsonPacket.model_validate(body), PAIR)
    assert caught.value.details["reason"] == "shape"


def test_aligned_states_are_those_sent_never_a_mean() -> None:
    chunk = align_all([packet(i) for i in range(4)], PAIR)
    np.testing.assert_array_equal(chunk.coil_state[0], STATE.astype(float))
    assert not chunk.coil_state[1].any()
    # Between the common ticks the nearest state counts.
    late = [packet(0), *(packet(i, 1_003_000 + 50_000 * i) for i in range(1, 4))]
    off_grid = align_all(late, PAIR)
    known = set(np.unique(STATE.astype(float)).tolist())
    assert set(np.unique(off_grid.coil_state[0]).tolist()) <= known
    number, _, wrong = read_coil_state(off_grid.coil_state[0])
    assert (number > 0).sum() == pytest.approx((STATE > 0).sum(), abs=1)
    assert not wrong.any()


def test_a_gap_has_no_state_and_live_equals_off_line() -> None:
    sent = [packet(0), packet(3)]
    clock, aligner = PacketClock(PAIR), Aligner(PAIR, reorder_window_s=-1.0)
    parts = []
    for one in sent:
        place = clock.admit(one)
        parts.append(aligner.push(one, place.sequence, place.time_us))
    whole = align_all(sent, PAIR)
    assert np.isnan(whole.coil_state[:, 5:15]).all()
    assert (whole.quality[:, 5:15] & (SampleQuality.BRIDGED | SampleQuality.MISSING)).all()
    live = np.concatenate([part.coil_state for part in parts], axis=1)
    np.testing.assert_array_equal(live, whole.coil_state)


def test_packets_without_bit_6_have_none_and_a_network_may_mix() -> None:
    assert align_all([packet(i, mask=MASK & ~Channel.COIL_STATE) for i in range(2)], PAIR).coil_state is None
    mixed = align_all([packet(0, mask=MASK & ~Channel.COIL_STATE), packet(1), packet(2)], PAIR)
    assert np.isnan(mixed.coil_state[:, :5]).all()
    np.testing.assert_array_equal(mixed.coil_state[0, 5:], STATE[5:15].astype(float))


def test_a_sensor_that_gave_nothing_has_no_state() -> None:
    values = np.zeros((1, 2, 10), dtype="<f4")
    values[0, 0] = [0.1, 0.0, 0.0, 0.0, 0.0, 9.8, 0.0, 0.0, 0.0, 2.13]
    one = decode_packet(
        encode_packet(values, sequence=0, device_time_us=0, tick_interval_us=10_000, channels=MASK), PAIR
    )
    chunk = align_all([one], PAIR)
    assert chunk.coil_state[0, 0] == pytest.approx(2.13)
    assert np.isnan(chunk.coil_state[1, 0])


def test_spoiled_states_are_typed_errors_or_say_that_they_are_wrong() -> None:
    generator = np.random.default_rng(6)
    good = packet(2).data
    refused = wrong = 0
    for _ in range(3000):
        raw = bytearray(good)
        # The last number of the first sensor of a tick: its coil state, any bits.
        place = 32 + 80 * int(generator.integers(0, TICKS)) + 36
        raw[place : place + 4] = generator.integers(0, 256, 4, dtype=np.uint8).tobytes()
        values = np.frombuffer(bytes(raw), "<f4", offset=32).reshape(TICKS, 2, 10)
        data = encode_packet(values, sequence=2, device_time_us=0, tick_interval_us=10_000, channels=MASK)
        try:
            one = decode_packet(data, PAIR)
        except PacketError as error:
            refused += error.details["reason"] in {"not_finite", "absurd_value"}
            continue
        number, current, bad = read_coil_state(align_all([one], PAIR).coil_state[0])
        assert np.isfinite(current).all()
        assert ((number >= 0) & (number <= 31)).all()
        wrong += bool(bad.any())
    assert refused > 500
    assert wrong > 500
