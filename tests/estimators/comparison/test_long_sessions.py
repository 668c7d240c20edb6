"""A long session is cut like a short one, where turning points explain it nearly as well; no work is done twice."""

import pytest

from estimators import comparison, pipelines
from estimators.comparison import _judgement
from estimators.comparison.repetitions import cycles
from estimators.simulation import demonstration_scenario, simulate_arm


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1000, 1002])
def test_forty_repetitions_begin_at_rest(seed):
    scenario = demonstration_scenario("moderate_stroke", "reaching", progress=1.0, repetitions=40, seed=seed)
    session = simulate_arm(scenario)
    frames, _ = pipelines.run(session.recording, session.setup, (1.0, 9.0))
    found = comparison.find_repetitions(comparison.trajectory(frames), "right", start_s=10.0)
    truth = session.truth.repetitions_s
    assert len(found) == len(truth) == 40
    # Half a repetition is 1.5 s; the bound of the short sessions is 0.25 s.
    assert max(abs(one.start_s - start) for one, start in zip(found, truth[:, 0], strict=True)) < 0.5


def test_the_way_of_a_repetition_is_walked_once_for_all_who_judge_it(planar, monkeypatch):
    made = planar(repetitions=12, noise_rad=0.002)
    walked, walk = [], _judgement.walk
    monkeypatch.setattr(_judgement, "walk", lambda *given: walked.append(given) or walk(*given))
    judged = comparison.judge_repetitions(made.trajectory, made.truth, "right")
    assert all(one.is_kept for one in judged)
    assert len(walked) == 12


def test_no_piece_of_the_path_is_searched_for_twice(planar, monkeypatch):
    made = planar(repetitions=20, noise_rad=0.002)
    searched, search = [], cycles.search
    monkeypatch.setattr(
        cycles, "search", lambda piece, *given: searched.append(piece.tobytes()) or search(piece, *given)
    )
    assert len(comparison.find_repetitions(made.trajectory, "right")) == 20
    assert len(set(searched)) == len(searched) > 50
