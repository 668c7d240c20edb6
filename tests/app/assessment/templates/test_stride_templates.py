"""Strides beside the template of a walk, against simulated truth: what differs is said, in its phase, nothing else."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.recordings.compared import Cycles, Source
from estimators.comparison import (
    ComparisonResult,
    Knot,
    Repetition,
    Template,
    ToleranceCurve,
    compare,
    foot_channels,
    mirror_template,
    template_from_bytes,
    template_to_bytes,
)
from estimators.conventions import Side
from estimators.errors import ComparisonError
from estimators.pipelines import analyse_walk
from estimators.recording import Recording, SensorSignals
from estimators.sentences import Sentence
from estimators.simulation import Bout, Leg, WalkStyle

from .walked import SETUP, both, compared_as, source, template_of, walked

FEET = Path(__file__).parents[3] / "data" / "feet"

PITCH, HEIGHT, SPEED = foot_channels("right")


@pytest.fixture(scope="module")
def shown() -> Source:
    return source(seed=1)


@pytest.fixture(scope="module")
def template(shown: Source) -> Template:
    return template_of(shown)


def beside(template: Template, walk: Source) -> ComparisonResult:
    strides = walk.judged(template.side)
    return compare(walk.moved, template, template.side, walk.reach_m, repetitions=strides, is_judged=True)


def codes(result: ComparisonResult) -> list[str]:
    """Return the codes of the findings; of those that join two sentences, of the first and what it says."""
    found = []
    for one in result.findings:
        assert isinstance(one, Sentence)
        parts = [part for part in one.parameters.get("lines", [one]) if isinstance(part, Sentence)]
        what = parts[0].parameters.get("what")
        found.append(f"foot.{what}" if what else parts[0].code)
    return found


def outside(result: ComparisonResult) -> set[str]:
    kept = [one for one in result.repetitions if one.repetition.is_kept]
    return {name for one in kept for name in one.outside}


@pytest.mark.parametrize("seed", [1, 2])
def test_channels_of_a_foot_are_those_of_the_truth(seed: int) -> None:
    made = walked(seed=seed)
    found = analyse_walk(made.recording, SETUP)
    shown = source(seed=seed)
    assert shown.cycles is not None
    for side, cycles in shown.cycles.items():
        truth, holds = made.truth.feet[side], found.strides[side].footholds
        w, x, y, z = truth.heel.q.T
        pitch = np.arcsin(2.0 * (x * z - w * y))
        place, velocity = truth.heel_sensor.position, truth.heel_sensor.velocity
        stood = np.interp(holds.quietest_s, made.truth.time_s, place[:, 2])
        moments = np.stack([holds.start_s, holds.stop_s], axis=1).ravel()
        height = place[:, 2] - np.interp(made.truth.time_s, moments, np.repeat(stood, 2))
        kept = [one for one in cycles.repetitions if one.is_kept]
        assert len(kept) >= 5
        # Root mean square over the cycle, measured here: at most 0.2 degrees, 1 mm and 0.012 m/s; three times that.
        for name, values, most in zip(
            foot_channels(side), (pitch, height, velocity[:, 0]), (0.01, 0.003, 0.036), strict=True
        ):
            own = shown.moved.values[:, shown.moved.channels.index(name)]
            for one in kept:
                time_s = np.linspace(one.start_s, one.end_s, 101)
                difference = np.interp(time_s, shown.moved.time_s, own) - np.interp(
                    time_s, made.truth.time_s, values
                )
                assert np.sqrt(np.mean(difference**2)) < most, (name, one.number)


def test_strides_go_from_contact_to_contact_and_odd_ones_have_their_reason(shown: Source) -> None:
    made = walked(seed=1)
    assert shown.cycles is not None
    for side, cycles in shown.cycles.items():
        land_s = made.truth.feet[side].land_s
        numbers = [one.number for one in cycles.repetitions]
        assert numbers == list(range(2, 2 + len(numbers))), "the first stride follows no contact"
        for one in cycles.repetitions:
            assert np.abs(land_s - one.start_s).min() < 0.05
            assert np.abs(land_s - one.end_s).min() < 0.05
        assert [str(one.reason) for one in cycles.repetitions if not one.is_kept] == [
            "The last stride before standing still."
        ]
        stance, swing = cycles.phases
        assert (stance.name, swing.name) == ("Stance", "Swing")
        assert (stance.start, stance.end, swing.end) == (0.0, swing.start, 1.0)
        # Heel-off to toe-off and the toe's last touch are a tenth of a cycle apart.
        assert 0.55 < stance.end < 0.68
        assert (cycles.main_channel, cycles.watched) == (foot_channels(side)[1], (foot_channels(side)[2],))


def test_strides_along_a_turn_are_odd() -> None:
    turned = source(course=(Bout((Leg(6), Leg(4, turn_rad=np.pi, length_scale=0.5), Leg(6))),))
    odd = [one for one in turned.judged("right") if not one.is_kept]
    assert {str(one.reason) for one in odd} == {
        "Walked along a turn.",
        "The last stride before standing still.",
    }


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_the_same_walk_has_nothing_to_say(template: Template, seed: int) -> None:
    result = beside(template, source(seed=seed))
    assert codes(result) == ["findings.matched"]
    assert outside(result) == set()


@pytest.mark.parametrize("seed", [2, 3])
def test_a_slowed_walk_shows_only_timing(template: Template, seed: int) -> None:
    result = beside(template, source(WalkStyle(stride_time_s=1.3 * 1.15), seed))
    assert codes(result) == ["findings.strides_slower"]
    assert outside(result) == set()
    measured = {one.name: one.value for one in result.summary}
    assert measured["duration_ratio"] == pytest.approx(1.3, abs=0.02)
    assert measured["inside_band"] == 100.0


@pytest.mark.parametrize("clearance_m", [0.03, 0.02])
def test_a_foot_lifted_less_shows_only_height_in_swing(template: Template, clearance_m: float) -> None:
    result = beside(template, source(both(clearance_m=clearance_m), 2))
    assert set(codes(result)) <= {"foot.lower", "findings.range_less"}
    assert "foot.lower" in codes(result)
    assert outside(result) == {HEIGHT}
    said = next(str(one) for one in result.findings if "lifted less" in str(one))
    assert said.endswith("Mostly in: Swing.")
    kept = [one for one in result.repetitions if one.repetition.is_kept]
    border = 100.0 * template.phases[1].start
    assert all(start >= border for one in kept for start, _ in one.outside[HEIGHT])
    # The simulated foot is raised less by as much at the middle of its swing.
    column = template.channels.index(HEIGHT)
    lowest = [float(np.nanmin(one.aligned[:, column] - template.mean[:, column])) for one in kept]
    assert np.median(lowest) == pytest.approx(clearance_m - 0.045, abs=0.003)


def test_a_dropped_foot_shows_its_toes(template: Template) -> None:
    result = beside(template, source(both(landing_pitch_rad=0.1), 2))
    assert "foot.toes_lower" in codes(result)
    assert PITCH in outside(result)


def test_speed_is_judged_where_the_therapist_says_so(template: Template) -> None:
    slow = source(WalkStyle(stride_time_s=1.3 * 1.15), 2)
    result = beside(replace(template, watched=()), slow)
    assert codes(result)[0] == "findings.strides_slower"
    assert "foot.slower" in codes(result)
    assert outside(result) == {SPEED}


def test_a_drawn_band_decides(template: Template) -> None:
    wide = replace(template, tolerances=(ToleranceCurve(HEIGHT, (Knot(0.0, 4.0, 4.0),)),))
    low = source(both(clearance_m=0.02), 2)
    assert outside(beside(wide, low)) == set()


def test_the_other_foot_is_compared_with_the_mirror(template: Template) -> None:
    mirrored = mirror_template(template)
    assert mirrored.primary_channel == foot_channels("left")[1]
    result = beside(mirrored, source(seed=2))
    assert codes(result) == ["findings.matched"]


def test_a_template_of_strides_is_stored_whole(template: Template) -> None:
    again = template_from_bytes(template_to_bytes(template))
    assert (again.channels, again.primary_channel) == (template.channels, HEIGHT)
    np.testing.assert_array_equal(again.mean, template.mean)
    assert again.measures == template.measures


def test_a_foot_that_was_not_measured_is_named(template: Template, shown: Source) -> None:
    alone = replace(
        shown.moved,
        channels=shown.moved.channels[:3],
        values=shown.moved.values[:, :3],
        sigma=shown.moved.sigma[:, :3],
        valid=shown.moved.valid[:, :3],
    )
    with pytest.raises(ComparisonError, match="right"):
        compare(alone, template, "right", 0.55, repetitions=shown.judged("right"), is_judged=True)


def test_one_odd_stride_is_told_by_its_number(template: Template, shown: Source) -> None:
    moved = shown.moved
    odd = [one for one in shown.judged("right") if one.is_kept][2]
    inside = (moved.time_s >= odd.start_s) & (moved.time_s < odd.end_s)
    values = moved.values.copy()
    values[inside, moved.channels.index(HEIGHT)] *= 0.5
    result = beside(template, replace(shown, moved=replace(moved, values=values)))
    assert codes(result) == ["findings.some_strides_less"]
    assert str(result.findings[0]).startswith(
        f"Stride {odd.number} was smaller than in the template: foot height"
    )


@pytest.mark.parametrize("side", ["left", "right"])
def test_half_of_a_real_walk_is_like_the_other_half(side: str) -> None:
    content, rate_hz = np.load(FEET / "gaitmap_strides.npz"), 204.8
    sensors = {}
    for name in ("left", "right"):
        gyroscope = content[f"gyroscope_{name}_radps"].astype(float)
        accelerometer = content[f"accelerometer_{name}_mps2"].astype(float)
        sensors[f"foot_{name}"] = SensorSignals(np.arange(len(gyroscope)) / rate_hz, gyroscope, accelerometer)
    walk = compared_as(Recording(sensors, rate_hz))
    kept = [one for one in walk.judged(side) if one.is_kept]
    assert len(kept) > 20
    first, second = kept[: len(kept) // 2], kept[len(kept) // 2 :]
    template = template_of(replace(walk, cycles=only(walk, side, first)), side)
    result = beside(template, replace(walk, cycles=only(walk, side, second)))
    assert codes(result) == ["findings.matched"]
    assert {one.name: one.value for one in result.summary}["inside_band"] > 90.0


def only(walk: Source, side: str, strides: list[Repetition]) -> dict[Side, Cycles]:
    """Return the cycles of a foot with these strides alone."""
    assert walk.cycles is not None
    own: Side = "left" if side == "left" else "right"
    return {own: replace(walk.cycles[own], repetitions=tuple(strides))}
