"""The HTTP edge: headers, limits, errors, origin and CSRF, the client's files, the description, logs."""

import gzip
import json
import logging
import shutil

import pytest
from fastapi import APIRouter
from sqlalchemy.exc import OperationalError
from starlette.websockets import WebSocketDisconnect

from app.accounts.models import Account
from app.database.unit_of_work import read_only
from app.errors import TelemotionError, Unavailable
from app.main import create_app
from app.settings import Settings

from .conftest import BASE_URL, PASSWORD, ServiceClient


@pytest.fixture
def client_files(tmp_path):
    folder = tmp_path / "client"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<!doctype html><title>client</title>")
    (folder / "assets" / "app-1a2b.js").write_text("void 0")
    (tmp_path / "secret.txt").write_text("outside")
    return folder


def open_client(settings, cheap_passwords, **changes):
    settings = Settings(
        _env_file=None,
        **(settings.model_dump() | {"secret_key": settings.secret_key.get_secret_value()} | changes),
    )
    base_url = changes.get("base_url", BASE_URL)
    return ServiceClient(
        create_app(settings, passwords=cheap_passwords), base_url=base_url, raise_server_exceptions=False
    )


def test_files_are_sent_packed_to_whoever_takes_them(settings, cheap_passwords, client_files):
    script = client_files / "assets" / "app-1a2b.js"
    script.with_name("app-1a2b.js.br").write_bytes(b"packed by brotli")
    script.with_name("app-1a2b.js.gz").write_bytes(gzip.compress(script.read_bytes()))
    with open_client(settings, cheap_passwords, client_dir=client_files) as client:

        def fetch(accepted, path="/assets/app-1a2b.js"):
            return client.get(path, headers={"Accept-Encoding": accepted})

        packed = fetch("gzip, deflate")
        plain = fetch("identity")
        page = fetch("gzip", "/")
        best = client.stream("GET", "/assets/app-1a2b.js", headers={"Accept-Encoding": "gzip, br"})
        with best as answer:
            assert answer.headers["content-encoding"] == "br"
    assert (packed.headers["content-encoding"], packed.text) == ("gzip", "void 0")
    assert packed.headers["content-type"].startswith("text/javascript")
    assert packed.headers["vary"] == "Accept-Encoding"
    assert "immutable" in packed.headers["cache-control"]
    assert "content-encoding" not in plain.headers
    assert plain.text == "void 0"
    assert plain.headers["vary"] == "Accept-Encoding", "a cache must not give the packed one to the other"
    assert "content-encoding" not in page.headers, "no packed twin, no claim"


def test_every_answer_carries_the_security_headers(therapist, world):
    for path in ("/", "/api/health", f"/api/patients/{world.patient_id}", "/api/nothing", "/assets/none.js"):
        headers = therapist.get(path).headers
        policy = headers["content-security-policy"]
        assert "default-src 'self'" in policy
        assert "script-src 'self';" in policy, "neither inline scripts nor eval"
        assert "frame-ancestors 'none'" in policy
        assert "ws://127.0.0.1:8000" in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["x-frame-options"] == "DENY"
        assert headers["referrer-policy"] == "no-referrer"
        if path.startswith("/api/"):
            assert headers["cache-control"] == "no-store"


def test_https_makes_cookies_secure_and_binds_browsers(settings, cheap_passwords, world, engine):
    with open_client(settings, cheap_passwords, base_url="https://clinic.example.org") as client:
        from app.accounts.models import Account
        from app.database.unit_of_work import read_only

        with read_only(engine) as session:
            email = session.get(Account, world.accounts["therapist"]).email
        answer = client.post("/api/sign-in", json={"email": email, "password": "a long enough password"})
        assert answer.status_code == 200
        assert "; secure" in answer.headers["set-cookie"].lower()
        assert "max-age" in answer.headers["strict-transport-security"]
        assert "wss://clinic.example.org" in answer.headers["content-security-policy"]


def test_a_route_may_have_its_own_policy(application):
    router = APIRouter()

    @router.get("/api/framed")
    def framed():
        from fastapi.responses import HTMLResponse

        return HTMLResponse(
            "", headers={"Content-Security-Policy": "frame-ancestors 'self'", "X-Frame-Options": "SAMEORIGIN"}
        )

    application.router.routes.insert(0, router.routes[0])
    with ServiceClient(application, base_url=BASE_URL) as client:
        headers = client.get("/api/framed").headers
    assert headers["content-security-policy"] == "frame-ancestors 'self'"
    assert headers["x-frame-options"] == "SAMEORIGIN"


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 201),
        ({"Origin": "https://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": "http://127.0.0.1:8001"}, 403),
        ({"Origin": "https://127.0.0.1:8000"}, 403),
        ({"Origin": ""}, 403),
        ({"X-CSRF-Token": ""}, 403),
        ({"X-CSRF-Token": "x" * 43}, 403),
    ],
)
def test_changes_by_cookie_need_our_origin_and_the_token(therapist, headers, status):
    therapist.headers.update(headers)
    answer = therapist.post("/api/patients", json={"given_name": "A", "family_name": "B"})
    assert answer.status_code == status


def test_a_missing_origin_is_no_origin(therapist):
    del therapist.headers["Origin"]
    assert therapist.post("/api/patients", json={"given_name": "A", "family_name": "B"}).status_code == 403
    assert therapist.get("/api/patients").status_code == 200, "reading changes nothing"


def test_the_token_of_another_session_does_not_help(sign_in):
    first, second = sign_in("therapist"), sign_in("therapist")
    first.headers["X-CSRF-Token"] = second.headers["X-CSRF-Token"]
    assert first.post("/api/patients", json={"given_name": "A", "family_name": "B"}).status_code == 403


def test_another_site_cannot_sign_a_browser_in(nobody):
    answer = nobody.post(
        "/api/sign-in",
        json={"email": "a@b.example", "password": "x"},
        headers={"Origin": "https://evil.example"},
    )
    assert answer.status_code == 403


def test_over_https_cookies_are_the_hosts_own(settings, cheap_passwords, world, engine):
    with read_only(engine) as session:
        email = session.get(Account, world.accounts["therapist"]).email
    origin = "https://clinic.example.org"
    body = {"email": email, "password": PASSWORD}
    with open_client(settings, cheap_passwords, base_url=origin) as client:
        answer = client.post("/api/sign-in", json=body, headers={"Origin": origin})
        cookies = answer.headers.get_list("set-cookie")
        assert [one.partition("=")[0] for one in cookies] == [
            "__Host-telemotion_session",
            "__Host-telemotion_browser",
        ]
        for one in cookies:
            assert "; Secure" in one
            assert "; Path=/;" in f"{one};"
            assert "Domain" not in one
        assert client.get("/api/me").status_code == 200
        # A neighbour under the same domain can set one without the prefix.
        value = client.cookies["__Host-telemotion_session"]
        client.cookies.clear()
        client.cookies.set("telemotion_session", value)
        assert client.get("/api/me").status_code == 401
        client.cookies.clear()
        client.cookies.set("__Host-telemotion_session", value)
        headers = {"Origin": origin, "X-CSRF-Token": answer.json()["csrf_token"]}
        ended = client.post("/api/sign-out", headers=headers)
        assert ended.headers["set-cookie"].startswith('__Host-telemotion_session=""; ')
        assert "Max-Age=0" in ended.headers["set-cookie"]


@pytest.mark.parametrize("demo", [False, True])
def test_this_machine_has_several_names_and_a_public_service_one(settings, cheap_passwords, world, demo):
    body = {"email": "a@b.example", "password": "x"}

    def enter(client, name):
        return client.post(
            "/api/sign-in", json=body, headers={"Origin": f"http://{name}", "Host": name}
        ).status_code

    with open_client(settings, cheap_passwords, demo=demo) as client:
        assert [enter(client, name) for name in ("localhost:8000", "other-name:8000")] == [401, 421]
    if not demo:
        with open_client(settings, cheap_passwords, base_url="https://clinic.example.org") as client:
            assert enter(client, "localhost:8000") == 421
            assert enter(client, "clinic.example.org") == 403, "not over http"


def test_large_bodies_are_refused_by_their_length_and_while_they_come(therapist):
    large = b'{"given_name": "' + b"a" * (1 << 20) + b'"}'
    declared = therapist.post("/api/patients", content=large, headers={"Content-Type": "application/json"})
    assert declared.status_code == 413
    assert declared.json()["code"] == "too_large"
    assert declared.json()["details"]["limit_bytes"] == 1 << 20

    def pieces():
        for _ in range(40):
            yield b"a" * (1 << 15)

    streamed = therapist.post("/api/patients", content=pieces(), headers={"Content-Type": "application/json"})
    assert (streamed.status_code, streamed.json()["code"]) == (413, "too_large")


def test_errors_are_typed_and_silent_about_their_inside(application, caplog):
    router = APIRouter()

    @router.get("/api/broken")
    def broken():
        raise ValueError("Ada Lindqvist")

    @router.get("/api/busy")
    def busy():
        raise Unavailable("busy", retry_after_s=7)

    @router.get("/api/locked")
    def locked():
        raise OperationalError("SELECT 1", {}, Exception("database is locked"))

    @router.get("/api/bug")
    def bug():
        raise TelemotionError("odd")

    for route in router.routes:
        application.router.routes.insert(0, route)
    with ServiceClient(application, base_url=BASE_URL, raise_server_exceptions=False) as client:
        answer = client.get("/api/broken")
        assert (answer.status_code, answer.json()["code"]) == (500, "internal")
        assert "Ada" not in answer.text
        assert "default-src 'self'" in answer.headers["content-security-policy"]
        locked = client.get("/api/locked")
        assert (locked.status_code, locked.json()["code"]) == (503, "unavailable")
        assert locked.headers["retry-after"] == "5"
        assert client.get("/api/busy").headers["retry-after"] == "7"
        assert client.get("/api/bug").status_code == 500
        assert client.get("/api/nothing").json()["code"] == "not_found"
        assert client.post("/api/health").json()["code"] == "method_not_allowed"


def test_the_client_is_served_with_its_first_page_for_every_page(settings, cheap_passwords, client_files):
    with open_client(settings, cheap_passwords, client_dir=client_files) as client:
        for path in ("/", "/caseload", "/patients/abc/sessions/def"):
            page = client.get(path)
            assert "<title>client</title>" in page.text
            assert page.headers["cache-control"] == "no-cache"
        script = client.get("/assets/app-1a2b.js")
        assert script.text == "void 0"
        assert "immutable" in script.headers["cache-control"]
        for path in ("/api/none", "/ws/none", "/viewer/none", "/assets/none.js", "/favicon.ico"):
            assert client.get(path).status_code in {401, 404}, path
        for path in (
            "/../secret.txt",
            "/%2e%2e/secret.txt",
            "/assets/..%2f..%2fsecret.txt",
            "/..%5csecret.txt",
        ):
            assert "outside" not in client.get(path).text


def test_without_a_built_client_it_says_what_to_do(settings, cheap_passwords, tmp_path):
    with open_client(settings, cheap_passwords, client_dir=tmp_path / "none") as client:
        page = client.get("/")
    assert page.status_code == 503
    assert "make web" in page.text


def test_the_interface_is_described_to_insiders_only(
    nobody, therapist, settings, cheap_passwords, migrated_file, tmp_path
):
    for path in ("/api/openapi.json", "/api/docs"):
        assert nobody.get(path).status_code == 401
        assert therapist.get(path).status_code == 200
    for path in ("/docs", "/redoc", "/openapi.json"):
        assert "openapi" not in therapist.get(path).text.lower()
    page = therapist.get("/api/docs").text
    assert "/api/patients/{patient_id}" in page
    assert "<script" not in page
    shutil.copy(migrated_file, tmp_path / "demo.db")
    url = f"sqlite:///{tmp_path / 'demo.db'}"
    with open_client(settings, cheap_passwords, demo=True, database_url=url) as client:
        assert client.get("/api/openapi.json").json()["info"]["title"] == "Telemotion"


def test_logs_hold_templates_and_no_identifiers(therapist, world, caplog):
    with caplog.at_level(logging.INFO):
        therapist.get(f"/api/patients/{world.patient_id}/progress?exercise_id={world.exercise_id}")
        therapist.get("/patients/Ada-Lindqvist")
    lines = [record.getMessage() for record in caplog.records if record.name == "telemotion.access"]
    assert any("GET /api/patients/{patient_id}/progress 200" in line for line in lines)
    text = "\n".join(lines)
    assert world.patient_id not in text
    assert world.exercise_id not in text
    assert "Ada" not in text


def test_health_needs_no_sign_in_and_tells_little(nobody):
    assert set(nobody.get("/api/health").json()) == {"status", "version"}


def test_a_database_that_was_not_migrated_refuses_to_start(settings, cheap_passwords, tmp_path):
    from app.errors import Conflict

    with (
        pytest.raises(Conflict, match="telemotion migrate"),
        open_client(settings, cheap_passwords, database_url=f"sqlite:///{tmp_path / 'new.db'}"),
    ):
        pass


BROKEN = ["a\0b", "\ud800"]


@pytest.mark.parametrize("broken", BROKEN)
def test_broken_text_is_refused_in_words(nobody, therapist, world, broken):
    text = json.dumps(broken)
    json_type = {"Content-Type": "application/json"}
    body = f'{{"email": {text}, "password": "x"}}'
    answer = nobody.post("/api/sign-in", content=body, headers={**json_type, "Origin": BASE_URL})
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid_input")
    body = f'{{"given_name": {text}, "family_name": "B"}}'
    assert therapist.post("/api/patients", content=body, headers=json_type).status_code == 422
    body = f'{{{text}: 1, "given_name": "A", "family_name": "B"}}'
    assert therapist.post("/api/patients", content=body, headers=json_type).status_code == 422
    named = f'"patient_id": "{world.patient_id}", "placements": ["hand_right"]'
    body = f'{{{named}, "orientation_parameters": {{"a": [{text}]}}}}'
    assert therapist.post("/api/sessions", content=body, headers=json_type).status_code == 422


def test_an_address_longer_than_any_file_name_is_not_found(settings, cheap_passwords, client_files):
    with open_client(settings, cheap_passwords, client_dir=client_files) as client:
        for path in ("/" + "a" * 256, "/" + "ü" * 128, f"/assets/{'a' * 256}.js", "/" + "a/" * 2500):
            answer = client.get(path)
            assert (answer.status_code, answer.json()["code"]) == (404, "not_found"), path
        assert client.get("/api/patients/" + "a" * 300).status_code == 404
        longest = "/" + "a/" * 2040
        assert client.get(longest).status_code == 200, (
            "with the folder of the client it is longer than a path may be"
        )


@pytest.mark.parametrize(
    "host", ["evil.example:8000", "127.0.0.1.evil.example", "localhost.evil", "10.0.0.7", ""]
)
def test_a_page_of_another_name_reaches_nothing(nobody, therapist, world, host):
    """As after DNS rebinding: the attacker's name leads to this machine."""
    by_address = () if host == "10.0.0.7" else ("/metrics", "/api/health")
    for path in ("/", f"/api/patients/{world.patient_id}", *by_address):
        answer = therapist.get(path, headers={"Host": host})
        assert (answer.status_code, answer.json()["code"]) == (421, "misdirected"), path
    answer = therapist.post("/api/sign-out", headers={"Host": host, "Origin": f"http://{host}"})
    assert answer.status_code == 421
    with pytest.raises(WebSocketDisconnect), nobody.websocket_connect("/ws/ingest", headers={"Host": host}):
        pass


def test_the_own_names_and_health_by_address_are_answered(nobody):
    for host in ("127.0.0.1:8000", "localhost:9", "[::1]:8000", "demo.localhost", "LOCALHOST"):
        assert nobody.get("/api/version", headers={"Host": host}).status_code != 421, host
        assert nobody.get("/metrics", headers={"Host": host}).status_code != 421, host
    for host in ("10.0.0.7:8000", "[2001:db8::1]"):
        assert nobody.get("/api/health", headers={"Host": host}).status_code == 200


def test_a_public_service_has_its_name_and_those_that_are_allowed(settings, cheap_passwords):
    changes = {"base_url": "https://clinic.example.org", "allowed_hosts": "edge-1.internal, edge-2.internal"}
    with open_client(settings, cheap_passwords, **changes) as client:
        for host, status in (
            ("clinic.example.org", 200),
            ("Clinic.example.org.:443", 200),
            ("edge-2.internal:8000", 200),
            ("other.example.org", 421),
            ("127.0.0.1:8000", 421),
            ("localhost", 421),
        ):
            answer = client.get("/api/me", headers={"Host": host})
            assert answer.status_code == (401 if status == 200 else 421), host
        assert client.get("/api/health", headers={"Host": "127.0.0.1:8000"}).status_code == 200, (
            "as Docker asks"
        )


def test_a_nul_in_an_address_is_not_found(nobody, therapist):
    for path in ("/%00", "/api/patients/%00", "/assets/%00.js", "/viewer/%00/"):
        answer = therapist.get(path)
        assert (answer.status_code, answer.json()["code"]) == (404, "not_found"), path
        assert "default-src 'self'" in answer.headers["content-security-policy"]
    assert therapist.get("/api/patients?search=%00").status_code == 422
