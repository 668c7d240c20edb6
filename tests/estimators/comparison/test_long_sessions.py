"""A long session must be cut like a short one: turning points explain it nearly as well as rest does."""

import pytest

from estimators import comparison, pipelines
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
