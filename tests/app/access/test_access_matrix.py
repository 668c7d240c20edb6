"""A stranger gets nothing: every route, every socket, every kind of stranger.

The table is `access_table`; the data is Ada's of `access_seed`. For every line about a patient's data:

- an outsider's answer is the same as for an identifier that does not exist, holds none of Ada's words, and
changes
  nothing in the database;
- an insider without the level is refused and changes nothing;
- an allowed subject gets through with the very same request, so a refusal cannot come from a wrong request.
"""

import contextlib
import json
import shutil
from concurrent.futures import CancelledError
from dataclasses import replace

import pytest
from fastapi.routing import iter_route_contexts
from starlette.testclient import WebSocketDenialResponse
from starlette.websockets import WebSocketDisconnect

from app.viewer import wire

from .access_seed import MARK, build_seed, write_log
from .access_service import make_settings, running
from .access_table import (
    CROSS,
    DEVICES,
    INSIDERS,
    LINES,
    OUTSIDERS,
    READ,
    WITHOUT_SIGN_IN,
)


@pytest.fixture(scope="session")
def seeded(tmp_path_factory, migrated_file, cheap_passwords):
    folder = tmp_path_factory.mktemp("seed")
    shutil.copy(migrated_file, folder / "seed.db")
    return build_seed(make_settings(folder, folder / "seed.db"), cheap_passwords, folder)


@pytest.fixture(scope="session")
def upload_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("upload") / "movement.tmlog"
    write_log(path)
    return path.read_bytes()


@pytest.fixture(scope="module")
def shared(seeded, upload_file, tmp_path_factory, cheap_passwords, warm_up_once):
    """One service for every request that must change nothing; the tests themselves check that nothing changes."""
    folder = tmp_path_factory.mktemp("shared")
    with running(seeded, folder, upload_file, cheap_passwords, warm_up_once) as service:
        yield service


@pytest.fixture
def fresh(seeded, upload_file, tmp_path, cheap_passwords, warm_up_once):
    """Make a service whose data a request may change."""
    with contextlib.ExitStack() as stack:
        yield lambda: stack.enter_context(
            running(seeded, tmp_path, upload_file, cheap_passwords, warm_up_once)
        )


def test_every_route_is_in_the_table(shared):
    registered = set()
    for route in iter_route_contexts(shared.routes):
        for method in route.methods or {"WS"}:
            registered.add((method, route.path))
    # No person reads /metrics, and nobody's data is in them; see test_metrics.
    assert registered - {("HEAD", "/"), ("GET", "/metrics")} == {(line.method, line.path) for line in LINES}


LINES_BY_KIND = {
    kind: [line for line in LINES if line.kind == kind]
    for kind in ("public", "signed_in", "clinic", "list", "patient", "role", "device", "socket")
}


def lines(*kinds):
    return pytest.mark.parametrize(
        "line", [line for kind in kinds for line in LINES_BY_KIND[kind]], ids=lambda line: line.name
    )


@lines("patient")
def test_outsiders_get_nothing_of_a_patient(line, shared):
    if line.prepare == "view":
        shared.prepare(line)
    before = shared.stored()
    for name in OUTSIDERS:
        answer = shared.send(name, line)
        unknown = shared.send(name, line, exists=False)
        # 422: the exercise is checked first, and is another clinic's as well.
        allowed = {401} if name in WITHOUT_SIGN_IN else {404, 403, 422} if name in DEVICES else {404, 422}
        if line.path.startswith("/api/accounts"):
            allowed = {401, 403, 404}
        assert answer.status_code in allowed, (name, answer.text)
        assert (answer.status_code, _of(answer)) == (unknown.status_code, _of(unknown)), name
        assert_silent(answer, name)
    assert shared.stored() == before


@lines("patient")
def test_insiders_get_what_their_level_covers(line, shared, fresh):
    if line.prepare == "view":
        shared.prepare(line)
    before = shared.stored()
    for name in INSIDERS:
        if name not in line.allowed:
            answer = shared.send(name, line)
            assert answer.status_code in {403, 404}, (name, answer.text)
            assert_silent(answer, name)
    assert shared.stored() == before
    # Those who may: all of them where nothing changes, otherwise one (the others' right is the same code
    # path).
    is_read = line.method == "GET"
    service = shared if is_read else fresh()
    if not is_read:
        service.prepare(line)
    for name in sorted(line.allowed) if is_read else sorted(line.allowed)[-1:]:
        answer = service.send(name, line)
        assert answer.status_code == line.status, (name, answer.text)


@lines("role")
def test_roles_decide_alone(line, shared, fresh):
    before = shared.stored()
    for name in (*OUTSIDERS, *INSIDERS):
        may = name in line.allowed or (
            # Staff of any clinic may do this in their own clinic.
            name in {"colleague", "former", "expired", "foreign_therapist", "foreign_administrator"}
            and ("therapist" in line.allowed or name == "foreign_administrator")
        )
        if not may:
            answer = shared.send(name, line)
            assert answer.status_code in {401, 403}, (name, answer.text)
    assert shared.stored() == before
    service = fresh()
    for name in sorted(line.allowed):
        assert service.send(name, line).status_code == line.status


@lines("device")
def test_a_device_asks_about_its_own_patient(line, shared):
    before = shared.stored()
    for name in (*OUTSIDERS, *INSIDERS):
        answer = shared.send(name, line)
        if name in DEVICES:
            # Other patients' devices may be refused for want of a consent.
            assert answer.status_code in ({line.status} if name == "device" else {line.status, 403}), (
                answer.text
            )
        else:
            assert answer.status_code in {401, 403}, (name, answer.text)
        assert_silent(answer, name)
    assert shared.stored() == before


@lines("clinic")
def test_a_clinic_is_closed_to_others(line, shared):
    for name in (*OUTSIDERS, *INSIDERS):
        answer = shared.send(name, line)
        if name in WITHOUT_SIGN_IN:
            assert answer.status_code == 401, name
        elif name.startswith("foreign"):
            assert answer.status_code in {403, 404}, name
            assert_silent(answer, name)
        elif name in DEVICES:
            assert answer.status_code == 403, name
        else:
            assert answer.status_code == 200, name


@lines("list")
def test_lists_hold_nothing_of_others(line, shared, seeded):
    for name in OUTSIDERS:
        answer = shared.send(name, line)
        if name in WITHOUT_SIGN_IN:
            assert answer.status_code == 401, name
        assert_silent(answer, name)
        for key in ("patient_id", "session_id", "template_id", "version_id", "prescription_id"):
            if key == "session_id" and line.path == "/api/templates" and not name.startswith("foreign"):
                # A template for the whole clinic names the recording it was made from; only the name.
                continue
            assert seeded.own[key] not in answer.text, (name, key)
        if name.startswith("foreign"):
            assert seeded.own["clinic_template_id"] not in answer.text
            for account in ("therapist", "patient", "administrator"):
                assert seeded.world.accounts[account] not in answer.text
    assert any(len(shared.send(name, line).text) > 10 for name in ("therapist", "administrator"))


@lines("signed_in")
def test_what_everybody_signed_in_may(line, shared, fresh):
    service = shared if line.method == "GET" else fresh()
    cookies_only = "cookies" in line.note
    for name in (*OUTSIDERS, "device"):
        answer = service.send(name, line)
        refused = name in WITHOUT_SIGN_IN or (cookies_only and (name in DEVICES))
        assert answer.status_code == (401 if refused else line.status), (name, answer.text)
        assert_silent(answer, name)


@lines("public")
def test_what_anybody_may_says_nothing(line, shared):
    path = "/caseload" if line.path == "/{path:path}" else line.path
    answer = shared.send("nobody", replace(line, path=path))
    assert answer.status_code in {200, 401, 503}
    assert_silent(answer, "nobody")


@pytest.mark.parametrize("line", CROSS, ids=lambda line: line.name)
def test_own_requests_cannot_reach_into_anothers_data(line, shared):
    before = shared.stored()
    for name in ("foreign_therapist", "foreign_administrator"):
        answer = shared.send(name, line)
        assert answer.status_code in {403, 404, 409, 422}, (name, answer.text)
        unknown = shared.send(name, line, exists=False)
        assert answer.status_code == unknown.status_code or line.path.endswith("progress"), name
        assert_silent(answer, name)
    assert shared.stored() == before


# --- sockets
# ---------------------------------------------------------------------------------------------------


@pytest.fixture
def listen(shared):
    """Open a socket as somebody, say what a client would, and return everything that comes until it
    closes."""

    def listen_as(name, path, first=None, headers=None, count=3, **arguments):
        received = []
        try:
            with shared.person(name).websocket_connect(path, headers=headers or {}, **arguments) as socket:
                if first is not None:
                    socket.send_text(json.dumps(first))
                for _ in range(count):
                    message = socket.receive()
                    if message["type"] == "websocket.close":
                        break
                    received.append(message)
        except (WebSocketDisconnect, WebSocketDenialResponse, CancelledError):
            # Refused, or left while the other side was still speaking.
            pass
        return received

    return listen_as


def assert_only_refusals(messages, name):
    assert all("bytes" not in message or message["bytes"] is None for message in messages), name
    for message in messages:
        content = json.loads(message["text"])
        assert content["type"] == "error", (name, content)
        assert content["code"] in {"sign_in_required", "not_found", "not_allowed"}, (name, content)
        assert MARK not in message["text"]
    assert len(messages) <= 1, name


def socket_path(line, service):
    return service.filler(service.names(line))(line.path)


def socket_arguments(line):
    if line.path == "/viewer/{view_id}":
        return {"subprotocols": [wire.PROTOCOL]}
    return {}


@lines("socket")
def test_sockets_are_closed_to_strangers(line, listen, shared):
    path = socket_path(line, shared)
    first = {"ticket": "made up"}
    if line.path == "/ws/ingest":
        first = hello("made up")
    for name in OUTSIDERS:
        assert_only_refusals(listen(name, path, first, **socket_arguments(line)), name)
    for name in INSIDERS:
        if name not in line.allowed:
            assert_only_refusals(listen(name, path, first, **socket_arguments(line)), name)


@pytest.mark.parametrize(
    "line", [line for line in LINES_BY_KIND["socket"] if line.allowed], ids=lambda line: line.name
)
def test_sockets_open_for_who_may_but_not_from_other_sites(line, listen, shared):
    path = socket_path(line, shared)
    for name in sorted(line.allowed):
        messages = listen(name, path, count=1, **socket_arguments(line))
        assert len(messages) == 1, name
        text = messages[0].get("text") or ""
        assert '"error"' not in text, text
        for origin in ("https://evil.example", "null", ""):
            refused = listen(name, path, headers={"Origin": origin}, **socket_arguments(line))
            assert_only_refusals(refused, (name, origin))


def hello(ticket):
    return {
        "type": "hello",
        "protocol_version": 1,
        "ticket": ticket,
        "placements": ["upper_arm_right", "forearm_right"],
        "rate_hz": 100.0,
    }


def test_a_ticket_opens_its_own_session_and_purpose_only(listen, shared, seeded):
    own, foreign = seeded.own["session_id"], seeded.foreign["session_id"]

    def ticket(name, session_id, purpose):
        answer = shared.person(name).post(f"/api/sessions/{session_id}/ticket", json={"purpose": purpose})
        assert answer.status_code == 200, answer.text
        return answer.json()["ticket"]

    foreign_ticket = ticket("foreign_therapist", foreign, "live")
    assert_only_refusals(listen("nobody", f"/ws/live/{own}", {"ticket": foreign_ticket}), "foreign ticket")
    ingest_ticket = ticket("patient", own, "ingest")
    assert_only_refusals(listen("nobody", f"/ws/live/{own}", {"ticket": ingest_ticket}), "wrong purpose")
    live_ticket = ticket("patient", own, "live")
    assert_only_refusals(listen("nobody", "/ws/ingest", hello(live_ticket)), "wrong purpose")
    good = ticket("patient", own, "live")
    (first,) = listen("nobody", f"/ws/live/{own}", {"ticket": good}, count=1)
    assert json.loads(first["text"])["type"] == "layout"
    assert_only_refusals(listen("nobody", f"/ws/live/{own}", {"ticket": good}), "second use")


def _of(answer):
    """What an answer says, without the number that each request has of its own."""
    return {key: value for key, value in answer.json().items() if key != "request_id"}


def assert_silent(answer, name):
    """Nothing of Ada's words, and for errors nothing but the error."""
    assert MARK.encode() not in answer.content, name
    if answer.status_code >= 400 and answer.headers.get("content-type", "").startswith("application/json"):
        # The words as a code, and the number of the request for the log, say nothing of anybody.
        assert set(answer.json()) - {"sentences", "request_id"} == {"code", "message", "details"}


def test_the_seed_would_show_a_leak(shared):
    """The marks are where a leak would show them."""
    for path in ("/api/patients/{patient_id}", "/api/patients/{patient_id}/device-tokens"):
        line = next(line for line in LINES if line.path == path and line.method == "GET")
        assert MARK in shared.send("therapist", line).text
    assert {line.allowed for line in LINES_BY_KIND["patient"]} >= {READ}
