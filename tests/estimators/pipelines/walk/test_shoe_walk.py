"""Two instrumented shoes with what goes wrong: zeros off, sensors askew, saturated cells, exchanged shoes."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.pipelines import SessionSetup, analyse_shoes, analyse_walk, with_shoes
from estimators.recording import Recording
from estimators.simulation import gait_preset, simulate_gait
from tests.said import codes, refuses

pytestmark = pytest.mark.slow
NAMES = [f"{part}_{side}" for side in ("left", "right") for part in ("heel", "forefoot", "shank")]
SETUP = SessionSetup("gait", ("heel_left", "heel_right"), 100.0, feet_apart_m=0.18)


def recorded(preset: str) -> Recording:
    found = simulate_gait(replace(gait_preset(preset, 1), rate_hz=100.0)).recording
    return replace(found, sensors={name: found.sensors[name] for name in NAMES})


def changed(recording: Recording, change) -> Recording:
    return replace(recording, sensors={name: change(name, one) for name, one in recording.sensors.items()})


def analysed(recording: Recording):
    walk = analyse_walk(recording, SETUP)
    return walk, analyse_shoes(recording, SETUP, walk)


@pytest.fixture(scope="module")
def recording() -> Recording:
    return recorded("stroke")


@pytest.fixture(scope="module")
def sound(recording):
    return analysed(recording)


def push_off_w(found, side):
    return float(np.percentile(found.shoes[side].ankle.power_w, 99.5))


@pytest.mark.parametrize(("cells", "offset_n"), [("heel", 30.0), ("forefoot_left", -30.0), ("", 60.0)])
def test_a_zero_that_is_off_is_tared_in_the_swings(recording, sound, cells, offset_n):
    def shifted(name, one):
        if one.force_n is None or cells not in name:
            return one
        return replace(one, force_n=one.force_n + np.array([0.0, 0.0, offset_n]))

    _, found = analysed(changed(recording, shifted))
    assert found.mass_kg == pytest.approx(sound[1].mass_kg, abs=0.1)
    np.testing.assert_allclose(found.centre.position_m, sound[1].centre.position_m, atol=0.002)


def test_a_cell_that_is_never_without_load_is_named(recording):
    jammed = np.random.default_rng(3).normal(200.0, 80.0, (len(recording.sensors["heel_right"].time_s), 3))

    def pressed(name, one):
        return replace(one, force_n=one.force_n + jammed) if name == "heel_right" else one

    with refuses("shoes.of", error=ShapeError, side="right") as caught:
        analysed(changed(recording, pressed))
    assert codes(caught.value.message) == ["shoes.of", "shoes.cell_jammed"]


@pytest.mark.parametrize("turn", [[0.0, 0.0, np.pi / 2], [0.4, -0.2, 0.6]])
def test_sensors_put_on_askew_change_nothing(recording, sound, turn):
    q = rotation.exp(np.array(turn))

    def turned(name, one):
        parts = ("gyroscope_radps", "accelerometer_mps2", "force_n", "moment_nm")
        return replace(
            one,
            **{
                part: None if getattr(one, part) is None else rotation.rotate(q, getattr(one, part))
                for part in parts
            },
        )

    _, found = analysed(changed(recording, turned))
    for side in ("left", "right"):
        assert push_off_w(found, side) == pytest.approx(push_off_w(sound[1], side), rel=0.05)
    apart = found.centre.position_m - sound[1].centre.position_m
    assert np.sqrt((apart**2).mean(axis=0)).max() < 0.01


def test_a_saturated_cell_is_told(recording, sound):
    assert sound[1].reasons == ()

    def clipped(name, one):
        return one if one.force_n is None else replace(one, force_n=np.clip(one.force_n, -600.0, 600.0))

    _, found = analysed(changed(recording, clipped))
    clips = [one.parameters["level_n"] for one in found.reasons if one.code == "shoes.clipped"]
    assert clips
    assert clips == pytest.approx([600.0] * len(clips), abs=0.5)


def test_exchanged_shoes_are_told(recording):
    other = {"left": "right", "right": "left"}
    swapped = {}
    for name in NAMES:
        part, side = name.split("_")
        swapped[name] = recording.sensors[f"{part}_{other[side]}"]
    _, found = analysed(replace(recording, sensors=swapped))
    assert "shoes.exchanged" in codes(found.reasons)


def test_stairs_are_refused_with_the_reason():
    with refuses("shoes.stairs", error=SetupError):
        analysed(recorded("stairs"))


def test_frames_have_the_events_of_the_forces(sound):
    walk = with_shoes(*sound)
    names = walk.frames.layout.scalars
    for side in ("left", "right"):
        ticks = np.flatnonzero(walk.frames.scalar[:, names.index(f"foot_{side}_contact")])
        felt = walk.strides[side].contact_s
        assert len(ticks) == len(felt)
        assert np.abs(walk.frames.time_s[ticks] - felt).max() <= walk.frames.time_step_s
