"""Sets of any exercise: the truth handed out is that of the movement handed out."""

import numpy as np
import pytest

from estimators.simulation import REPEATED_FAMILIES, simulate_repetitions

SEEDS = range(12)


def moved(made):
    """Offset from where the set rests, in units of the whole movement; NaN-free."""
    spread = made.values.max(axis=0) - made.values.min(axis=0)
    return made.values / spread.max()


@pytest.mark.parametrize("family", REPEATED_FAMILIES)
def test_bounds_lie_in_order_inside_the_recording(family):
    for seed in SEEDS:
        made = simulate_repetitions(seed, family)
        both = np.concatenate([made.cycles_s, made.partial_s])
        both = both[np.argsort(both[:, 0])]
        assert len(made.cycles_s) >= 3, f"seed {seed}"
        assert (both[:, 1] > both[:, 0]).all()
        assert (both[1:, 0] >= both[:-1, 1] - 1e-9).all(), f"seed {seed}"
        assert both[0, 0] >= 0
        assert both[-1, 1] <= made.time_s[-1] + 2 * made.time_s[1]


@pytest.mark.parametrize("family", REPEATED_FAMILIES)
def test_phase_counts_the_repetitions(family):
    """Between the first and the last bound exactly the whole repetitions pass; partial tries and rest add nothing."""
    for seed in SEEDS:
        made = simulate_repetitions(seed, family)
        assert (np.diff(made.phase) >= -1e-9).all()
        rise = np.interp(made.cycles_s, made.time_s, made.phase)
        # The samples at either bound are one step of the phase apart from it.
        assert np.allclose(rise[:, 1] - rise[:, 0], 1.0, atol=0.15), f"seed {seed}"


@pytest.mark.parametrize("family", REPEATED_FAMILIES)
def test_a_repetition_ends_where_it_begins_and_goes_away_between(family):
    for seed in SEEDS:
        made = simulate_repetitions(seed, family)
        place = moved(made)
        for start_s, end_s in made.cycles_s:
            inside = place[(made.time_s >= start_s) & (made.time_s < end_s)]
            away = np.linalg.norm(inside - inside[0], axis=1)
            # Tremor of 4 % a channel at either end, drift and the cut by inertia are all that may be left.
            assert away[-1] < 0.45 * away.max(), f"seed {seed}"


def test_the_same_seed_makes_the_same_set():
    one, other = (simulate_repetitions(5, "stops") for _ in range(2))
    assert np.array_equal(one.values, other.values)
    assert not np.array_equal(one.values[:100], simulate_repetitions(6, "stops").values[:100])


def test_all_that_was_asked_occurs():
    """Pauses and none, partial tries, cut beginnings, paces from a third to three times, every body part."""
    made = [simulate_repetitions(seed, family) for family in REPEATED_FAMILIES for seed in range(40)]
    gaps = [np.diff(one.cycles_s.ravel())[1::2].min() for one in made]
    assert min(gaps) < 0.05
    assert max(gaps) > 0.5
    assert any(len(one.partial_s) for one in made)
    assert any(not one.has_home for one in made)
    lengths = [np.median(np.diff(one.cycles_s)) for one in made]
    assert min(lengths) < 0.6
    assert max(lengths) > 6.0
    assert len({one.channels for one in made}) == 4
