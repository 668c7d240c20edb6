"""The demonstration's cameras: what they see fits the sensor that the session streams, with three gaps."""

from pathlib import Path

import pytest

from app.commands.simulation.arm import scenario_of
from app.demo.history import PAST, _options
from app.demo.markers import HIDDEN_S, LATE_S, MARKER_M, write_markers
from app.demo.people import PATIENTS
from app.ingest.marker_fusion import fuse_tracks, report_of
from app.readers import read_markers
from app.readers.markers.schemas import MarkerFileIn
from estimators import signals
from estimators.simulation import simulate_arm


@pytest.mark.slow
def test_the_marker_of_the_past_session_is_fused_with_its_hand(tmp_path: Path) -> None:
    person = PATIENTS[0]
    (past,) = [one for one in PAST[person.email] if one.has_cameras]
    # Lost packets would have to be bridged: the picture is to show the gaps of the cameras.
    assert past.loss_percent == 0.0
    scenario = scenario_of(_options(person, "patient", "exercise", seed=105))
    path = tmp_path / "hand.csv"
    write_markers(scenario, "hand_right", path)
    declared = MarkerFileIn(format="csv")
    worn = signals.to_common_ticks(simulate_arm(scenario).recording, scenario.rate_hz)
    row = scenario.placements.index("hand_right")
    fusion, name = fuse_tracks(
        read_markers(path, declared),
        declared,
        worn.time_step_s,
        worn.gyroscope_radps[row],
        worn.accelerometer_mps2[row],
    )
    report = report_of(fusion, name)
    assert report.offset_s == pytest.approx(-LATE_S, abs=0.005)
    assert report.lever_arm_m == pytest.approx(MARKER_M.tolist(), abs=0.01)
    assert [gap.length_s for gap in report.gaps] == pytest.approx(HIDDEN_S, abs=0.03)
    assert max(report.residual_rms_m) < 0.001
