"""Patients, grants, consents, device tokens and prescriptions over HTTP."""

from datetime import timedelta

import pytest
from sqlalchemy import select

from app.accounts.models import AuditEvent
from app.database.base import utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.patients.models import Mounting


def test_a_therapist_creates_finds_and_changes_a_patient(therapist):
    new = {"given_name": "Dora", "family_name": "Nilsson", "body_dimensions": {"stature_m": 1.63}}
    created = therapist.post("/api/patients", json=new)
    assert created.status_code == 201
    patient = created.json()
    assert patient["may_treat"] is True
    assert patient["has_mounting"] is False
    assert therapist.get(f"/api/patients/{patient['id']}").json() == patient
    assert patient["id"] in [row["id"] for row in therapist.get("/api/patients").json()]
    changed = therapist.patch(
        f"/api/patients/{patient['id']}", json={"notes": "likes tea", "birth_date": "1960-05-04"}
    ).json()
    assert (changed["notes"], changed["birth_date"]) == ("likes tea", "1960-05-04")
    assert changed["given_name"] == "Dora"
    cleared = therapist.patch(f"/api/patients/{patient['id']}", json={"birth_date": None}).json()
    assert cleared["birth_date"] is None
    refused = therapist.patch(f"/api/patients/{patient['id']}", json={"given_name": None})
    assert refused.status_code == 422
    assert refused.json()["details"]["fields"][0]["field"] == "body.given_name"


def test_lists_hold_only_what_is_in_reach(sign_in, world):
    def seen(name):
        return {row["id"] for row in sign_in(name).get("/api/patients").json()}

    assert seen("therapist") == {world.patient_id, world.other_patient_id}
    assert seen("reader") == {world.patient_id}
    assert seen("patient") == {world.patient_id}
    assert seen("administrator") == {world.patient_id, world.other_patient_id}
    assert seen("foreign_therapist") == {world.foreign_patient_id}
    for outsider in ("colleague", "former", "expired", "integrator"):
        assert seen(outsider) == set()


def test_reading_is_not_treating(sign_in, world):
    reader = sign_in("reader")
    path = f"/api/patients/{world.patient_id}"
    assert reader.get(path).json()["may_treat"] is False
    answer = reader.patch(path, json={"notes": "x"})
    assert (answer.status_code, answer.json()["code"]) == (403, "not_allowed")
    assert reader.post(f"{path}/prescriptions", json={"exercise_id": world.exercise_id}).status_code == 403
    assert sign_in("colleague").patch(path, json={"notes": "x"}).status_code == 404


def test_grants_open_expire_and_close(therapist, sign_in, world):
    path = f"/api/patients/{world.patient_id}"
    colleague = sign_in("colleague")
    assert colleague.get(path).status_code == 404
    grant = {"account_id": world.accounts["colleague"], "level": "read"}
    given = therapist.post(f"{path}/grants", json=grant)
    assert given.status_code == 201
    assert colleague.get(path).status_code == 200
    assert "Colleague" in [row["display_name"] for row in therapist.get(f"{path}/grants").json()]
    raised = therapist.post(f"{path}/grants", json=grant | {"level": "treat"}).json()
    rows = therapist.get(f"{path}/grants").json()
    assert [row["level"] for row in rows if row["account_id"] == grant["account_id"]] == ["treat"]
    assert therapist.delete(f"/api/grants/{given.json()['id']}").status_code == 404, "replaced already"
    assert therapist.delete(f"/api/grants/{raised['id']}").status_code == 204
    assert colleague.get(path).status_code == 404


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"account_id": "foreign_therapist"}, "account_id"),
        ({"account_id": "other_patient"}, "account_id"),
        ({"expires_at": (utc_now() - timedelta(days=1)).isoformat()}, "expires_at"),
        ({"expires_at": "2099-01-01T00:00:00"}, "expires_at"),
    ],
)
def test_grants_that_make_no_sense_are_refused(therapist, world, change, field):
    body = {"account_id": "colleague"} | change
    body["account_id"] = world.accounts[body["account_id"]]
    answer = therapist.post(f"/api/patients/{world.patient_id}/grants", json=body)
    assert answer.status_code == 422
    assert answer.json()["details"]["field"] == field


def test_the_administrator_manages_but_does_not_treat(sign_in, world):
    administrator = sign_in("administrator")
    path = f"/api/patients/{world.patient_id}"
    assert administrator.get(path).json()["may_treat"] is False
    grant = {"account_id": world.accounts["colleague"]}
    assert administrator.post(f"{path}/grants", json=grant).status_code == 201
    answer = administrator.post(f"{path}/prescriptions", json={"exercise_id": world.exercise_id})
    assert answer.status_code == 403


def test_only_administrators_create_accounts(sign_in, world, new_client):
    body = {
        "email": " New.Person@Example.org ",
        "display_name": "New",
        "role": "patient",
        "password": "long enough password",
        "patient_id": world.other_patient_id,
    }
    assert sign_in("therapist").post("/api/accounts", json=body).status_code == 403
    administrator = sign_in("administrator")
    created = administrator.post("/api/accounts", json=body)
    assert created.status_code == 201
    assert created.json()["email"] == "new.person@example.org"
    assert administrator.post("/api/accounts", json=body).status_code == 409
    foreign = body | {"email": "b@example.org", "patient_id": world.foreign_patient_id}
    assert administrator.post("/api/accounts", json=foreign).status_code == 404
    without = body | {"email": "c@example.org", "patient_id": None}
    assert administrator.post("/api/accounts", json=without).status_code == 422
    client = new_client()
    signed = client.post("/api/sign-in", json={"email": body["email"], "password": body["password"]})
    assert signed.json()["patient_id"] == world.other_patient_id


def test_accounts_are_listed_to_staff_only(sign_in):
    administrator = {row["display_name"] for row in sign_in("administrator").get("/api/accounts").json()}
    therapist = {row["display_name"] for row in sign_in("therapist").get("/api/accounts").json()}
    assert "Patient" in administrator
    assert "Patient" not in therapist
    assert "Colleague" in therapist
    assert "Foreign Therapist" not in administrator | therapist
    assert sign_in("patient").get("/api/accounts").status_code == 403


def test_device_tokens_are_shown_once_and_revoked(therapist, world, new_client, sign_in):
    path = f"/api/patients/{world.patient_id}/device-tokens"
    made = therapist.post(path, json={"label": "living room"}).json()
    assert made["token"].count(".") == 2
    listed = therapist.get(path).json()
    assert [(row["label"], row["token"]) for row in listed] == [("living room", None)]
    assert sign_in("patient").get(path).json() == listed, "the patient may see own devices"
    assert sign_in("reader").get(path).status_code == 403
    device = new_client()
    device.headers["Authorization"] = f"Bearer {made['token']}"
    assert device.get(f"/api/patients/{world.patient_id}").status_code == 403, (
        "devices feed, they do not read"
    )
    assert sign_in("colleague").delete(f"/api/device-tokens/{made['id']}").status_code == 404
    assert therapist.delete(f"/api/device-tokens/{made['id']}").status_code == 204
    assert device.get(f"/api/patients/{world.patient_id}").status_code == 401


def test_forged_and_foreign_device_tokens_are_refused(device_token, new_client, world, settings):
    import jwt

    good = device_token(world.patient_id)
    claims = jwt.decode(good, options={"verify_signature": False})
    key = settings.key_for("device-token")
    now = int(utc_now().timestamp())
    forged = {
        "other key": jwt.encode(claims, b"x" * 32, algorithm="HS256"),
        "raw secret": jwt.encode(claims, settings.signing_secret, algorithm="HS256"),
        "no signature": jwt.encode(claims, None, algorithm="none"),
        "other audience": jwt.encode(claims | {"aud": "elsewhere"}, key, algorithm="HS256"),
        "expired": jwt.encode(claims | {"exp": now - 10}, key, algorithm="HS256"),
        "other patient": jwt.encode(claims | {"patient": world.other_patient_id}, key, algorithm="HS256"),
        "unknown": jwt.encode(claims | {"sub": "0" * 32}, key, algorithm="HS256"),
        "no end": jwt.encode({k: v for k, v in claims.items() if k != "exp"}, key, algorithm="HS256"),
        "rubbish": "not.a.token",
    }
    for name, token in forged.items():
        client = new_client()
        client.headers["Authorization"] = f"Bearer {token}"
        assert client.get("/api/exercises").status_code == 401, name
    client = new_client()
    client.headers["Authorization"] = "Basic dXNlcjpwYXNz"
    assert client.get("/api/exercises").status_code == 401


def test_consents_are_the_patients(patient, therapist, sign_in, world):
    path = f"/api/patients/{world.patient_id}/consents"
    answers = patient.put(path, json={"purpose": "research", "granted": False}).json()
    assert {row["purpose"]: row["granted"] for row in answers} == {
        "treatment": True,
        "home_streaming": True,
        "research": False,
    }
    assert therapist.get(path).json() == answers
    assert sign_in("reader").put(path, json={"purpose": "research", "granted": True}).status_code == 403
    assert patient.put(path, json={"purpose": "marketing", "granted": True}).status_code == 422


def test_withdrawn_consent_stops_treatment_but_not_reading(patient, therapist, world):
    base = f"/api/patients/{world.patient_id}"
    patient.put(f"{base}/consents", json={"purpose": "treatment", "granted": False})
    answer = therapist.post(f"{base}/prescriptions", json={"exercise_id": world.exercise_id})
    assert answer.status_code == 403
    assert answer.json()["details"]["purpose"] == "treatment"
    assert therapist.get(base).status_code == 200


def test_nobody_asked_is_not_a_yes(therapist, world):
    """A patient without an answer can be written down and read, but neither recorded nor treated."""
    names = {"given_name": "Nora", "family_name": "Nobody"}
    unasked = therapist.post("/api/patients", json=names).json()["id"]
    wanted = {"patient_id": unasked, "placements": ["sternum", "upper_arm_right", "forearm_right"]}
    refused = therapist.post("/api/sessions", json=wanted)
    assert (refused.status_code, refused.json()["details"]["purpose"]) == (403, "treatment")
    assert "under Consent on the patient's page" in refused.json()["message"]
    prescription = {"exercise_id": world.exercise_id}
    assert therapist.post(f"/api/patients/{unasked}/prescriptions", json=prescription).status_code == 403
    assert therapist.get(f"/api/patients/{unasked}").status_code == 200
    assert therapist.get(f"/api/patients/{unasked}/consents").json() == []
    therapist.put(f"/api/patients/{unasked}/consents", json={"purpose": "treatment", "granted": True})
    assert therapist.post("/api/sessions", json=wanted).status_code == 201
    asked = therapist.post("/api/patients", json=names | {"agrees_to_treatment": True}).json()["id"]
    assert therapist.post("/api/sessions", json=wanted | {"patient_id": asked}).status_code == 201
    trail = therapist.get(f"/api/patients/{asked}/audit").json()
    assert {"purpose": "treatment", "granted": True} in [event["details"] for event in trail]


def test_a_prescription_is_made_listed_and_ended(therapist, patient, world):
    path = f"/api/patients/{world.patient_id}/prescriptions"
    made = therapist.post(path, json={"exercise_id": world.exercise_id, "times_per_week": 3})
    assert made.status_code == 201
    assert made.json()["exercise_name"] == "Reach forward"
    assert made.json()["done_this_week"] == 0
    assert patient.get(path).json() == [made.json()]
    assert patient.delete(f"/api/prescriptions/{made.json()['id']}").status_code == 403
    assert therapist.delete(f"/api/prescriptions/{made.json()['id']}").status_code == 204
    assert patient.get(path).json() == []


def test_prescriptions_refuse_what_does_not_fit(therapist, world):
    path = f"/api/patients/{world.patient_id}/prescriptions"
    for body, field in [
        ({"exercise_id": world.foreign_exercise_id}, "exercise_id"),
        ({"exercise_id": world.exercise_id, "template_id": "0" * 32}, "template_id"),
        ({"exercise_id": world.exercise_id, "ends_at": "2001-01-01T00:00:00Z"}, "ends_at"),
        ({"exercise_id": world.exercise_id, "starts_at": "2031-01-01T00:00:00"}, "starts_at"),
    ]:
        answer = therapist.post(path, json=body)
        assert (answer.status_code, answer.json()["details"]["field"]) == (422, field)


def test_exercises_belong_to_the_clinic(therapist, patient, foreign_therapist, world):
    body = {
        "name": "Drink",
        "movement": "drinking",
        "side": "left",
        "primary_angle": "humerus_forearm_left_zxy_flexion",
    }
    made = therapist.post("/api/exercises", json=body)
    assert made.status_code == 201
    assert patient.get(f"/api/exercises/{made.json()['id']}").json() == made.json()
    assert foreign_therapist.get(f"/api/exercises/{made.json()['id']}").status_code == 404
    assert {row["name"] for row in patient.get("/api/exercises").json()} == {"Drink", "Reach forward"}
    assert patient.post("/api/exercises", json=body).status_code == 403
    wrong = therapist.post("/api/exercises", json=body | {"side": "right"})
    assert wrong.json()["details"]["field"] == "primary_angle"
    knee = {"name": "Straighten", "movement": "other", "primary_angle": "thigh_shank_left_zxy_flexion"}
    assert therapist.post("/api/exercises", json=body | knee).status_code == 201


def test_a_therapist_says_whether_an_exercise_is_done_sitting(
    therapist, patient, foreign_therapist, world, engine
):
    path = f"/api/exercises/{world.exercise_id}"
    before = therapist.get(path).json()
    assert before["posture"] == "standing"
    changed = therapist.patch(path, json={"posture": "seated"})
    assert changed.json() == before | {"posture": "seated"} == patient.get(path).json()
    for refused in ({"posture": "lying"}, {"posture": None}, {"name": ""}, {"side": "left"}):
        assert therapist.patch(path, json=refused).status_code == 422, refused
    assert patient.patch(path, json={"posture": "standing"}).status_code == 403
    assert foreign_therapist.patch(path, json={"posture": "standing"}).status_code == 404
    assert therapist.get(path).json() == changed.json()
    with read_only(engine) as session:
        assert session.scalars(
            select(AuditEvent.resource_id).where(AuditEvent.action == "exercise.change")
        ).all() == [world.exercise_id]


def test_the_patient_reads_who_looked(therapist, patient, world):
    therapist.get(f"/api/patients/{world.patient_id}")
    therapist.get("/api/patients")
    therapist.get("/api/patients")
    events = patient.get(f"/api/patients/{world.patient_id}/audit").json()
    seen = [(event["who"], event["role"], event["action"]) for event in events]
    assert ("Therapist", "therapist", "patient.read") in seen
    assert seen.count(("Therapist", "therapist", "patient.list")) == 1, "noted once an hour"
    assert patient.get(f"/api/patients/{world.other_patient_id}/audit").status_code == 404


def test_a_patient_says_how_the_sensors_sat_last(engine, world, therapist) -> None:
    path = f"/api/patients/{world.patient_id}"
    assert therapist.get(path).json()["mounting"] is None
    with unit_of_work(engine) as session:
        session.add(
            Mounting(
                patient_id=world.patient_id,
                calibration={
                    "q_sensor_segment": {"sternum": [1, 0, 0, 0]},
                    "method": "functional",
                    "score": 0.9,
                },
                session_id="x",
            )
        )
    found = therapist.get(path).json()["mounting"]
    assert found["placements"] == ["sternum"]
    assert (found["method"], found["score"]) == ("functional", 0.9)


def test_an_archived_patient_is_found_and_offers_only_the_way_back(therapist, sign_in, world):
    path = f"/api/patients/{world.patient_id}"
    assert therapist.patch(path, json={"is_archived": True}).status_code == 200

    def found(archived):
        return [row["id"] for row in therapist.get("/api/patients", params={"archived": archived}).json()]

    assert found(True) == [world.patient_id]
    assert found(False) == [world.other_patient_id]
    seen = therapist.get(path).json()
    assert (seen["may_treat"], seen["may_manage"]) == (False, True)
    assert sign_in("reader").get(path).json()["may_manage"] is False
    assert therapist.patch(path, json={"is_archived": False}).json()["may_treat"] is True
