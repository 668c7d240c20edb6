import re
import struct
import warnings
import zlib
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from app.errors import PacketError
from app.network.declaration import ClockEpoch, Declaration, check_hello
from app.network.messages import HelloMessage, JsonPacket
from app.network.packet import (
    FLOAT32,
    INT16,
    PacketFlag,
    decode_packet,
    encode_packet,
    packet_from_json,
    with_flags,
)
from estimators.channels import Channel

ARM = Declaration(
    ("upper_arm_right", "forearm_right"),
    100.0,
    {"gyroscope": 1e-3, "accelerometer": 2e-3, "magnetometer": 1e-8},
)
FIELDS = {"sensors": (4, "B"), "ticks": (5, "B"), "mask": (6, "H"), "encoding": (8, "B"), "flags": (9, "B")}
FIELDS |= {"reserved": (10, "H"), "interval": (24, "I")}


def packet(dtype: str = "<i2", ticks: int = 2, sensors: int = 2, **changes: int) -> bytes:
    values = np.arange(ticks * sensors * 9).reshape(ticks, sensors, 9).astype(dtype)
    return encode_packet(
        values, **{"sequence": 7, "device_time_us": 123_456_789, "tick_interval_us": 10_000, **changes}
    )


def resealed(data: bytes) -> bytes:
    """The same bytes with a right CRC."""
    body = data[:28] + data[32:]
    return data[:28] + struct.pack("<I", zlib.crc32(body)) + data[32:]


def changed(data: bytes, field: str, value: int) -> bytes:
    offset, kind = FIELDS[field]
    raw = bytearray(data)
    struct.pack_into("<" + kind, raw, offset, value)
    return resealed(bytes(raw))


@pytest.mark.parametrize("dtype", ["<i2", "<f4"])
def test_what_was_encoded_is_decoded(dtype: str) -> None:
    decoded = decode_packet(packet(dtype, flags=PacketFlag.BACKFILLED), ARM)
    assert (decoded.sequence, decoded.device_time_us, decoded.tick_interval_us) == (7, 123_456_789, 10_000)
    assert (decoded.tick_count, decoded.sensor_count, decoded.channels) == (2, 2, 7)
    assert decoded.encoding == (INT16 if dtype == "<i2" else FLOAT32)
    assert decoded.flags == PacketFlag.BACKFILLED
    assert decoded.values.dtype == np.dtype(dtype)
    assert np.array_equal(decoded.values, np.arange(36).reshape(2, 2, 9))
    assert decoded.values.base is not None, "values are a view of the message"
    assert np.array_equal(decoded.channel(Channel.MAGNETOMETER), decoded.values[:, :, 6:])
    assert decoded.channel(Channel.FORCE) is None


def test_every_channel_has_its_place() -> None:
    values = np.arange(21, dtype="<f4").reshape(1, 1, 21)
    decoded = decode_packet(
        encode_packet(values, sequence=0, device_time_us=0, tick_interval_us=10_000, channels=0xFF)
    )
    starts = {channel: decoded.channel(channel)[0, 0, 0] for channel in Channel}
    assert list(starts.values()) == [0, 3, 6, 9, 12, 15, 19, 20]
    assert decoded.channel(Channel.ORIENTATION).shape == (1, 1, 4)


WRONG = {
    "truncated header": (lambda data: data[:31], "truncated"),
    "truncated payload": (lambda data: data[:-1], "truncated"),
    "too long": (lambda data: data + b"\0", "length"),
    "magic": (lambda data: b"BNP2" + data[4:], "magic"),
    "crc": (lambda data: data[:-1] + bytes([data[-1] ^ 1]), "crc"),
    "reserved": (lambda data: changed(data, "reserved", 1), "reserved"),
    "flags": (lambda data: changed(data, "flags", 4), "flags"),
    "encoding": (lambda data: changed(data, "encoding", 2), "encoding"),
    "empty mask": (lambda data: changed(data, "mask", 0), "channel_mask"),
    "unknown mask": (lambda data: changed(data, "mask", 0x107), "channel_mask"),
    "no sensor": (lambda data: changed(data, "sensors", 0), "sensor_count"),
    "200 sensors": (lambda data: changed(data, "sensors", 200), "sensor_count"),
    "no tick": (lambda data: changed(data, "ticks", 0), "tick_count"),
    "65 ticks": (lambda data: changed(data, "ticks", 65), "tick_count"),
    "1 MHz": (lambda data: changed(data, "interval", 1), "tick_interval"),
    "one tick a minute": (lambda data: changed(data, "interval", 60_000_000), "tick_interval"),
    "other rate": (lambda data: changed(data, "interval", 20_000), "tick_interval"),
    "counts do not fit": (lambda data: changed(data, "ticks", 3), "truncated"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_packet_is_refused_with_its_reason(name: str) -> None:
    spoil, reason = WRONG[name]
    with pytest.raises(PacketError) as caught:
        decode_packet(spoil(packet()), ARM)
    assert caught.value.details["reason"] == reason
    assert len(caught.value.message) > 20


def test_other_sensor_count_than_declared_is_refused() -> None:
    with pytest.raises(PacketError) as caught:
        decode_packet(packet(sensors=3), ARM)
    assert caught.value.details["reason"] == "sensor_count"


def test_counts_without_a_declared_scale_are_refused() -> None:
    with pytest.raises(PacketError) as caught:
        decode_packet(
            packet(), Declaration(ARM.placements, 100.0, {"gyroscope": 1e-3, "accelerometer": 1e-3})
        )
    assert caught.value.details["reason"] == "undeclared_scale"
    values = np.zeros((1, 2, 6), dtype="<i2")
    force = encode_packet(values, sequence=0, device_time_us=0, tick_interval_us=10_000, channels=0b11000)
    with pytest.raises(PacketError) as caught:
        decode_packet(force, ARM)
    assert caught.value.details["reason"] == "undeclared_scale"


@pytest.mark.parametrize(
    ("value", "reason"),
    [(np.nan, "not_finite"), (np.inf, "not_finite"), (-np.inf, "not_finite"), (2e6, "absurd_value")],
)
def test_values_that_cannot_be_are_refused(value: float, reason: str) -> None:
    values = np.zeros((2, 2, 9), dtype="<f4")
    values[1, 0, 3] = value
    data = encode_packet(values, sequence=9, device_time_us=0, tick_interval_us=10_000)
    with pytest.raises(PacketError) as caught:
        decode_packet(data, ARM)
    assert caught.value.details == {"reason": reason, "sequence": 9, "tick": 1, "sensor": 0}


def test_the_flags_can_be_changed_on_the_way() -> None:
    decoded = decode_packet(with_flags(packet(), PacketFlag.BACKFILLED), ARM)
    assert decoded.flags == PacketFlag.BACKFILLED
    assert np.array_equal(decoded.values, decode_packet(packet()).values)


def json_packet(**changes: object) -> JsonPacket:
    sensor = {"gyroscope": [[0.1, 0, 0]], "accelerometer": [[0, 0, 9.81]]}
    content = {
        "sequence": 3,
        "device_time_us": 5,
        "tick_interval_us": 10_000,
        "sensors": [sensor, sensor],
        **changes,
    }
    return JsonPacket.model_validate(content)


def test_a_json_packet_is_the_same_packet() -> None:
    found = packet_from_json(json_packet(), ARM)
    assert found.sequence == 3
    assert found.channels == Channel.GYROSCOPE | Channel.ACCELEROMETER
    assert np.allclose(found.values[0, 1], [0.1, 0, 0, 0, 0, 9.81])
    assert decode_packet(found.data, ARM).values.tobytes() == found.values.tobytes()


@pytest.mark.parametrize(
    ("sensors", "reason"),
    [
        ([], "sensor_count"),
        ([{"gyroscope": [[0, 0]], "accelerometer": [[0, 0, 1]]}] * 2, "shape"),
        ([{"gyroscope": [[0, 0, 0]], "accelerometer": []}] * 2, "shape"),
        ([{"gyroscope": [], "accelerometer": []}] * 2, "tick_count"),
        ([{"gyroscope": [[0, 0, 1e300]], "accelerometer": [[0, 0, 1]]}] * 2, "absurd_value"),
        ([{"gyroscope": [[0, 0, float("nan")]], "accelerometer": [[0, 0, 1]]}] * 2, "not_finite"),
        ([{"gyroscope": [[0, 0, 0]], "accelerometer": [[0, 0, 1]]}], "sensor_count"),
        (
            [
                {"gyroscope": [[0, 0, 0]], "accelerometer": [[0, 0, 1]]},
                {"gyroscope": [[0, 0, 0]], "accelerometer": [[0, 0, 1]], "magnetometer": [[0, 0, 1]]},
            ],
            "shape",
        ),
    ],
)
def test_a_wrong_json_packet_is_refused(sensors: list[object], reason: str) -> None:
    with pytest.raises(PacketError) as caught:
        packet_from_json(json_packet(sensors=sensors), ARM)
    assert caught.value.details["reason"] == reason


def hello(**changes: object) -> HelloMessage:
    content = {"protocol_version": 1, "ticket": "t", "placements": ["sternum"], "rate_hz": 100, **changes}
    return HelloMessage.model_validate(content)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"protocol_version": 2}, "protocol_version"),
        ({"placements": []}, "placements"),
        ({"placements": ["tail"]}, "placements"),
        ({"placements": ["sternum", "sternum"]}, "placements"),
        ({"rate_hz": 5}, "rate"),
        ({"gyroscope_scale": 0}, "scales"),
        ({"gyroscope_scale": 1.0}, "scales"),
        ({"magnetometer_scale": float("nan")}, "scales"),
        ({"clip_accelerometer_mps2": -1}, "scales"),
        ({"clip_magnetometer_t": 800.0}, "scales"),
    ],
)
def test_a_wrong_hello_is_refused(changes: dict[str, object], reason: str) -> None:
    with pytest.raises(PacketError) as caught:
        check_hello(hello(**changes))
    assert caught.value.details["reason"] == reason


def test_a_rate_beyond_the_schema_is_refused() -> None:
    with pytest.raises(ValidationError):
        hello(rate_hz=1e9)


def test_a_declaration_survives_storing() -> None:
    declared = check_hello(hello(gyroscope_scale=1e-3, device="x", clip_gyroscope_radps=34.9))
    stored = Declaration(**{**declared.__dict__, "clock_epochs": (ClockEpoch(0, 5, 0), ClockEpoch(9, 3, 7))})
    assert Declaration.from_dict(stored.to_dict()) == stored
    assert stored.same_network(declared)
    other = check_hello(hello(gyroscope_scale=1e-3, clip_gyroscope_radps=34.9, clip_magnetometer_t=8e-4))
    assert other.full_scales["magnetometer"] == 8e-4
    assert not other.same_network(declared)


def test_a_hundred_thousand_spoiled_packets_give_typed_errors_only() -> None:
    """Random bytes, random headers with a right CRC, and right packets with flipped, cut or added bytes."""
    seed = 20_261_121
    generator = np.random.default_rng(seed)
    good = [packet("<i2"), packet("<f4"), packet("<i2", ticks=5)]
    noise = generator.integers(0, 256, 4_000_000, dtype=np.uint8).tobytes()
    lengths = generator.integers(0, 400, 100_000)
    starts = generator.integers(0, len(noise) - 512, 100_000)
    places = generator.integers(0, 1 << 30, (100_000, 3))
    accepted = refused = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for i in range(100_000):
            piece = noise[starts[i] : starts[i] + lengths[i]]
            kind = i % 5
            if kind == 0:
                data = piece
            elif kind == 1:
                data = resealed(b"BNP1" + piece) if len(piece) > 28 else b"BNP1" + piece
            else:
                raw = bytearray(good[i % 3])
                a, b, c = (int(value) for value in places[i])
                raw[a % len(raw)] ^= 1 << (b % 8)
                if kind == 3:
                    raw = raw[: c % len(raw)] if b & 256 else raw + piece
                data = bytes(raw) if kind == 2 or len(raw) < 32 else resealed(bytes(raw))
            try:
                decoded = decode_packet(data, ARM if i % 2 else None)
            except PacketError as error:
                refused += bool(error.details["reason"])
            else:
                assert np.isfinite(decoded.values).all()
                accepted += 1
    print(f"seed {seed}: {refused} refused, {accepted} valid by chance")
    assert refused > 50_000
    assert accepted > 1_000, "flips in the payload with a right CRC are valid packets"


def page_vectors() -> list[bytes]:
    """The hex blocks of docs/packet.md, as an integrator would copy them."""
    page = (Path(__file__).parents[3] / "docs" / "packet.md").read_text()
    blocks = re.findall(r"(?:^    [0-9a-f]{2,64}\n)+", page, re.MULTILINE)
    return [bytes.fromhex(block.replace(" ", "").replace("\n", "")) for block in blocks]


def test_the_vectors_on_the_page_are_right() -> None:
    counts, floats = (decode_packet(data) for data in page_vectors())
    assert (counts.sequence, counts.device_time_us, counts.tick_interval_us) == (7, 10**9, 10_000)
    assert counts.values.tolist() == [[[100, -200, 300, 4, 5, 1000], [1, 2, 3, -4, -5, -1000]]]
    assert (floats.sequence, floats.device_time_us) == (4_294_967_295, 18_446_744_073_709_551_000)
    assert floats.tick_interval_us == 16_667
    assert floats.flags == PacketFlag.BACKFILLED
    expected = [0.5, -0.25, 0.125, 0, 0, 9.75, 2e-5, 0, -4.5e-5]
    assert np.allclose(floats.values[0, 0], expected, rtol=1e-7)
    assert np.array_equal(floats.values[0], floats.values[1])
    for spoiled, reason in ((counts.data[:-1] + b"\xfd", "crc"), (counts.data[:40], "truncated")):
        with pytest.raises(PacketError) as caught:
            decode_packet(spoiled)
        assert caught.value.details["reason"] == reason


def test_every_reason_is_on_the_page() -> None:
    root = Path(__file__).parents[3]
    page = (root / "docs" / "packet.md").read_text()
    sources = [path for room in ("network", "ingest", "live") for path in (root / "app" / room).rglob("*.py")]
    raised = {
        reason
        for path in sources
        for call in re.findall(r"PacketError\((.*?)\n\s*\)|_time_error\((.*)\)", path.read_text(), re.DOTALL)
        for reason in re.findall(r'reason="(\w+)"|"(time_\w+)"', "".join(call))
        for reason in reason
        if reason
    }
    assert {"crc", "placements", "network_changed", "time_backwards"} <= raised
    assert not {reason for reason in raised if f"`{reason}`" not in page}
