"""The service is killed in mid-stream of some sessions; `python -m tests.benchmarks.crash` does it a hundred times."""

import asyncio
from pathlib import Path

import pytest

from tests.app.live.live_load import swaying
from tests.benchmarks import crash
from tests.benchmarks.service import environment_of, make_patient
from tests.ports import free_port

SESSIONS, TIMES = 3, 2


@pytest.mark.slow("the service starts three times while sessions stream")
def test_every_packet_is_stored_once_however_often_the_service_is_killed(tmp_path: Path) -> None:
    calibration, stream = swaying(crash.PERIOD_S)
    url, patient_id = make_patient(tmp_path, calibration)
    environment = environment_of(url, tmp_path, free_port())
    found = asyncio.run(crash.run(environment, patient_id, stream, SESSIONS, TIMES))
    assert len(found.lives) == TIMES + 1
    assert found.is_whole, found
    assert found.left_over == 0
    assert len(found.lives[-1].frame_s) == SESSIONS, "everybody who watched sees frames again"
