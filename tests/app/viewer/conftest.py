"""A stored session of five reaches with its template and comparison."""

from collections.abc import Callable

import pytest
from sqlalchemy import Engine

from app.database.unit_of_work import unit_of_work
from tests.app.viewer.stored_reaches import Reaches, Recorded, compared_reaches, store


@pytest.fixture(scope="session")
def reaches() -> Reaches:
    return compared_reaches()


@pytest.fixture
def recorded(world, engine: Engine, reaches: Reaches) -> Recorded:
    with unit_of_work(engine) as session:
        return store(
            session,
            world.clinic_id,
            world.patient_id,
            world.exercise_id,
            world.accounts["therapist"],
            reaches,
        )


OpenView = Callable[..., dict[str, str]]


@pytest.fixture
def open_view(recorded: Recorded) -> OpenView:
    """Open a view as the given client; returns the answer."""

    def make(client, mode: str = "replay", **fields: str) -> dict[str, str]:
        session_id = recorded.live_session_id if mode == "live" else recorded.session_id
        answer = client.post(f"/api/sessions/{session_id}/views", json={"mode": mode, **fields})
        assert answer.status_code == 201, answer.text
        return answer.json()

    return make
