"""Temperature of sensors on its way: counts, JSON, common ticks, gaps."""

import numpy as np
import pytest

from app.gateway import stream_of
from app.network.alignment import align_all
from app.network.declaration import Declaration, check_hello
from app.network.messages import JsonPacket
from app.network.packet import INT16, Packet, decode_packet, encode_packet, packet_from_json
from estimators.channels import Channel
from estimators.errors import ShapeError
from estimators.recording import Recording, SensorSignals

PAIR = Declaration(("pelvis", "sternum"), 100.0)
TICKS = 5


def packet(number: int, temperature_degc: np.ndarray, time_us: int | None = None) -> Packet:
    inertial = np.random.default_rng(number).normal(0.0, 3.0, (TICKS, 2, 6))
    data = encode_packet(
        np.concatenate([inertial, temperature_degc[..., np.newaxis]], axis=2).astype("<f4"),
        sequence=number,
        device_time_us=1_000_000 + 50_000 * number if time_us is None else time_us,
        tick_interval_us=10_000,
        channels=Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.TEMPERATURE,
    )
    return decode_packet(data, PAIR)


def sensor(rng: np.random.Generator, temperature_degc: np.ndarray | None) -> SensorSignals:
    return SensorSignals(
        np.arange(20) / 100.0,
        rng.normal(0.0, 1.0, (20, 3)),
        rng.normal(0.0, 5.0, (20, 3)),
        temperature_degc=temperature_degc,
    )


def test_a_device_sends_it_as_counts_below_zero_as_well() -> None:
    rng = np.random.default_rng(0)
    cold = np.linspace(-12.0, 31.0, 20)
    device = stream_of(Recording({"pelvis": sensor(rng, cold), "sternum": sensor(rng, cold + 5.0)}, 100.0))
    declared = check_hello(device.hello("ticket"))
    assert Declaration.from_dict(declared.to_dict()) == declared
    sent = [decode_packet(device.packet(number), declared) for number in range(device.packet_count)]
    assert sent[0].encoding == INT16
    found = align_all(sent, declared)
    assert found is not None
    np.testing.assert_allclose(found.temperature_degc, [cold, cold + 5.0], atol=160.0 / 32767)
    with pytest.raises(ShapeError, match="temperature_degc"):
        sensor(rng, cold[:, np.newaxis])


def test_a_sensor_without_a_thermometer_is_not_at_zero_degrees() -> None:
    rng = np.random.default_rng(0)
    warm = np.full(20, 31.0)
    device = stream_of(Recording({"pelvis": sensor(rng, warm), "sternum": sensor(rng, None)}, 100.0))
    declared = check_hello(device.hello("ticket"))
    found = align_all(
        [decode_packet(device.packet(number), declared) for number in range(device.packet_count)], declared
    )
    assert found is not None
    np.testing.assert_allclose(found.temperature_degc[0], warm, atol=160.0 / 32767)
    assert np.isnan(found.temperature_degc[1]).all()


def test_a_short_gap_on_the_ticks_is_bridged_and_a_long_one_is_not() -> None:
    rising = 30.0 + 0.1 * np.arange(10)[:, np.newaxis] * np.ones(2)
    short = align_all([packet(0, rising[:TICKS]), packet(2, rising[TICKS:] + 0.5)], PAIR)
    np.testing.assert_allclose(short.temperature_degc[0], 30.0 + 0.1 * np.arange(15), atol=1e-5)
    long = align_all([packet(0, rising[:TICKS]), packet(9, rising[TICKS:])], PAIR)
    assert np.isnan(long.temperature_degc[0, TICKS:-TICKS]).all()


def test_json_says_the_same() -> None:
    one = packet(0, np.full((TICKS, 2), 31.5))
    sensors = [
        {
            "gyroscope": one.values[:, s, :3].tolist(),
            "accelerometer": one.values[:, s, 3:6].tolist(),
            "temperature": one.values[:, s, 6].tolist(),
        }
        for s in range(2)
    ]
    whole = {"sequence": 0, "device_time_us": 1_000_000, "tick_interval_us": 10_000, "sensors": sensors}
    assert packet_from_json(JsonPacket.model_validate(whole), PAIR).data == one.data


def test_off_the_ticks_it_lies_between_its_neighbours_also_over_a_gap() -> None:
    rising = 30.0 + 0.1 * np.arange(15)[:, np.newaxis] * np.ones(2)
    late = [packet(0, rising[:TICKS]), packet(2, rising[10:], 1_000_000 + 104_000)]
    found = align_all(late, PAIR)
    np.testing.assert_allclose(found.temperature_degc[:, :5], rising[:5].T, atol=1e-5)
    # The second packet begins 104 ms in, at 31.0: between 30.4 at tick 4 and it the chord, then 0.1 a tick.
    np.testing.assert_allclose(found.temperature_degc[0, 5:11], 30.4 + 0.6 * np.arange(1, 7) / 6.4, atol=1e-5)
    np.testing.assert_allclose(found.temperature_degc[0, 11:], 31.06 + 0.1 * np.arange(4), atol=1e-5)


def test_a_sensor_that_gave_nothing_has_none() -> None:
    one = packet(0, np.full((TICKS, 2), 31.5))
    values = one.values.copy()
    values[2, 1] = 0.0
    data = encode_packet(
        values, sequence=0, device_time_us=1_000_000, tick_interval_us=10_000, channels=one.channels
    )
    found = align_all([decode_packet(data, PAIR)], PAIR)
    assert np.isnan(found.temperature_degc[1, 2])
    assert np.isfinite(np.delete(found.temperature_degc, 2, axis=1)).all()
