"""The ghost: the template's posture on the patient's body, at the phase that belongs to the moment."""

from dataclasses import replace

import numpy as np
import pytest

from app.viewer.figure.ghost import PAUSE_S, Ghost, GhostClock, ghost_from_template
from estimators.body import BodyDimensions, body_from_stature


@pytest.fixture(scope="module")
def ghost(reaches) -> Ghost:
    _, template, _ = reaches
    return ghost_from_template(template, BodyDimensions(), "right")


def test_the_hand_goes_where_the_therapists_hand_went(ghost: Ghost, reaches) -> None:
    """Same lengths, so the path is the mean of the therapist's own points; averaging angles instead of points
    and smoothing in the template leave less than 2 cm."""
    _, template, _ = reaches
    path = np.stack(
        [template.mean[:, template.channels.index(f"hand_right.{axis}")] for axis in "xyz"], axis=1
    )
    relative = ghost.track.hand_m[:, 1] - ghost.track.hand_m[0, 1]
    expected = path - path[0]
    trunk = ghost.track.shoulder_m[
        :, 1
    ]  # in the thorax: constant, so the trunk's lean shows only in the room
    assert np.ptp(trunk, axis=0).max() < 1e-6
    # Template positions are relative to the shoulder; the ghost's are in the room. Compare the height.
    assert np.abs(relative[:, 2] - expected[:, 2]).max() < 0.06


def test_a_smaller_patient_gets_a_smaller_ghost(reaches) -> None:
    _, template, _ = reaches
    small = ghost_from_template(template, body_from_stature(1.3), "right").track.hand_m[:, 1]
    large = ghost_from_template(template, body_from_stature(1.9), "right").track.hand_m[:, 1]
    assert np.ptp(small[:, 0]) < 0.75 * np.ptp(large[:, 0])


def test_the_other_arm_gets_the_mirror_image(ghost: Ghost, reaches) -> None:
    _, template, _ = reaches
    mirrored = ghost_from_template(template, BodyDimensions(), "left")
    assert mirrored.side == "left"
    np.testing.assert_allclose(mirrored.track.hand_m[:, 0] * [1, -1, 1], ghost.track.hand_m[:, 1], atol=1e-5)


def test_without_a_comparison_the_template_runs_over_and_over(ghost: Ghost) -> None:
    clock = GhostClock(2.0, begin_s=10.0)
    assert clock.phase(10.0, warp=True) == 0.0
    assert clock.phase(11.0, warp=False) == pytest.approx(50.0)
    assert clock.phase(12.0 + 0.5 * PAUSE_S, warp=True) == 100.0
    assert clock.phase(12.0 + PAUSE_S + 1.0, warp=True) == pytest.approx(50.0)
    assert clock.phase(3.0, warp=True) == 0.0


def test_warped_the_ghost_is_where_the_patient_is_in_the_movement(reaches) -> None:
    """The patient goes out slowly (70 % of the time); warped, ghost and patient are highest at the same moment,
    unwarped the ghost is there earlier."""
    frames, template, compared = reaches
    clock = GhostClock.of(template.duration_s, compared.repetitions, 0.0)
    assert len(clock.repetitions) >= 4
    elevation = frames.angle_rad[:, frames.layout.angles.index("thorax_humerus_right_yxy_elevation")]
    top_of_template = float(
        np.argmax(template.mean[:, template.channels.index("thorax_humerus_right_yxy_elevation")])
    )
    for repetition in clock.repetitions:
        inside = (frames.time_s >= repetition.start_s) & (frames.time_s < repetition.end_s)
        top_s = float(frames.time_s[inside][np.argmax(elevation[inside])])
        assert clock.phase(top_s, warp=True) == pytest.approx(top_of_template, abs=8.0)
        assert clock.phase(top_s, warp=False) > top_of_template + 10.0


def test_the_ghost_never_runs_backward_within_a_repetition(reaches) -> None:
    _, template, compared = reaches
    clock = GhostClock.of(template.duration_s, compared.repetitions, 0.0)
    first = clock.repetitions[0]
    for warp in (True, False):
        phases = [clock.phase(t, warp) for t in np.linspace(first.start_s, first.end_s - 1e-6, 200)]
        assert (np.diff(phases) >= -1e-9).all()


def test_between_repetitions_it_waits_at_the_end_and_then_at_the_start(reaches) -> None:
    _, template, compared = reaches
    clock = GhostClock.of(template.duration_s, compared.repetitions, 0.0)
    first, second = clock.repetitions[:2]
    gap = second.start_s - first.end_s
    assert gap > 0
    assert clock.phase(first.end_s + 0.1 * gap, warp=True) == pytest.approx(100.0, abs=1.0)
    assert clock.phase(second.start_s - 0.1 * gap, warp=True) == 0.0
    assert clock.phase(first.start_s - 0.5, warp=True) == 0.0


def test_a_template_without_forearm_keeps_the_palm_in(reaches) -> None:
    """What the therapist did not measure hangs as in the N-pose instead of turning the palm forward."""
    _, template, _ = reaches
    kept = [i for i, name in enumerate(template.channels) if "humerus_forearm" not in name]
    bare = replace(
        template,
        channels=tuple(template.channels[i] for i in kept),
        mean=template.mean[:, kept],
        tolerance=template.tolerance[:, kept],
    )
    assert np.isfinite(ghost_from_template(bare, BodyDimensions(), "right").track.wxyz).all()
