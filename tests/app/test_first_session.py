"""The program of docs/first-session.md, run as it stands there against the running service."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from sqlalchemy import select

from app.database.unit_of_work import read_only
from app.live import warmup
from app.main import create_app
from app.recordings.models import MotionSession, SignalChunk
from tests.ports import free_port

from .serving import serving

PAGE = Path(__file__).parents[2] / "docs" / "first-session.md"


@pytest.mark.slow
def test_the_program_of_the_page_stores_a_session(
    settings, engine, world, cheap_passwords, device_token, warm_up_once, monkeypatch
):
    (program,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)
    monkeypatch.setattr(warmup, "load_or_compile", warm_up_once)
    with serving(create_app(settings, passwords=cheap_passwords), free_port()) as address:
        done = subprocess.run(
            [sys.executable, "-c", program],
            env=os.environ
            | {"SERVER": address, "TOKEN": device_token(world.patient_id), "PATIENT": world.patient_id},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
    assert "50 packets stored" in done.stdout, done.stderr
    with read_only(engine) as session:
        assert session.scalars(select(MotionSession.setup)).one()["placements"] == [
            "upper_arm_right",
            "forearm_right",
        ]
        ticks = session.scalars(select(SignalChunk.ticks).where(SignalChunk.stream == "raw")).all()
    assert sum(ticks) == 500
