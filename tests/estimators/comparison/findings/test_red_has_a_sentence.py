"""What is drawn red in most repetitions has one sentence, compensation first; nothing unmeasured is called matched."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from estimators.comparison import Measure, Repetition, RepetitionResult, build_template, compare
from estimators.comparison._compare import _outside
from estimators.comparison._contract import PHASES
from estimators.comparison._measures import summarise
from estimators.comparison.channels.names import channel_name
from estimators.comparison.channels.sided import is_compensation
from estimators.comparison.findings._findings import write_findings
from estimators.sentences import Sentence
from tests.estimators.comparison.conftest import make_planar
from tests.said import codes, sentence

FORWARD = "trunk_lean_forward_rad"
NAMED_BY_CODE = {
    "findings.trunk_leaned_forward": "trunk_forward_lean",
    "findings.trunk_leaned_sideways": "trunk_sideways_lean",
    "findings.trunk_turned": "trunk_rotation",
    "findings.shoulder_rose": "shoulder_hike",
}


def named(said) -> set[str]:
    """Return the channels that a sentence, or one in it, speaks of."""
    if isinstance(said, Sentence):
        own = {NAMED_BY_CODE[said.code]} if said.code in NAMED_BY_CODE else set()
        channel = said.parameters.get("channel")
        return own.union({channel} if channel else set(), *(named(one) for one in said.parameters.values()))
    if isinstance(said, list | tuple):
        return set().union(*(named(one) for one in said))
    return set()


def template(**options):
    made = make_planar(noise_rad=0.002, seed=1, **options)
    return build_template(made.trajectory, made.truth, "right", made.reach_m, made.primary)


def with_hikes(made, generator, size_m):
    """A shoulder that rises, in a channel of its own."""
    rise = np.abs(made.trajectory.values[:, made.trajectory.channels.index(FORWARD)])
    hike = size_m * rise / max(rise.max(), 1e-9) + generator.normal(0.0, 1e-4, len(rise))
    source = made.trajectory
    return replace(
        source,
        channels=(*source.channels, "shoulder_hike_right_m"),
        values=np.column_stack([source.values, hike]),
        sigma=np.column_stack([source.sigma, np.full(len(hike), np.nan)]),
        valid=np.column_stack([source.valid, np.ones(len(hike), bool)]),
    )


def drawn_on():
    shown = make_planar(noise_rad=0.002, seed=1)
    source = with_hikes(shown, np.random.default_rng(1), 0.005)
    return build_template(source, shown.truth, "right", shown.reach_m, shown.primary)


def made_up(template, seed, count=6):
    """Repetitions that are off in some channels, by about the width of the band, at some phases, not all of them."""
    generator = np.random.default_rng(seed)
    phase, results = np.linspace(0.0, 1.0, PHASES), []
    channels = template.channels
    off = generator.uniform(-2.5, 2.5, len(channels)) * np.nanmax(template.above, axis=0)
    off *= generator.random(len(channels)) < 0.5
    centre, wide = generator.uniform(0.0, 1.0, len(channels)), generator.uniform(0.02, 0.3, len(channels))
    sigma = np.broadcast_to(
        np.where([("." in one) for one in channels], 0.004, generator.uniform(0.003, 0.02, len(channels))),
        template.mean.shape,
    )
    size = generator.uniform(0.7, 1.1)
    for number in range(1, count + 1):
        often = generator.random(len(channels)) < 0.75
        bump = off * often * np.exp(-0.5 * ((phase[:, None] - centre) / wide) ** 2)
        curve = template.mean[0] + size * (template.mean - template.mean[0]) + bump
        measures = [
            Measure(
                f"{'compensation' if is_compensation(name) else 'range'}:{name}",
                "range",
                float(np.ptp(curve[:, column])),
                "m" if name.endswith("_m") else "rad",
                float(sigma[0, column]),
                1,
            )
            for column, name in enumerate(channels)
            if "." not in name
        ]
        repetition = Repetition(number, 4.0 * number, 4.0 * number + 3.0)
        outside = _outside(curve, sigma, template)
        results.append(
            RepetitionResult(repetition, tuple(measures), curve, curve, sigma, 100.0 * phase, outside)
        )
    return results, summarise([list(one.measures) for one in results])


def test_each_channel_that_is_red_in_most_repetitions_has_exactly_one_sentence():
    shown, reds = drawn_on(), Counter()
    for seed in range(60):
        results, summary = made_up(shown, seed)
        findings = write_findings(results, summary, shown)
        count = Counter(channel for one in results for channel in one.outside)
        most = {channel for channel, number in count.items() if 2 * number > len(results)}
        reds.update(most)
        said = [named(one) for one in findings]
        for channel in most:
            assert sum(channel_name(channel) in one for one in said) == 1, (seed, channel, findings)
        # Nothing is said of a place that is not red, and of each angle at most once.
        every = Counter(name for one in said for name in one)
        assert all(number == 1 for number in every.values()), (seed, findings)
        places = {channel_name(channel) for channel in most if "." in channel}
        assert {name for name in every if name.rpartition("_")[2] in ("x", "y", "z")} == places
        is_help = [any(is_compensation(c) and channel_name(c) in one for c in shown.channels) for one in said]
        assert is_help == sorted(is_help, reverse=True), (seed, findings)
        assert most or "findings.outside" not in " ".join(codes(findings))
    assert {FORWARD, "shoulder_hike_right_m", "wrist_right.x"} <= set(reds), "the property was put to a test"
    assert len(reds) >= 10


@pytest.mark.parametrize("lean_deg", [7.5, 8.0, 9.0])
def test_trunk_lean_of_twice_the_templates_has_its_sentence_first(lean_deg):
    """4 degrees and a band of 3: the lean is beyond its edge by a degree or less, and drawn red."""
    made = make_planar(repetitions=6, lean_rad=np.radians(lean_deg), noise_rad=0.001, seed=5)
    source = replace(made.trajectory, sigma=np.where(np.isnan(made.trajectory.sigma), np.nan, 0.003))
    result = compare(
        source, template(lean_rad=np.radians(4.0)), "right", made.reach_m, repetitions=made.truth
    )
    assert sum(FORWARD in one.outside for one in result.repetitions) > 3
    told = sentence(result.findings[:1], "findings.trunk_leaned_forward")
    assert np.degrees(told.parameters["value_rad"]) == pytest.approx(lean_deg, abs=0.8)
    assert np.degrees(told.parameters["reference_rad"]) == pytest.approx(4.0, abs=0.8)


def test_a_place_alone_is_named_and_one_that_follows_is_said_to_follow():
    made = make_planar(repetitions=6, noise_rad=0.002, seed=6)
    values = made.trajectory.values.copy()
    values[:, made.trajectory.channels.index("wrist_right.y")] += 0.08
    off = replace(made.trajectory, values=values)
    alone = compare(off, template(), "right", made.reach_m, repetitions=made.truth)
    assert codes(alone.findings)[0] == "findings.others_outside"
    values[:, made.trajectory.channels.index(made.primary)] += 0.2
    both = compare(replace(off, values=values), template(), "right", made.reach_m, repetitions=made.truth)
    assert "wrist_y" in named(sentence(both.findings, "findings.places_followed"))


def without(source, channel, share, sigma_rad=None):
    """The channel is invalid in this share of the ticks, in stretches of a tenth of a second, or as unsure."""
    column = source.channels.index(channel)
    valid, sigma = source.valid.copy(), source.sigma.copy()
    valid[:, column] = (np.arange(len(valid)) % 10) >= round(10 * share)
    if sigma_rad is not None:
        sigma[:, column] = sigma_rad
    return replace(source, valid=valid, sigma=sigma)


@pytest.mark.parametrize(
    ("share", "sigma_rad", "code"),
    [(1.0, None, "main_not_measured"), (0.0, 0.3, "main_uncertain")],
)
def test_what_the_exercise_is_about_and_was_not_measured_is_said_first(share, sigma_rad, code):
    made = make_planar(repetitions=6, lean_rad=0.3, noise_rad=0.002, seed=7)
    source = without(made.trajectory, made.primary, share, sigma_rad)
    result = compare(source, template(), "right", made.reach_m, repetitions=made.truth)
    assert result.findings[0].code == f"findings.{code}"
    assert result.findings[0].parameters["channel"] == "elbow_flexion"
    assert "not measured" in str(result.findings[0])
    assert sentence(result.findings[1:], "findings.trunk_leaned_forward")
    sound = make_planar(repetitions=6, noise_rad=0.002, seed=8)
    source = without(sound.trajectory, made.primary, share, sigma_rad)
    alone = compare(source, template(), "right", made.reach_m, repetitions=sound.truth)
    assert codes(alone.findings) == [f"findings.{code}"], (
        "nothing else differs, and nothing is called matched"
    )


def test_a_main_channel_with_holes_is_said_to_be_measured_in_part():
    made = make_planar(repetitions=6, noise_rad=0.002, seed=7)
    source = without(made.trajectory, made.primary, 0.7)
    # Repetitions of which nobody says that their sensors were lost: cut by hand, and all that counts is there.
    found = compare(source, template(), "right", made.reach_m, repetitions=made.truth)
    assert codes(found.findings)[0] in ("findings.main_mostly_not_measured", "findings.none_used")
    assert "findings.matched" not in codes(found.findings)
