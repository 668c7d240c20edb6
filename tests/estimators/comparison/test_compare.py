"""V11 of the arm method page: the comparison's own identities, and what the sentences say."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.comparison import (
    Template,
    build_template,
    compare,
    difference_score,
    find_repetitions,
    mirror_template,
    mirror_trajectory,
)
from estimators.comparison.channels.names import channel_label
from estimators.errors import ComparisonError, SetupError
from tests.said import codes, refuses, sentence

OF_WHAT_IS_RED = {
    f"findings.{one}"
    for one in ("outside_mostly", "this_outside_mostly", "others_outside", "also_outside", "places_followed")
}
"""What leaves its band is always told; beside it no more than three."""


def make_template(made) -> Template:
    return build_template(made.trajectory, made.truth, made.side, made.reach_m, made.primary)


def value(measures, name):
    return next(m for m in measures if m.name == name)


def test_same_movement_scores_zero(planar):
    made = planar()
    args = (made.trajectory, made.truth[0], made.reach_m)
    assert difference_score(*args, *args, "right") == 0.0
    result = compare(made.trajectory, make_template(made), "right", made.reach_m, repetitions=made.truth)
    assert all(value(r.measures, "shape_deviation").value < 0.02 for r in result.repetitions)
    assert value(result.summary, "inside_band").value == 100.0
    assert result.repetitions[0].outside == {}
    assert codes(result.findings) == ["findings.matched"]


def test_slower_copy_differs_in_timing_only(planar):
    made, slow = planar(), planar(out_s=1.8, hold_s=0.45, rest_s=1.0)
    template = make_template(made)
    result = compare(slow.trajectory, template, "right", slow.reach_m, repetitions=slow.truth)
    assert value(result.summary, "duration_ratio").value == pytest.approx(1.5, abs=0.02)
    for repetition in result.repetitions:
        rms = value(repetition.measures, f"shape_rms:{made.primary}").value
        assert rms <= 0.01 * template.measures[f"range:{made.primary}"]
        assert value(repetition.measures, "timing_deviation").value < 1.0
    assert codes(result.findings) == ["findings.slower"]
    assert result.findings[0].parameters["ratio"] == pytest.approx(1.5, abs=0.05)
    found = compare(slow.trajectory, template, "right", slow.reach_m)
    assert value(found.summary, "duration_ratio").value == pytest.approx(1.5, abs=0.1)


def test_hesitation_is_timing_not_shape(planar):
    made, hesitant = planar(), planar(hold_s=1.3)
    result = compare(
        hesitant.trajectory, make_template(made), "right", made.reach_m, repetitions=hesitant.truth
    )
    assert value(result.summary, f"shape_rms:{made.primary}").value < 0.02
    assert value(result.summary, "timing_deviation").value > 4.0
    assert value(result.summary, "inside_band").value > 99.0


def test_smaller_copy_has_its_range_ratio_and_no_timing(planar):
    made, small = planar(), planar(sizes=0.7)
    result = compare(small.trajectory, make_template(made), "right", made.reach_m, repetitions=small.truth)
    for repetition in result.repetitions:
        ratio = value(repetition.measures, f"range_ratio:{made.primary}")
        assert ratio.value == pytest.approx(0.70, abs=0.01)
        assert 0 < ratio.uncertainty < 0.05
        assert value(repetition.measures, "timing_deviation").value < 1.0
        assert made.primary in repetition.outside
    told = sentence(result.findings[:1], "findings.range_smaller")
    assert told.parameters["channel"] == "elbow_flexion"
    # How often and where it left the band stands in the same finding: one fault, one sentence.
    assert codes(result.findings[0])[-1] == "findings.this_outside_mostly"
    assert sum("elbow flexion" in str(one).lower() for one in result.findings) == 1
    assert np.degrees(told.parameters["difference_rad"]) == pytest.approx(15.0, abs=0.5)
    assert np.degrees(told.parameters["value_rad"]) == pytest.approx(36.0, abs=0.5)


def test_score_is_symmetric(planar):
    made, other = planar(), planar(sizes=0.8, tremor_rad=0.03, out_s=1.7, noise_rad=0.002)
    first = (made.trajectory, made.truth[1], made.reach_m)
    second = (other.trajectory, other.truth[3], other.reach_m)
    there, back = difference_score(*first, *second, "right"), difference_score(*second, *first, "right")
    assert there > 0.1
    assert there == pytest.approx(back, rel=1e-9)


def test_mirrored_arm_scores_alike(planar):
    right, right_patient = planar(), planar(sizes=0.8, out_s=1.5)
    left, left_patient = planar(side="left"), planar(sizes=0.8, out_s=1.5, side="left")
    assert mirror_trajectory(right.trajectory).channels == left.trajectory.channels
    assert np.array_equal(mirror_trajectory(right.trajectory).values, left.trajectory.values)
    one = compare(right_patient.trajectory, make_template(right), "right", 0.55)
    two = compare(left_patient.trajectory, make_template(left), "left", 0.55)
    crossed = compare(left_patient.trajectory, make_template(right), "left", 0.55)
    for other in (two, crossed):
        assert [m.value for m in one.summary] == pytest.approx([m.value for m in other.summary], rel=1e-12)
        assert one.findings == other.findings
    twice = mirror_template(mirror_template(make_template(right)))
    assert np.array_equal(twice.mean, make_template(right).mean, equal_nan=True)


def test_limb_lengths_do_not_matter(planar):
    made, long_armed = planar(), planar(reach_m=0.66)
    template = make_template(made)
    same = compare(made.trajectory, template, "right", 0.55, repetitions=made.truth)
    longer = compare(long_armed.trajectory, template, "right", 0.66, repetitions=made.truth)
    # Ties of the warp may fall the other way by rounding: a hundredth of a band or of a percent.
    for name in ("shape_deviation", f"range_ratio:{made.primary}", "hand_path_ratio", "timing_deviation"):
        assert value(longer.summary, name).value == pytest.approx(value(same.summary, name).value, abs=0.01)
    first = (made.trajectory, made.truth[0], 0.55)
    second = (long_armed.trajectory, long_armed.truth[0], 0.66)
    assert difference_score(*first, *second, "right") == pytest.approx(0.0, abs=1e-6)
    assert difference_score(*first, *second[:2], 0.55, "right") > 0.05


def test_compensation_is_told(planar):
    made, leaning = planar(), planar(lean_rad=0.35)
    result = compare(leaning.trajectory, make_template(made), "right", made.reach_m)
    assert value(result.summary, "compensation:trunk_lean_forward_rad").value == pytest.approx(0.35, abs=0.01)
    assert codes(result.findings) == ["text.lines", "findings.trunk_leaned_forward", "findings.how_often"]
    leaned, often = result.findings[0].parameters["lines"]
    assert np.degrees(leaned.parameters["more_rad"]) == pytest.approx(14.0, abs=0.5)
    assert often.parameters == {"outside": 5, "count": 5}


def test_a_small_lean_outside_the_band_is_the_first_finding(planar):
    """Twice the template's lean is below 5 degrees here, and the band (3 degrees) is what the therapist allows."""
    made, leaning = planar(lean_rad=0.07), planar(lean_rad=0.2, sizes=0.7)
    result = compare(leaning.trajectory, make_template(made), "right", made.reach_m)
    assert codes(result.findings[0])[:2] == ["text.lines", "findings.trunk_leaned_forward"]
    assert sentence(result.findings[1:], "findings.range_smaller").parameters["channel"] == "elbow_flexion"


def test_every_angle_outside_the_band_is_named(planar):
    made, small = planar(), planar(sizes=0.6, out_s=2.5, tremor_rad=0.08)
    result = compare(small.trajectory, make_template(made), "right", made.reach_m)
    said = " ".join(result.findings).lower()
    for channel in {c for r in result.repetitions for c in r.outside if "." not in c}:
        assert channel_label(channel).lower() in said, channel


def test_what_is_smaller_than_its_uncertainty_is_not_reported(planar):
    """Five degrees of lean beyond the template, known to no better than four: neither marked nor named."""
    made, leaning = planar(lean_rad=0.07), planar(lean_rad=0.16)
    template = make_template(made)
    column = leaning.trajectory.channels.index("trunk_lean_forward_rad")

    def said(sigma_rad):
        sigma = leaning.trajectory.sigma.copy()
        sigma[:, column] = sigma_rad
        unsure = replace(leaning.trajectory, sigma=sigma)
        found = compare(unsure, template, "right", made.reach_m)
        marked = ["trunk_lean_forward_rad" in one.outside for one in found.repetitions]
        return marked, codes(found.findings)

    marked, told = said(0.01)
    assert all(marked)
    assert "findings.trunk_leaned_forward" in told
    marked, told = said(0.08)
    assert not any(marked)
    assert "trunk" not in " ".join(told)


def test_tremor_is_told(planar):
    made, shaking = planar(), planar(tremor_rad=0.06)
    result = compare(shaking.trajectory, make_template(made), "right", made.reach_m)
    assert "findings.less_smooth" in codes(result.findings)
    units = value(result.summary, "movement_units").value
    assert units > make_template(made).measures["movement_units"] + 3


def test_at_most_three_findings_and_none_without_repetitions(planar):
    made = planar()
    bad = planar(sizes=0.5, out_s=2.5, lean_rad=0.5, tremor_rad=0.08)
    findings = compare(bad.trajectory, make_template(made), "right", made.reach_m).findings
    assert len([one for one in findings if not OF_WHAT_IS_RED & set(codes(one))]) <= 3
    still = planar(sizes=0.0, noise_rad=0.001)
    nothing = compare(still.trajectory, make_template(made), "right", made.reach_m)
    assert nothing.repetitions == ()
    assert codes(nothing.findings) == ["findings.none_found"]


def test_summary_is_mean_spread_and_count(planar):
    made = planar(sizes=[0.9, 1.0, 1.1, 1.0], noise_rad=0.001)
    result = compare(made.trajectory, make_template(planar()), "right", made.reach_m, repetitions=made.truth)
    name = f"range:{made.primary}"
    each = np.array([value(r.measures, name).value for r in result.repetitions])
    summary = value(result.summary, name)
    assert summary.count == 4
    assert summary.value == pytest.approx(each.mean())
    assert summary.uncertainty == pytest.approx(each.std(ddof=1))
    # 0.01 rad at either end of the range.
    assert value(result.repetitions[0].measures, name).uncertainty == pytest.approx(0.01 * np.sqrt(2))


def test_dropped_repetitions_are_shown_but_not_counted(planar):
    made = planar(sizes=[1.0, 1.0, 0.5, 1.0, 1.0])
    result = compare(made.trajectory, make_template(planar()), "right", made.reach_m)
    assert [r.repetition.is_kept for r in result.repetitions] == [True, True, False, True, True]
    assert value(result.summary, "duration").count == 4


def test_template_band_and_its_floor(planar):
    made = planar(sizes=[0.9, 1.0, 1.1, 1.05, 0.95])
    template = make_template(made)
    column = template.channels.index(made.primary)
    assert template.repetition_count == 5
    assert template.mean.shape == template.tolerance.shape == (101, len(template.channels))
    assert np.nanmin(template.tolerance[:, column]) == pytest.approx(0.087, abs=1e-6)
    # At the top the spread is 0.079 of 0.9 rad; t(0.95, 4) = 2.13; further repetition: sqrt(1 + 1/5).
    assert template.tolerance[50, column] == pytest.approx(0.9 * 0.079 * 2.132 * np.sqrt(1.2), rel=0.03)
    wider = build_template(made.trajectory, made.truth, "right", 0.55, made.primary, {made.primary: 2.0})
    assert np.allclose(wider.tolerance[:, column], 2 * template.tolerance[:, column])
    few = build_template(made.trajectory, made.truth[:2], "right", 0.55, made.primary)
    assert few.tolerance[50, column] > template.tolerance[50, column]


def test_template_mean_is_not_blunted_by_pace(planar):
    made = planar(repetitions=2)
    fast, slow = planar(repetitions=3, out_s=0.8), planar(repetitions=3, out_s=1.6, hold_s=0.9)
    shift = fast.trajectory.time_s[-1] + 0.01
    joined = replace(
        fast.trajectory,
        time_s=np.concatenate([fast.trajectory.time_s, slow.trajectory.time_s + shift]),
        values=np.concatenate([fast.trajectory.values, slow.trajectory.values]),
        sigma=np.concatenate([fast.trajectory.sigma, slow.trajectory.sigma]),
        valid=np.concatenate([fast.trajectory.valid, slow.trajectory.valid]),
    )
    later = [
        replace(r, number=3 + r.number, start_s=r.start_s + shift, end_s=r.end_s + shift) for r in slow.truth
    ]
    template = build_template(joined, [*fast.truth, *later], "right", 0.55, made.primary)
    column = template.channels.index(made.primary)
    assert np.ptp(template.mean[:, column]) == pytest.approx(0.9, rel=0.01)
    assert template.repetition_count == 6


def test_missing_channels_and_bad_requests(planar):
    made = planar()
    template = make_template(made)
    keep = [i for i, name in enumerate(made.trajectory.channels) if not name.startswith("trunk")]
    without = replace(
        made.trajectory,
        channels=tuple(made.trajectory.channels[i] for i in keep),
        values=made.trajectory.values[:, keep],
        sigma=made.trajectory.sigma[:, keep],
        valid=made.trajectory.valid[:, keep],
    )
    result = compare(without, template, "right", 0.55)
    column = result.channels.index("trunk_lean_forward_rad")
    assert np.isnan(result.repetitions[0].curves[:, column]).all()
    assert not any(m.name.startswith("compensation") for m in result.summary)
    with refuses("compare.few_repetitions", error=ComparisonError):
        build_template(made.trajectory, made.truth[:1], "right", 0.55, made.primary)
    with refuses("compare.not_measured", error=ComparisonError):
        build_template(made.trajectory, made.truth, "right", 0.55, "forearm_hand_right_zxy_flexion")
    with pytest.raises(SetupError, match="reach"):
        compare(made.trajectory, template, "right", 0.0)
    with pytest.raises(SetupError, match="tolerance"):
        build_template(made.trajectory, made.truth, "right", 0.55, made.primary, {made.primary: 0.0})


def test_found_repetitions_make_the_same_template(planar):
    made = planar(noise_rad=0.002)
    automatic = build_template(
        made.trajectory, find_repetitions(made.trajectory, "right"), "right", 0.55, made.primary
    )
    column = automatic.channels.index(made.primary)
    assert np.abs(automatic.mean[:, column] - make_template(made).mean[:, column]).max() < 0.087
