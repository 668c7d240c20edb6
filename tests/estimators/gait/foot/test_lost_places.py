"""What is said of a foot after its samples were missing for long, against truth."""

import itertools
from functools import cache

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators import rotation
from estimators.gait import FootFlag, FootParameters, FootTracker
from estimators.gait.foot.lost_places import LostPlace, gap_lengths
from estimators.recording import ImuChunk, SampleQuality

STEP_S = 0.01
FIELD_T = np.array([0.0, 20e-6, -40e-6])


@cache
def walk(turn_rad=0.0, seed=0):
    return foot_walk(strides=14, length_m=1.2, noise=1.0, turn_rad=turn_rad, seed=seed)


def followed(gap_s, *, turn_rad=0.0, seed=0, with_field=False):
    """Return time, truth and what the tracker releases, by name, of a walk without the samples of `gap_s`."""
    true = walk(turn_rad, seed)
    time = true.signals.time_s
    lost = (time >= gap_s[0]) & (time < gap_s[1])
    gyroscope, force = true.signals.gyroscope_radps[None].copy(), true.signals.accelerometer_mps2[None].copy()
    gyroscope[0, lost], force[0, lost] = np.nan, np.nan
    field = rotation.rotate(rotation.conjugate(true.q_world_sensor), FIELD_T)[None] if with_field else None
    quality = np.where(lost, SampleQuality.MISSING, 0).astype(np.uint8)[None]
    tracker = FootTracker(1, STEP_S)
    parts = [tracker.update(ImuChunk(0, STEP_S, gyroscope, force, field, quality)), tracker.finish()]
    names = ("position_m", "q_world_sensor", "position_sigma_m", "attitude_sigma_rad", "is_stance", "flags")
    found = {name: np.concatenate([getattr(part, name) for part in parts], axis=1)[0] for name in names}
    return time, true, found


def stances(found, start):
    at = np.flatnonzero(found["is_stance"] & (np.arange(len(found["is_stance"])) >= start))
    return [run for run in np.split(at, np.flatnonzero(np.diff(at) > 10) + 1) if len(run) > 5]


# Gaps that end in stance, at heel rise, in the middle of a swing and before contact.
@pytest.mark.parametrize("gap_s", [(5.0, 6.2), (5.0, 6.55), (5.0, 6.8), (5.0, 7.0), (4.2, 9.0)])
def test_the_place_stays_lost_and_strides_are_sound(gap_s):
    _, true, found = followed(gap_s)
    first, stop = (round(t / STEP_S) for t in gap_s)
    flags = found["flags"]
    assert not (flags[:first] & FootFlag.PLACE_LOST).any()
    assert (flags[stop:] & FootFlag.PLACE_LOST).all()
    assert np.flatnonzero(flags & FootFlag.BEGINS_ANEW).tolist() == [stop]
    # Metres are lost, and sigma says so, without saying that nothing is known at all.
    error = np.linalg.norm((found["position_m"] - true.position_m)[stop + 150 :, :2], axis=1)
    sigma = np.linalg.norm(found["position_sigma_m"][stop + 150 :, :2], axis=1)
    assert error.min() > 0.5
    assert (error < 2.0 * sigma).all()
    assert sigma[0] < 8.0 * error[0]
    # Within the new stretch every stride is as good as ever.
    rests = stances(found, stop)
    assert len(rests) >= 3
    for before, after in itertools.pairwise(rests):
        stride, truth = (
            (place[after].mean(axis=0) - place[before].mean(axis=0))
            for place in (found["position_m"], true.position_m)
        )
        assert np.linalg.norm(stride) == pytest.approx(np.linalg.norm(truth), abs=0.015)
        assert stride[2] == pytest.approx(truth[2], abs=0.01)


@pytest.mark.parametrize("gap_s", [(5.0, 6.2), (5.0, 6.55), (5.0, 6.8), (5.0, 7.0)])
def test_no_stance_counts_after_a_long_gap_before_the_vertical_is_known(gap_s):
    _, _, found = followed(gap_s)
    stop = round(gap_s[1] / STEP_S)
    first = stop + int(np.argmax(found["is_stance"][stop:]))
    assert (found["attitude_sigma_rad"][first, :2] < 0.1).all()
    # Till then the flags disown what there is; the last stance before the gap says nothing of it.
    is_known = (found["flags"] & FootFlag.NO_STANCE) == 0
    assert not is_known[stop:first].any()
    assert is_known[first:].all()


def test_a_short_gap_loses_no_place():
    _, true, found = followed((6.05, 6.35))
    assert not (found["flags"] & (FootFlag.PLACE_LOST | FootFlag.BEGINS_ANEW)).any()
    error = np.abs((found["position_m"] - true.position_m)[700:, :2]).max(axis=0)
    assert (error < 3.0 * found["position_sigma_m"][700:, :2].max(axis=0) + 0.05).all()


def test_the_field_finds_the_heading_again():
    gap_s = (5.0, 9.0)
    heading = []
    for with_field in (False, True):
        _, true, found = followed(gap_s, turn_rad=0.3, with_field=with_field)
        turn = rotation.multiply(found["q_world_sensor"], rotation.conjugate(true.q_world_sensor))[1200:]
        error = np.abs(rotation.log(rotation.positive(turn))[:, 2])
        sigma = found["attitude_sigma_rad"][1200:, 2]
        assert (error < 3.0 * sigma).all()
        heading.append((error.max(), sigma.max()))
    assert heading[0][0] > 0.8
    assert heading[0][1] > 1.5
    assert heading[1][0] < 0.1
    assert heading[1][1] < 0.1


def test_sigma_after_gaps_is_the_spread_of_what_may_have_happened():
    rng = np.random.default_rng(5)
    parameters, gap = FootParameters(), 60
    # Walk 3 m along x, lose the foot, walk on, lose it again, walk on.
    way = np.concatenate(
        [
            np.linspace(0, 3, 100),
            np.full(gap, 3),
            np.linspace(3, 6, 100),
            np.full(gap, 6),
            np.linspace(6, 8, 100),
        ]
    )
    position = np.stack([way, 0 * way, 0 * way], axis=1)
    is_missing = np.zeros(len(way), dtype=bool)
    is_missing[100 : 100 + gap] = is_missing[200 + gap : 200 + 2 * gap] = True
    begins = [100 + gap, 200 + 2 * gap]
    sigma = np.zeros((len(way), 6))
    flags = LostPlace(100.0, parameters).widen(
        position, sigma, is_missing, 40, {40 + tick: False for tick in begins}
    )
    assert np.flatnonzero(flags & FootFlag.BEGINS_ANEW).tolist() == begins
    ends = rng.normal(size=(20_000, 2, 4)) * (gap * STEP_S) * np.array([1.5, 1.5, 0.3, 1.0])
    turned = np.cumsum(ends[:, :, 3], axis=1)
    place = np.concatenate([ends[:, 0, :2] + [3, 0], ends[:, :1, 2]], axis=1)
    place[:, 0] += 3 * np.cos(turned[:, 0])
    place[:, 1] += 3 * np.sin(turned[:, 0])
    place += ends[:, 1, :3]
    place[:, 0] += 2 * np.cos(turned[:, 1])
    place[:, 1] += 2 * np.sin(turned[:, 1])
    away = place - position[-1]
    np.testing.assert_allclose(np.sqrt(np.mean(away[:, :2] ** 2)), sigma[-1, 0], rtol=0.03)
    np.testing.assert_allclose(np.sqrt(np.mean(away[:, 2] ** 2)), sigma[-1, 2], rtol=0.03)
    np.testing.assert_allclose(turned[:, 1].std(), sigma[-1, 5], rtol=0.03)
    assert (np.diff(sigma[100 : 100 + gap, 0]) > 0.0).all()


def test_gaps_are_counted_across_pieces():
    is_missing = np.array([1, 1, 0, 0, 1, 1, 1, 0, 1], dtype=bool)
    whole = gap_lengths(is_missing, 3)
    assert whole.tolist() == [4, 5, 5, 0, 1, 2, 3, 3, 1]
    assert gap_lengths(is_missing[6:], 2).tolist() == whole[6:].tolist()
