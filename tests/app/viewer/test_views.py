"""Opening views: who may, what comes back, and the page."""

import asyncio
import re

import pytest

from app.accounts.models import AuditEvent
from app.database.unit_of_work import unit_of_work
from app.patients.models import Grant
from app.recordings.schemas import ViewIn
from app.settings import Allowance
from app.viewer.page import build_page
from app.viewer.service import MOST_OF_ACCOUNT, Viewer


def test_a_therapist_opens_a_replay(therapist, open_view) -> None:
    opened = open_view(therapist)
    assert opened["page_path"] == f"/viewer/{opened['id']}/"
    assert opened["control_path"] == f"/ws/views/{opened['id']}"
    page = therapist.get(opened["page_path"])
    assert page.status_code == 200
    assert page.headers["content-type"].startswith("text/html")
    assert page.headers["x-frame-options"] == "SAMEORIGIN"


@pytest.mark.parametrize("name", ["therapist", "reader", "patient", "administrator"])
def test_who_may_read_may_look(name: str, sign_in, open_view) -> None:
    client = sign_in(name)
    assert client.get(open_view(client)["page_path"]).status_code == 200


@pytest.mark.parametrize(
    "name",
    [
        "colleague",
        "former",
        "expired",
        "other_patient",
        "integrator",
        "foreign_therapist",
        "foreign_administrator",
    ],
)
def test_who_has_no_right_learns_nothing(name: str, sign_in, therapist, open_view, recorded) -> None:
    """Neither opening a view nor another's view, its page, its socket or its controls."""
    opened = open_view(therapist)
    stranger = sign_in(name)
    for session_id in (recorded.session_id, recorded.live_session_id):
        answer = stranger.post(f"/api/sessions/{session_id}/views", json={"mode": "replay"})
        assert answer.status_code == 404
    assert stranger.get(opened["page_path"]).status_code == 404


def test_nobody_gets_nothing(nobody, therapist, open_view, recorded) -> None:
    opened = open_view(therapist)
    assert (
        nobody.post(f"/api/sessions/{recorded.session_id}/views", json={"mode": "replay"}).status_code == 401
    )
    assert nobody.get(opened["page_path"]).status_code == 401


def test_a_device_token_opens_no_view(device_client, world, recorded) -> None:
    device = device_client(world.patient_id)
    answer = device.post(f"/api/sessions/{recorded.session_id}/views", json={"mode": "replay"})
    assert answer.status_code == 403


def test_a_view_is_its_owners_even_among_those_who_may_read(sign_in, therapist, open_view) -> None:
    opened = open_view(therapist)
    assert sign_in("reader").get(opened["page_path"]).status_code == 404


def test_a_revoked_right_closes_the_page(therapist, open_view, engine, world) -> None:
    opened = open_view(therapist)
    with unit_of_work(engine) as session:
        session.query(Grant).filter_by(account_id=world.accounts["therapist"]).delete()
    assert therapist.get(opened["page_path"]).status_code == 404


def test_an_erased_session_closes_the_page(therapist, open_view, recorded) -> None:
    opened = open_view(therapist)
    assert therapist.delete(f"/api/sessions/{recorded.session_id}").status_code in (200, 204)
    assert therapist.get(opened["page_path"]).status_code == 404


def test_opening_a_view_leaves_an_audit_event(therapist, open_view, engine, recorded) -> None:
    open_view(therapist)
    with unit_of_work(engine) as session:
        event = session.query(AuditEvent).filter_by(action="session.view").one()
        assert (event.resource_id, event.details) == (recorded.session_id, {"mode": "replay"})


def test_a_template_of_another_clinic_is_not_found(sign_in, therapist, recorded) -> None:
    answer = therapist.post(
        f"/api/sessions/{recorded.session_id}/views",
        json={"mode": "replay", "template_version_id": "0" * 32},
    )
    assert answer.status_code == 404


def test_a_live_view_of_an_ended_session_is_refused_with_advice(therapist, recorded) -> None:
    answer = therapist.post(f"/api/sessions/{recorded.session_id}/views", json={"mode": "live"})
    assert answer.status_code == 409
    assert "replay" in answer.json()["message"]


def test_a_replay_without_a_result_is_refused_with_advice(therapist, recorded) -> None:
    answer = therapist.post(f"/api/sessions/{recorded.live_session_id}/views", json={"mode": "replay"})
    assert answer.status_code == 404
    assert "result" in answer.json()["message"]


def test_too_many_scenes_are_refused_and_say_when_to_come_back(
    therapist, open_view, services, recorded
) -> None:
    services.limits._allowances["views"] = Allowance(1, 2, 3)
    opened = open_view(therapist)
    view = services.get(Viewer)._views[opened["id"]]
    with view.watched():  # somebody looks at it, so it cannot be taken down for the next one
        answer = therapist.post(f"/api/sessions/{recorded.session_id}/views", json={"mode": "replay"})
    assert (answer.status_code, answer.json()["code"]) == (429, "limit_reached")
    assert "Close one" in answer.json()["message"]
    assert "Retry-After" in answer.headers
    assert (
        therapist.post(f"/api/sessions/{recorded.session_id}/views", json={"mode": "replay"}).status_code
        == 201
    )
    assert services.get(Viewer).stage_count == 1
    assert services.limits.held("views", "service") == 1
    assert (
        therapist.get(opened["page_path"]).status_code == 200
    )  # the first view's scene is built again when needed


def test_many_who_make_room_at_once_do_not_trip_over_each_other(
    therapist, open_view, services, nobody
) -> None:
    for _ in range(3):
        open_view(therapist)

    async def sweep_together() -> None:
        await asyncio.gather(*(services.get(Viewer)._sweep(0.0) for _ in range(4)))

    nobody.portal.call(sweep_together)
    assert services.get(Viewer).stage_count == 0
    assert services.limits.held("views", "service") == 0


def test_live_views_share_a_scene_and_replays_do_not(therapist, sign_in, open_view, services) -> None:
    open_view(therapist, "live")
    open_view(sign_in("reader"), "live")
    assert services.get(Viewer).stage_count == 1
    assert services.limits.held("views", "service") == 2, "each has a place of its own account's"
    open_view(therapist)
    open_view(therapist)
    assert services.get(Viewer).stage_count == 3


def test_a_thousand_views_of_one_account_end_nobody_elses(
    therapist, sign_in, open_view, services, recorded, nobody, monkeypatch
) -> None:
    """Not of another account, another language or another clinic; what she watches herself stays too."""
    viewer = services.get(Viewer)
    others = [open_view(sign_in("reader"), mode, language="de") for mode in ("live", "replay")]
    watched = viewer._views[open_view(therapist, "live")["id"]]
    first = open_view(therapist, "live")
    subject = watched.owner
    # The right is looked up once: a thousand events of the audit take their time.
    monkeypatch.setattr("app.viewer.service.repository.find_target", lambda *_: watched.target)

    async def open_many() -> list[str]:
        wanted = ViewIn(mode="live")
        return [(await viewer.open(subject, recorded.live_session_id, wanted)).id for _ in range(1001)]

    with watched.watched():
        made = nobody.portal.call(open_many)
    assert all(sign_in("reader").get(other["page_path"]).status_code == 200 for other in others)
    assert therapist.get(first["page_path"]).status_code == 404
    assert therapist.get(f"/viewer/{made[-1]}/").status_code == 200
    assert watched.id in viewer._views
    assert sum(one.owner.id == subject.id for one in viewer._views.values()) == MOST_OF_ACCOUNT
    assert services.limits.held("views", "account", subject.id) <= services.settings.limit_views.account
    assert viewer.stage_count == 3, "nobody else's scene was taken down, and hers was built once"


def test_a_full_clinic_refuses_and_takes_down_nobody_elses_scene(
    therapist, sign_in, open_view, services, recorded
) -> None:
    services.limits._allowances["views"] = Allowance(2, 2, 9)
    open_view(therapist)
    open_view(therapist)
    wanted = {"mode": "replay"}
    answer = sign_in("reader").post(f"/api/sessions/{recorded.session_id}/views", json=wanted)
    assert (answer.status_code, answer.json()["details"]["scope"]) == (429, "clinic")
    assert services.get(Viewer).stage_count == 2


def test_live_views_in_two_languages_are_two_scenes(therapist, open_view, services) -> None:
    open_view(therapist, "live", language="de")
    open_view(therapist, "live", language="de")
    assert services.get(Viewer).stage_count == 1
    open_view(therapist, "live")
    assert services.get(Viewer).stage_count == 2


def test_the_policy_allows_the_pages_own_scripts_and_nothing_else(therapist, open_view) -> None:
    page = therapist.get(open_view(therapist)["page_path"])
    policy = dict(part.split(" ", 1) for part in page.headers["content-security-policy"].split("; "))
    assert policy["default-src"] == "'none'"
    assert policy["frame-ancestors"] == "'self'"
    assert "unsafe-inline" not in policy["script-src"]
    assert "unsafe-eval" not in policy["script-src"].replace("wasm-unsafe-eval", "")
    assert "http" not in policy["script-src"]
    assert "ws://127.0.0.1:8000" in policy["connect-src"]


def test_the_page_loads_nothing_from_elsewhere_and_names_no_one() -> None:
    html = build_page().html
    head = re.sub(r'data-p="[^"]*"', "", html)
    assert not re.search(r'(src|href)="(https?:)?//', head)
    assert "<title>Movement in 3D</title>" in head
