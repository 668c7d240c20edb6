"""The demonstration's walks show what they are there for, in the numbers that are found."""

import pytest

from app import readers
from app.commands.processing.walk import analyse
from app.demo.walks import PAST_WALKS, WIDTH_M, _simulate
from estimators.pipelines import SessionSetup


@pytest.mark.slow
def test_the_first_walk_limps_and_the_last_does_not(tmp_path) -> None:
    found = []
    for walk in PAST_WALKS:
        path = tmp_path / "walk.csv"
        _simulate(walk, path)
        measured = readers.read(path, "instrumented_shoe")
        placements = tuple(measured.placements)
        setup = SessionSetup("gait", placements, measured.nominal_rate_hz, feet_apart_m=WIDTH_M)  # type: ignore[arg-type]
        analysed, _, _ = analyse(measured, measured, setup)
        found.append({name: one.value for name, one in analysed.summary.asymmetry.items()})
    limping, even = found
    # The paretic left leg steps late, stands shortly and is hardly raised; strides of two feet are equally long.
    assert limping["step_time"] > 0.25
    assert limping["stance_share"] < -0.2
    assert limping["clearance"] < -0.2
    assert all(abs(value) < 0.1 for value in even.values())
