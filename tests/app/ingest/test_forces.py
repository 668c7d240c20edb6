"""Forces of load cells on their way: packet, JSON, store, common ticks."""

import numpy as np
import pytest

from app.errors import PacketError
from app.gateway import FULL_SCALES, stream_of
from app.kinds.walk.shoes import shoes_of
from app.network.alignment import Aligner, align_all
from app.network.clock import PacketClock
from app.network.declaration import Declaration, check_hello
from app.network.messages import JsonPacket
from app.network.packet import INT16, Packet, decode_packet, encode_packet, packet_from_json
from app.network.raw_packet import RawPacket
from app.recordings.analysis.offline import decoded
from app.recordings.signals.chunks import decode_packets, encode_packets
from estimators.channels import Channel
from estimators.conventions import SHOE_PLACEMENTS
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk, Recording, SensorSignals

SHOE = Declaration(("heel_left", "forefoot_left"), 100.0)
TICKS = 5
MASK = Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.FORCE | Channel.MOMENT


def values_of(number: int) -> np.ndarray:
    return np.random.default_rng(number).normal(0.0, 3.0, (TICKS, 2, 12)).astype("<f4")


def packet(number: int, time_us: int | None = None, values: np.ndarray | None = None) -> Packet:
    data = encode_packet(
        values_of(number) if values is None else values,
        sequence=number,
        device_time_us=1_000_000 + 50_000 * number if time_us is None else time_us,
        tick_interval_us=10_000,
        channels=MASK,
    )
    return decode_packet(data, SHOE)


def test_forces_have_their_place_and_the_store_gives_them_back_to_the_bit() -> None:
    one = packet(2)
    assert one.channel(Channel.FORCE).tobytes() == values_of(2)[:, :, 6:9].tobytes()
    assert one.channel(Channel.MOMENT).tobytes() == values_of(2)[:, :, 9:12].tobytes()
    raw = [RawPacket.from_packet(packet(i), 5) for i in (2, 3)]
    again = decoded(decode_packets(encode_packets(raw))[0])
    assert (again.values.tobytes(), again.channels) == (one.values.tobytes(), MASK)


def test_json_says_the_same() -> None:
    values = values_of(0)
    names = ("gyroscope", "accelerometer", "force", "moment")
    sensors = [
        {name: values[:, s, 3 * i : 3 * i + 3].tolist() for i, name in enumerate(names)} for s in range(2)
    ]
    whole = {
        "sequence": 0,
        "device_time_us": 1_000_000,
        "tick_interval_us": 10_000,
        "sensors": sensors,
    }
    assert packet_from_json(JsonPacket.model_validate(whole), SHOE).data == packet(0).data
    del sensors[1]["force"]
    with pytest.raises(PacketError, match="rows of three"):
        packet_from_json(JsonPacket.model_validate(whole), SHOE)


def test_aligned_forces_are_those_sent_and_gaps_are_never_bridged() -> None:
    sent = [packet(0), packet(3)]
    clock, aligner = PacketClock(SHOE), Aligner(SHOE, reorder_window_s=-1.0)
    live = []
    for one in sent:
        place = clock.admit(one)
        live.append(aligner.push(one, place.sequence, place.time_us))
    whole = align_all(sent, SHOE)
    np.testing.assert_array_equal(whole.force_n[:, :5], values_of(0)[:, :, 6:9].transpose(1, 0, 2))
    np.testing.assert_array_equal(whole.moment_nm[:, 15:], values_of(3)[:, :, 9:].transpose(1, 0, 2))
    assert np.isnan(whole.force_n[:, 5:15]).all()
    assert np.isfinite(whole.gyroscope_radps[:, 5:15]).all()
    together = np.concatenate([part.force_n for part in live], axis=1)
    np.testing.assert_array_equal(together, whole.force_n)
    assert whole.ticks(2, 4).force_n.tobytes() == whole.force_n[:, 2:4].tobytes()
    # Between the common ticks, and over a hole there.
    off_grid = align_all([packet(0), *(packet(i, 1_003_000 + 50_000 * i) for i in (1, 3))], SHOE)
    np.testing.assert_allclose(
        off_grid.force_n[:, 6],
        0.3 * values_of(1)[0, :, 6:9] + 0.7 * values_of(1)[1, :, 6:9],
        atol=1e-6,
    )
    assert np.isnan(off_grid.force_n[:, 11:14]).all()


def test_what_no_cell_measures_is_not_a_force() -> None:
    # Twelve packets of a load that stays to the last bit: taken for half a second, then no more.
    stuck = np.concatenate([values_of(i) for i in range(12)])
    stuck[:, 0, 6:] = stuck[0, 0, 6:]
    parts = [packet(i, values=stuck[5 * i : 5 * i + 5]) for i in range(12)]
    found = align_all(parts, SHOE)
    known = np.isfinite(found.force_n).all(axis=2)
    assert known[0, :50].all()
    assert not known[0, 51:].any()
    assert known[1].all()
    # A sensor that sends zeros in all channels gave nothing; zeros of a cell alone are no load.
    nothing = values_of(0)
    nothing[1, 0] = 0.0
    nothing[2, 1, 6:] = 0.0
    found = align_all([packet(0, values=nothing)], SHOE)
    assert np.isnan(found.force_n[0, 1]).all()
    assert not found.force_n[1, 2].any()


def test_counts_have_their_scales_and_an_end() -> None:
    rng = np.random.default_rng(7)
    sensors = {
        name: SensorSignals(
            np.arange(20) / 100.0,
            rng.normal(0, 1, (20, 3)),
            rng.normal(0, 5, (20, 3)),
            None,
            rng.normal(0, 100, (20, 3)),
            rng.normal(0, 5, (20, 3)),
        )
        for name in SHOE.placements
    }
    sensors["heel_left"].force_n[3] = np.nan
    sensors["heel_left"].force_n[7, 2] = 5000.0
    device = stream_of(Recording(sensors, 100.0))
    declared = check_hello(device.hello("ticket"))
    assert declared.scales["force"] == pytest.approx(FULL_SCALES["force"] / 32767)
    assert Declaration.from_dict(declared.to_dict()) == declared
    sent = [decode_packet(device.packet(i), declared) for i in range(4)]
    assert sent[0].encoding == INT16
    found = align_all(sent, declared)
    assert np.isnan(found.force_n[0, [3, 7]]).any(axis=1).all()
    kept = np.delete(np.arange(20), [3, 7])
    np.testing.assert_allclose(found.force_n[0, kept], sensors["heel_left"].force_n[kept], atol=0.05)
    np.testing.assert_allclose(found.moment_nm[1], sensors["forefoot_left"].moment_nm, atol=0.003)
    assert np.isfinite(found.accelerometer_mps2).all()
    bare = Declaration(SHOE.placements, 100.0, {"gyroscope": 0.001, "accelerometer": 0.005})
    with pytest.raises(PacketError) as raised:
        decode_packet(device.packet(0), bare)
    assert raised.value.details["reason"] == "undeclared_scale"


def test_the_longest_stretch_of_forces_is_analysed_and_the_rest_said() -> None:
    rng = np.random.default_rng(1)
    shape = (4, 600, 3)
    force = rng.normal(size=shape)
    force[1, 100:110] = np.nan
    force[2, 200:260] = np.nan
    piece = ImuChunk(
        0,
        0.01,
        rng.normal(size=shape),
        rng.normal(size=shape),
        None,
        np.zeros(shape[:2], dtype=np.uint8),
        force_n=force,
        moment_nm=rng.normal(size=shape),
    )
    setup = SessionSetup("gait", SHOE_PLACEMENTS, 100.0)
    found, late_s, note = shoes_of([piece.ticks(0, 333), piece.ticks(333, 600)], setup)
    assert found.sensors["heel_left"].time_s[0] == pytest.approx(2.6)
    assert late_s == pytest.approx(2.6)
    assert "right heel" in note
    np.testing.assert_array_equal(found.sensors["forefoot_right"].force_n, force[3, 260:])
    whole, _, note = shoes_of([piece.ticks(0, 200)], setup)
    assert np.isfinite(whole.sensors["forefoot_left"].force_n).all()
    assert note == ""
    force[2] = np.nan
    nobody, _, note = shoes_of([piece], setup)
    assert nobody is None
    assert "right heel" in note
    assert shoes_of([piece], SessionSetup("gait", ("foot_left", "foot_right"), 100.0))[0] is None
