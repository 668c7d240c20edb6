"""Lists in pages: every row once, whatever comes and goes between two pages; small answers; places nobody makes up."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from sqlalchemy import Engine, delete, event, insert

from app.accounts import audit
from app.accounts.models import Account, DeviceToken
from app.assessment.models import Comparison
from app.database.base import new_id
from app.database.unit_of_work import unit_of_work
from app.exercises.models import Template, TemplateVersion
from app.patients.models import Grant, Patient
from app.recordings.models import Job, MotionSession, Result
from app.settings import Settings

from .conftest import ServiceClient, World

BEGUN = datetime(2026, 1, 5, 9, 0, tzinfo=UTC)
ALIKE = 7
"""So many rows are made in the same moment: more than a page holds."""
ROWS = 23


def session_row(world: World, number: int, patient_id: str | None = None) -> dict[str, Any]:
    return {
        "id": new_id(),
        "clinic_id": world.clinic_id,
        "patient_id": patient_id or world.patient_id,
        "purpose": "exercise",
        "source": "upload",
        "state": "analysed",
        "setup": {"pipeline": "arm"},
        "created_by": world.accounts["therapist"],
        "created_at": BEGUN + timedelta(seconds=number // ALIKE),
    }


def add_sessions(engine: Engine, world: World, count: int = ROWS, patient_id: str | None = None) -> list[str]:
    rows = [session_row(world, number, patient_id) for number in range(count)]
    with unit_of_work(engine) as session:
        session.execute(insert(MotionSession), rows)
    return [row["id"] for row in rows]


def following(answer: Any) -> str | None:
    """The address of the next page, as any client of the web finds it."""
    found = answer.links.get("next")
    return None if found is None else str(found["url"])


def pages(client: ServiceClient, path: str) -> Iterator[list[dict[str, Any]]]:
    at: str | None = path
    while at is not None:
        answer = client.get(at)
        assert answer.status_code == 200, answer.text
        yield answer.json()
        at = following(answer)


def rows_in_lists(engine: Engine, world: World) -> str:
    """Rows of every kind that is listed in pages, many made in the same moment; returns the session's id."""
    (session_id, *_) = add_sessions(engine, world)
    own = {"created_by": world.accounts["therapist"]}

    def at(number: int) -> dict[str, Any]:
        return {"id": new_id(), "created_at": BEGUN + timedelta(seconds=number // ALIKE)}

    result = at(0) | {"session_id": session_id, "kind": "offline", "pipeline": "arm", "pipeline_version": "1"}
    result |= {"orientation": "telemotion", "orientation_version": "1", "setup": {}, "layout": {}}
    template = (
        at(0) | own | {"clinic_id": world.clinic_id, "exercise_id": world.exercise_id, "name": "Same name"}
    )
    version = at(0) | own | {"template_id": template["id"], "number": 1, "content": b"", "repetitions": []}
    version |= {"source_session_id": session_id, "source_result_id": result["id"], "is_published": True}
    comparison = {"session_id": session_id, "result_id": result["id"], "template_version_id": version["id"]}
    comparison |= {"version": "1", "repetition_count": 0, "summary": {"measures": []}, "content": b""}
    job = own | {"session_id": session_id, "kind": "markers", "status": "failed"}
    token = own | {"clinic_id": world.clinic_id, "patient_id": world.patient_id, "label": "gateway"}
    token |= {"expires_at": BEGUN + timedelta(days=1)}
    person = {
        "clinic_id": world.clinic_id,
        "body_dimensions": {},
        "given_name": "Same",
        "family_name": "Name",
    }
    account = {
        "clinic_id": world.clinic_id,
        "role": "therapist",
        "display_name": "Same Name",
        "is_active": True,
    }
    numbers = range(ROWS)
    patients = [at(n) | person for n in numbers]
    grants = [
        at(n)
        | {"patient_id": one["id"], "account_id": world.accounts["therapist"], "level": "treat"}
        | {"granted_by": world.accounts["therapist"]}
        for n, one in enumerate(patients)
    ]
    with unit_of_work(engine) as session:
        session.execute(insert(Result), [result])
        session.execute(insert(Template), [template, *(template | at(n) for n in numbers)])
        session.execute(insert(TemplateVersion), [version])
        session.execute(insert(Comparison), [comparison | at(n) for n in numbers])
        session.execute(insert(Job), [job | at(n) | {"arguments": {"markers_id": new_id()}} for n in numbers])
        session.execute(insert(DeviceToken), [token | at(n) for n in numbers])
        session.execute(insert(Patient), patients)
        session.execute(insert(Grant), grants)
        session.execute(insert(Account), [account | at(n) | {"email": f"{n}@example.org"} for n in numbers])
        for _ in numbers:
            audit.record(session, world.subjects["therapist"], "patient.read", world.patient_id)
    return session_id


LISTS = [
    "/api/patients",
    "/api/patients?archived=false",
    "/api/caseload",
    "/api/accounts",
    "/api/templates",
    "/api/patients/{patient_id}/sessions",
    "/api/patients/{patient_id}/device-tokens",
    "/api/sessions/{session_id}/jobs",
    "/api/sessions/{session_id}/comparisons",
    "/api/sessions/{session_id}/markers",
]


def check_lists(client: ServiceClient, engine: Engine, world: World) -> None:
    session_id = rows_in_lists(engine, world)
    for path in LISTS:
        path = path.format(patient_id=world.patient_id, session_id=session_id)
        joined = "&" if "?" in path else "?"
        whole = client.get(f"{path}{joined}limit=200").json()
        found = list(pages(client, f"{path}{joined}limit=5"))
        assert [row for page in found for row in page] == whole, path
        assert len(whole) >= ROWS, path
        assert {len(page) for page in found[:-1]} == {5}, path


def test_pages_hold_every_row_once_in_the_order_of_the_list(
    therapist: ServiceClient, engine: Engine, world: World
) -> None:
    check_lists(therapist, engine, world)


def test_the_trail_goes_on_where_its_page_ended(
    therapist: ServiceClient, engine: Engine, world: World
) -> None:
    rows_in_lists(engine, world)
    first = therapist.get(f"/api/patients/{world.patient_id}/audit?limit=3")
    whole = therapist.get(f"/api/patients/{world.patient_id}/audit?limit=200").json()
    second = therapist.get(following(first) or "").json()
    # Reading the trail is itself in the trail, newest first: one more event before each later reading.
    assert whole[1:4] == first.json()
    assert whole[4:7] == second


def test_what_comes_and_goes_between_two_pages_hides_and_repeats_nothing(
    therapist: ServiceClient, engine: Engine, world: World
) -> None:
    ids = add_sessions(engine, world)
    path = f"/api/patients/{world.patient_id}/sessions"
    order = [row["id"] for row in therapist.get(path).json()]
    first = therapist.get(f"{path}?limit=5")
    # The row that the next page begins after goes, so do one seen and one unseen; new ones come before and amid.
    gone = {order[4], order[1], order[9]}
    with unit_of_work(engine) as session:
        session.execute(delete(MotionSession).where(MotionSession.id.in_(gone)))
    newest = session_row(world, 100 * ALIKE)
    with unit_of_work(engine) as session:
        session.execute(insert(MotionSession), [newest])
    rest = [row["id"] for page in pages(therapist, following(first) or "") for row in page]
    assert rest == [one for one in order[5:] if one not in gone]
    assert set(ids) == set(order)


def test_an_archived_patient_neither_hides_nor_repeats_the_others(
    therapist: ServiceClient, engine: Engine, world: World
) -> None:
    rows_in_lists(engine, world)
    whole = [row["id"] for row in therapist.get("/api/patients?archived=false&limit=200").json()]
    first = therapist.get("/api/patients?archived=false&limit=5")
    therapist.patch(f"/api/patients/{whole[4]}", json={"is_archived": True})
    rest = [row["id"] for page in pages(therapist, following(first) or "") for row in page]
    assert rest == whole[5:]


@pytest.mark.parametrize("after", ["x", "", "AAAA" * 20, "%00", "é", "=" * 40, "5", "a b"])
def test_a_place_that_is_made_up_is_refused_in_words(
    therapist: ServiceClient, world: World, after: str
) -> None:
    answer = therapist.get(f"/api/patients/{world.patient_id}/sessions", params={"after": after})
    assert answer.status_code == 422
    assert answer.json()["code"] == "invalid_input"
    assert "after" in str(answer.json()["details"])


def test_a_place_is_of_one_list_and_opens_nothing(
    sign_in: Any, therapist: ServiceClient, engine: Engine, world: World
) -> None:
    add_sessions(engine, world)
    add_sessions(engine, world, patient_id=world.other_patient_id)
    path = f"/api/patients/{world.patient_id}/sessions"
    link = following(therapist.get(f"{path}?limit=5")) or ""
    elsewhere = link.replace(world.patient_id, world.other_patient_id)
    assert therapist.get(elsewhere).status_code == 422, "another list"
    changed = link[:-1] + ("A" if link[-1] != "A" else "B")
    assert therapist.get(changed).status_code == 422, "not what the service wrote"
    assert sign_in("colleague").get(link).status_code == 404, "who may not see the patient"
    assert [row["patient_id"] for row in therapist.get(link).json()] == [world.patient_id] * 5


def test_no_name_stands_in_an_address(therapist: ServiceClient, world: World) -> None:
    link = following(therapist.get("/api/patients?limit=1")) or ""
    assert "after=" in link
    other = following(therapist.get("/api/patients?limit=1")) or ""
    # Sealed with a new nonce each time: not even the same place is written alike.
    assert link != other
    assert [row["id"] for row in therapist.get(link).json()] == [world.other_patient_id]


def test_a_page_has_at_most_so_many_rows(therapist: ServiceClient, world: World) -> None:
    path = f"/api/patients/{world.patient_id}/sessions"
    assert {therapist.get(f"{path}?limit={limit}").status_code for limit in (0, -1, 201, "x")} == {422}


def check_twenty_thousand(client: ServiceClient, engine: Engine, world: World) -> None:
    add_sessions(engine, world, 20_000)
    statements: list[str] = []

    def note(*told: Any) -> None:
        # Not the service's own, such as the check each second that it can store.
        if "motion_session" in told[2] or "exercise" in told[2] or "FROM patient" in told[2]:
            statements.append(told[2])

    event.listen(client.app.state.services.engine, "before_cursor_execute", note)
    path = f"/api/patients/{world.patient_id}/sessions"

    def statements_for(limit: int) -> int:
        """Return what one request takes; the service's own statements in between only add."""
        counts = []
        for _ in range(4):
            before = len(statements)
            assert len(client.get(f"{path}?limit={limit}").json()) == limit
            counts.append(len(statements) - before)
        return min(counts)

    assert statements_for(200) == statements_for(1), "statements do not grow with rows"
    many = client.get(f"{path}?limit=200")
    assert len(client.get(path).content) < 100_000
    assert len(many.content) < 100_000
    deep = client.get(following(many) or "")
    assert len(deep.json()) == 200
    (wanted,) = {
        one for one in statements if "FROM motion_session" in one and "page_0" in one and "< (" in one
    }
    if engine.dialect.name == "sqlite":
        with engine.connect() as connection:
            plan = connection.exec_driver_sql(
                "EXPLAIN QUERY PLAN " + wanted, (world.patient_id, "2026", "x", 9, 0)
            )
            steps = [row[3] for row in plan]
        assert any("ix_motion_session_patient_id_created_at_id" in step for step in steps), steps
        assert not any("TEMP B-TREE" in step for step in steps), "nothing is sorted to read a page"


def test_a_page_of_twenty_thousand_sessions_is_small(
    therapist: ServiceClient, engine: Engine, world: World
) -> None:
    check_twenty_thousand(therapist, engine, world)


@pytest.mark.postgres
class TestOnPostgreSQL:
    """The same order and the same places where the database compares rows by itself."""

    @pytest.fixture
    def settings(self, settings_on_postgresql: Settings) -> Settings:
        return settings_on_postgresql

    def test_pages(self, therapist: ServiceClient, engine: Engine, world: World) -> None:
        check_lists(therapist, engine, world)

    def test_twenty_thousand(self, therapist: ServiceClient, engine: Engine, world: World) -> None:
        check_twenty_thousand(therapist, engine, world)
