"""The stretch that tells most is found, and findings are said once each."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from estimators import signals
from estimators.calibration import Finding, check_recording, in_words
from estimators.recording import ImuChunk, Recording, SensorSignals
from estimators.sentences import say
from tests.said import codes

DATA = Path(__file__).parents[2] / "data" / "broad" / "fast_combined_15s.npz"


def after_a_long_rest(gyroscope_noise: float = 2e-3) -> ImuChunk:
    """Thirty seconds of rest before a real movement."""
    content = np.load(DATA)
    rate_hz = float(content["sampling_rate_hz"])
    names = ("gyroscope_radps", "accelerometer_mps2", "magnetometer_ut")
    generator = np.random.default_rng(1)
    rest = round(30 * rate_hz)
    read = []
    for name, noise in zip(names, (gyroscope_noise, 2e-2, 0.2), strict=True):
        values = content[name]
        still = values[:100].mean(axis=0) + noise * generator.normal(size=(rest, 3))
        read.append(np.concatenate([still, values]))
    time_s = np.arange(len(read[0])) / rate_hz
    sensor = SensorSignals(time_s, read[0], read[1], 1e-6 * read[2])
    return signals.to_common_ticks(Recording({"box": sensor}, rate_hz), rate_hz)


def test_a_late_movement_still_tells_axes():
    chunk = after_a_long_rest()
    assert check_recording(chunk, ["box"]) == ()
    swapped = replace(chunk, gyroscope_radps=chunk.gyroscope_radps[..., [1, 0, 2]])
    assert [f.code for f in check_recording(swapped, ["box"])] == ["gyroscope_axes"]
    # The very first seconds alone are rest, which claims nothing about axes.
    rest = swapped.ticks(0, round(12.0 / chunk.time_step_s))
    assert check_recording(rest, ["box"]) == ()


def test_a_fault_that_both_stretches_show_is_told_once():
    chunk = after_a_long_rest()
    in_g = replace(chunk, accelerometer_mps2=chunk.accelerometer_mps2 / 9.80665)
    assert [f.code for f in check_recording(in_g, ["box"])] == ["accelerometer_unit"]


def test_words_name_all_sensors_of_a_kind():
    def finding(sensor: str, rate_radps: float) -> Finding:
        said = say("readings.gyroscope_restless", where=[sensor], rate_radps=rate_radps)
        return Finding(sensor, "gyroscope_unit", "refuse", said, rate_radps)

    told = [finding("a", 1.0), finding("b", 1.0), finding("c", 2.0)]
    both, other = in_words(told).parameters["lines"]
    assert (both.parameters["where"], both.parameters["rate_radps"]) == (["a", "b"], 1.0)
    assert (other.parameters["where"], other.parameters["rate_radps"]) == (["c"], 2.0)
    assert told[0].message.parameters["where"] == ["a"], "what was found stays as it was"
    cut = in_words(told, most=1)
    assert codes(cut) == ["text.lines", "readings.gyroscope_restless", "readings.more"]
    assert cut.parameters["lines"][1].parameters == {"count": 1}
    nearly = in_words([finding("a", 1.0), finding("b", 1.0 + 1e-9)])
    assert codes(nearly) == ["readings.gyroscope_restless"]
    assert nearly.parameters["where"] == ["a", "b"], "nobody reads the same words twice"
    assert in_words([]) == ""


def test_the_movement_refuses_what_the_rest_only_doubted():
    chunk = after_a_long_rest(gyroscope_noise=4e-3)
    # Noise of deg/s given as rad/s is odd at rest, but a trembling hand might do it.
    bias = chunk.gyroscope_radps[:, :1000].mean(axis=1, keepdims=True)
    in_degrees = replace(chunk, gyroscope_radps=np.degrees(chunk.gyroscope_radps - bias))
    rest = check_recording(in_degrees.ticks(0, round(12.0 / chunk.time_step_s)), ["box"])
    assert [(f.code, f.severity) for f in rest] == [("gyroscope_unit", "warning")]
    found = check_recording(in_degrees, ["box"])
    assert [(f.code, f.severity) for f in found] == [("gyroscope_unit", "refuse")]
