"""Six positions: a known device is found again, missing steps are named, and a public library agrees."""

import json
from pathlib import Path

import numpy as np
import pytest

from estimators.calibration import DeviceCalibration, FullTurn, Rest, correct, ferraris, find_positions
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.recording import ImuChunk
from tests.said import codes, refuses

DATA = Path(__file__).parents[2] / "data" / "imucal"
RATE_HZ = 100.0
FACES = {
    "+x": (1, 0, 0),
    "-x": (-1, 0, 0),
    "+y": (0, 1, 0),
    "-y": (0, -1, 0),
    "+z": (0, 0, 1),
    "-z": (0, 0, -1),
}


class Session:
    """A sensor laid on its sides and turned on a table, with a known device in between."""

    def __init__(
        self,
        seed=1,
        noise=1.0,
        faces=tuple(FACES),
        turns=(("x", 1), ("y", -1), ("z", 2)),
        tilt_deg=0.0,
        rate_spread=0.01,
        part=1.0,
    ):
        rng = np.random.default_rng(seed)
        tilt = np.radians(tilt_deg) * rng.normal(size=(6, 3))
        force, rate = [], []

        def add(seconds, up, omega):
            n = round(seconds * RATE_HZ)
            force.append(np.broadcast_to(GRAVITY_MPS2 * np.asarray(up, dtype=float), (n, 3)))
            rate.append(np.broadcast_to(np.asarray(omega, dtype=float), (n, 3)))

        for name in faces:
            up = np.array(FACES[name]) + tilt[list(FACES).index(name)]
            add(2.5, up / np.linalg.norm(up), (0, 0, 0))
            force.append(rng.normal(size=(60, 3)) * 5 + np.array([0, 0, 9]))
            rate.append(rng.normal(size=(60, 3)) * 2)
        for axis, count in turns:
            up = np.array(FACES["+" + axis])
            add(1.5, up, (0, 0, 0))
            # Minimum jerk over 3 s a turn: samples are the mean rate over their interval, so the sum is exact.
            steps = round(3.0 * abs(count) * RATE_HZ)
            u = np.linspace(0, 1, steps + 1)
            angle = 2 * np.pi * count * part * u**3 * (10 - 15 * u + 6 * u**2)
            force.append(np.broadcast_to(GRAVITY_MPS2 * up.astype(float), (steps, 3)))
            rate.append(np.diff(angle)[:, None] * RATE_HZ * up)
            add(1.5, up, (0, 0, 0))
            force.append(rng.normal(size=(60, 3)) * 5 + np.array([0, 0, 9]))
            rate.append(rng.normal(size=(60, 3)) * 2)
        self.true_force, self.true_rate = np.concatenate(force), np.concatenate(rate)
        self.force_scale = np.diag(1 + 0.03 * rng.normal(size=3)) + 0.006 * rng.normal(size=(3, 3))
        self.rate_scale = np.diag(1 + rate_spread * rng.normal(size=3)) + 0.006 * rng.normal(size=(3, 3))
        self.force_bias, self.rate_bias = 0.2 * rng.normal(size=3), np.radians(1.5) * rng.normal(size=3)
        self.per_force = np.radians(0.02) * rng.normal(size=(3, 3))
        shape = self.true_force.shape
        self.force = (
            self.true_force @ self.force_scale.T + self.force_bias + noise * 0.05 * rng.normal(size=shape)
        )
        self.rate = self.true_rate @ self.rate_scale.T + self.rate_bias + self.true_force @ self.per_force.T
        self.rate = self.rate + noise * 0.005 * rng.normal(size=shape)

    def calibrate(self):
        return ferraris(self.rate, self.force, RATE_HZ)


def test_exact_input_gives_the_exact_device():
    session = Session(noise=0.0)
    found = session.calibrate()
    device = found.device
    np.testing.assert_allclose(device.accelerometer.gain, np.linalg.inv(session.force_scale), atol=1e-10)
    np.testing.assert_allclose(device.accelerometer.bias, session.force_bias, atol=1e-10)
    np.testing.assert_allclose(device.gyroscope.bias, session.rate_bias, atol=1e-10)
    np.testing.assert_allclose(device.gyroscope.per_acceleration, session.per_force @ np.eye(3), atol=1e-3)
    # The dependence on acceleration is told from nominal positions, its product with true force is exact.
    still = np.abs(session.true_rate).max(axis=1) == 0
    np.testing.assert_allclose(
        device.gyroscope.apply(session.rate[still], session.true_force[still]), 0.0, atol=1e-10
    )
    np.testing.assert_allclose(device.gyroscope.gain, np.linalg.inv(session.rate_scale), atol=1e-9)
    assert found.residual_mps2 < 1e-10
    assert len(found.turns) == 3
    assert [turn.turns for turn in found.turns] == [1, -1, 2]


@pytest.mark.parametrize("seed", range(5))
def test_noisy_device_is_found_to_its_noise(seed):
    session = Session(
        seed=seed, turns=[(axis, count) for axis in "xyz" for count in (1, -1)], rate_spread=0.03
    )
    found = session.calibrate()
    corrected = found.device.accelerometer.apply(
        session.true_force @ session.force_scale.T + session.force_bias
    )
    # 0.05 m/s^2 over 200 samples a side: 0.004 m/s^2 each; five times that.
    assert (
        np.abs(corrected - session.true_force).max() < 0.02 * np.abs(session.true_force).max() / GRAVITY_MPS2
    )
    # 0.005 rad/s summed over 3 s is 0.0009 rad of a turn of 6.28, with the bias of 0.0002 rad/s 0.001: 0.1 % at most.
    gain = np.array(found.device.gyroscope.gain)
    assert np.abs(gain @ session.rate_scale - np.eye(3)).max() < 1e-3
    assert found.score == 1.0


def test_slanted_table_lowers_the_score_and_says_why():
    found = Session(tilt_deg=2.0, noise=0.0).calibrate()
    assert found.score < 0.8
    assert {"six_position.contradict", "six_position.not_square"} & set(codes(found.reasons))
    # Tilt is second order along the axis: scale stays right to 1 - cos(8 degrees).
    session = Session(tilt_deg=2.0, noise=0.0)
    gain = np.diag(np.array(session.calibrate().device.accelerometer.gain) @ session.force_scale)
    np.testing.assert_allclose(gain, 1.0, atol=0.03)


@pytest.mark.parametrize(
    ("change", "code", "missing"),
    [
        (
            {"faces": ("+x", "-x", "+y", "+z", "-z"), "turns": (("x", 1), ("y", 1), ("z", 1))},
            "six_position.rest_missing",
            {"faces": ["-y"]},
        ),
        ({"turns": (("x", 1), ("z", 1))}, "six_position.turn_missing", {"axes": ["y"]}),
        ({"turns": ()}, "six_position.turn_missing", {"axes": ["x", "y", "z"]}),
    ],
)
def test_missing_steps_are_named(change, code, missing):
    with refuses(code, **missing):
        Session(**change).calibrate()


def test_wrong_unit_is_refused():
    session = Session()
    with refuses("six_position.incomplete", "six_position.correction"):
        ferraris(np.degrees(session.rate), session.force, RATE_HZ)
    with pytest.raises(ShapeError):
        ferraris(session.rate[:, :2], session.force, RATE_HZ)


def test_device_survives_json_and_corrects_a_network():
    session = Session(noise=0.0)
    device = session.calibrate().device
    again = DeviceCalibration.from_dict(json.loads(json.dumps(device.to_dict())))
    assert again == device
    shape = (2, len(session.rate))
    rate, force = (np.repeat(x[None], 2, axis=0) for x in (session.rate, session.force))
    chunk = ImuChunk(0, 1 / RATE_HZ, rate, force, None, np.zeros(shape, dtype=np.uint8))
    fixed = correct(chunk, [device, None])
    np.testing.assert_allclose(fixed.accelerometer_mps2[0], session.true_force, atol=1e-9)
    np.testing.assert_allclose(fixed.gyroscope_radps[0], session.true_rate, atol=2e-5)
    np.testing.assert_array_equal(fixed.gyroscope_radps[1], session.rate)
    with pytest.raises(ShapeError):
        correct(chunk, [device])


@pytest.fixture(scope="module")
def recordings():
    return np.load(DATA / "ferraris_sessions.npz")


def test_finds_what_people_marked_in_a_real_session(recordings):
    rate = np.radians(recordings["session_gyroscope_degps"].astype(float))
    force = recordings["session_accelerometer_mps2"].astype(float)
    rests, turns = find_positions(rate, force, 102.4)
    marks = json.loads((DATA / "example_ferraris_session_list.json").read_text())
    for name, mark in marks.items():
        axis, kind = name.split("_")
        if kind == "rot":
            (turn,) = (t for t in turns if t.axis == axis)
            # People left margins of up to half a second; ours must hold theirs and the turn is one.
            assert turn.start <= mark["start"] + 5
            assert turn.stop >= mark["end"] - 5
            assert abs(turn.turns) == 1
        else:
            face = ("+" if kind == "p" else "-") + axis
            assert any(
                r.face == face and r.start <= mark["start"] and r.stop >= mark["end"] for r in rests
            ), name
    found = ferraris(rate, force, 102.4)
    for rest in found.rests:
        still = found.device.accelerometer.apply(force[rest.start : rest.stop]).mean(axis=0)
        assert np.linalg.norm(still) == pytest.approx(GRAVITY_MPS2, abs=0.03)
    assert found.residual_mps2 < 0.05
    for turn in found.turns:
        part = slice(turn.start, turn.stop)
        corrected = found.device.gyroscope.apply(rate[part], found.device.accelerometer.apply(force[part]))
        assert np.linalg.norm(corrected.sum(axis=0)) / 102.4 == pytest.approx(2 * np.pi, rel=1e-3)


def test_agrees_with_the_public_library(recordings):
    counts, part = recordings["counts"].astype(float), recordings["part"]
    # Nominal counts per unit, as from a data sheet; the gyroscope of this device was marked with turns of -360.
    force_unit, rate_unit = 209.0, -16.4
    force, rate = counts[:, :3] / force_unit, np.radians(counts[:, 3:] / rate_unit)
    rests, turns = [], []
    for name in dict.fromkeys(part.tolist()):
        index = np.flatnonzero(part == name)
        axis, kind = name.split("_")
        if kind == "rot":
            turns.append(FullTurn(int(index[0]), int(index[-1]) + 1, axis, -1))
        else:
            rests.append(Rest(int(index[0]), int(index[-1]) + 1, ("+" if kind == "p" else "-") + axis))
    found = ferraris(rate, force, 204.8, rests=rests, turns=turns, gravity_mps2=9.81).device
    theirs = {
        k: np.array(v)
        for k, v in json.loads((DATA / "example_cal.json").read_text()).items()
        if "_" in k[1:2]
    }
    gain = np.linalg.inv(theirs["K_a"] @ theirs["R_a"]) * force_unit
    np.testing.assert_allclose(found.accelerometer.gain, gain, atol=1e-7)
    np.testing.assert_allclose(found.accelerometer.bias, theirs["b_a"] / force_unit, atol=1e-6)
    gain = np.linalg.inv(theirs["K_g"] @ theirs["R_g"]) * rate_unit
    # They take the acceleration of a turn uncorrected; a part in 10^4.
    np.testing.assert_allclose(found.gyroscope.gain, gain, atol=1e-4)
    np.testing.assert_allclose(np.degrees(found.gyroscope.bias), theirs["b_g"] / rate_unit, atol=1e-3)
    np.testing.assert_allclose(
        np.degrees(found.gyroscope.per_acceleration), theirs["K_ga"] / rate_unit, atol=1e-7
    )


TWICE = tuple((axis, count) for axis in "xyz" for count in (1, -1))


ONCE = (("x", 1), ("y", -1), ("z", 1))


@pytest.mark.parametrize(
    ("part", "code"),
    [
        (315 / 360, "six_position.turn_under"),
        (330 / 360, "six_position.turn_under"),
        (400 / 360, "six_position.turn_over"),
    ],
)
def test_a_turn_that_was_not_whole_is_no_scale(part, code):
    with refuses(code) as caught:
        Session(part=part, rate_spread=0.0, turns=ONCE).calibrate()
    assert caught.value.redo == ("turn_x", "turn_y", "turn_z")


def test_a_turn_that_was_not_quite_whole_lowers_the_score():
    found = Session(part=350 / 360, rate_spread=0.0, turns=ONCE).calibrate()
    assert 0.3 < found.score < 0.6
    assert codes(found.reasons) == ["six_position.turn_doubt_under"] * 3


def test_two_turns_that_agree_are_the_device():
    session = Session(turns=TWICE, rate_spread=0.0)
    session.rate = session.rate * 1.08
    found = session.calibrate()
    assert found.score == 1.0
    assert np.diag(found.device.gyroscope.gain) == pytest.approx(1 / 1.08, abs=0.01)


def test_a_turn_repeated_because_it_was_wrong_is_left_out():
    wrong, right = Session(part=320 / 360, rate_spread=0.0, turns=ONCE), Session(rate_spread=0.0)
    rate, force = (np.concatenate(both) for both in ((wrong.rate, right.rate), (wrong.force, right.force)))
    found = ferraris(rate, force, RATE_HZ)
    assert [turn.start > len(wrong.rate) for turn in found.turns] == [True] * 3


def test_a_gap_inside_a_turn_does_not_glue_its_ends():
    session = Session(rate_spread=0.0)
    (turn,) = (t for t in find_positions(session.rate, session.force, RATE_HZ)[1] if t.axis == "y")
    middle = (turn.start + turn.stop) // 2
    session.rate[middle : middle + 25] = np.nan
    with refuses("six_position.turn_missing", axes=["y"]) as caught:
        session.calibrate()
    assert caught.value.redo == ("turn_y",)
    # Of a position that was lain in long enough the rest remains.
    session = Session(rate_spread=0.0)
    session.force[100:103] = np.nan
    assert session.calibrate().score == 1.0


def test_positions_that_contradict_each_other_are_refused():
    with refuses("six_position.unusable"):
        Session(tilt_deg=6.0, noise=0.0, seed=3, rate_spread=0.0).calibrate()


@pytest.mark.parametrize("rate_hz", [0.0, -100.0, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_refused(rate_hz):
    session = Session()
    with pytest.raises(SetupError, match="rate"):
        ferraris(session.rate, session.force, rate_hz)
