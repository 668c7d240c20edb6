"""What was erased, revoked or withdrawn stays so when an older database comes back, on both databases."""

import json
import stat

import pytest
from sqlalchemy import select

from app.accounts.models import Account, AuditEvent, Consent, DeviceToken
from app.assessment.records import ended_again
from app.commands import store
from app.database import ended
from app.database.engine import create
from app.database.unit_of_work import read_only, unit_of_work
from app.main import _keep_ended
from app.patients.models import Grant, Patient
from app.recordings.models import MotionSession
from app.scaled import backup as whole

SESSION = "a" * 32


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.postgres)])
def settings(request):
    return request.getfixturevalue(f"settings_on_{request.param}")


@pytest.fixture
def engine(settings):
    engine = create(settings)
    yield engine
    engine.dispose()


@pytest.fixture
def fresh(settings, tmp_path, request, monkeypatch):
    """Settings of an empty database of the same kind; `data_dir` is given by the test."""

    def make(data_dir):
        if settings.database_url.startswith("sqlite"):
            url = f"sqlite:///{tmp_path / f'restored-{data_dir.name}.db'}"
        else:
            url = request.getfixturevalue("postgresql_database")()
        monkeypatch.setenv("TELEMOTION_DATABASE_URL", url)
        monkeypatch.setenv("TELEMOTION_DATA_DIR", str(data_dir))
        monkeypatch.setenv("TELEMOTION_SECRET_KEY", settings.secret_key.get_secret_value())
        return settings.model_copy(update={"database_url": url, "data_dir": data_dir})

    return make


@pytest.fixture
def ended_since(engine, settings, world, therapist, sign_in, device_client, tmp_path):
    """Make a backup, then end one thing of each kind; returns the backup and what was ended."""
    administrator = sign_in("administrator")
    patient, other = (f"/api/patients/{one}" for one in (world.patient_id, world.other_patient_id))
    token = therapist.post(f"{other}/device-tokens", json={"label": "phone"}).json()["id"]
    grants = {one["account_id"]: one["id"] for one in therapist.get(f"{other}/grants").json()}
    for name, granted in (("treatment", True), ("research", True)):
        therapist.put(f"{other}/consents", json={"purpose": name, "granted": granted})
    with unit_of_work(engine) as session:
        session.add(
            MotionSession(
                id=SESSION,
                clinic_id=world.clinic_id,
                patient_id=world.other_patient_id,
                setup={},
                created_by="x",
                state="analysed",
            )
        )
    archive = tmp_path / "before.zip"
    whole.backup(engine, settings, archive)
    administrator.patch(patient, json={"is_archived": True})
    assert administrator.request("DELETE", patient, json={"confirmation": "ERASE"}).status_code == 204
    assert therapist.delete(f"/api/device-tokens/{token}").status_code == 204
    assert therapist.delete(f"/api/sessions/{SESSION}").status_code == 204
    therapist.put(f"{other}/consents", json={"purpose": "research", "granted": False})
    reader = world.accounts["integrator"]
    given = administrator.post(f"{other}/grants", json={"account_id": reader, "level": "treat"})
    assert given.status_code == 201
    assert administrator.patch(
        f"/api/accounts/{world.accounts['former']}", json={"is_active": False}
    ).is_success
    own = grants[world.accounts["therapist"]]
    assert administrator.delete(f"/api/grants/{own}").status_code == 204
    return archive, {"token": token, "grant": own}


def held(engine, world, what):
    with read_only(engine) as session:
        consent = select(Consent.granted).where(
            Consent.patient_id == world.other_patient_id, Consent.purpose == "research"
        )
        return {
            "patient": session.get(Patient, world.patient_id) is not None,
            "session": session.get(MotionSession, SESSION) is not None,
            "token": session.get_one(DeviceToken, what["token"]).revoked_at is None,
            "grant": session.get_one(Grant, what["grant"]).revoked_at is None,
            "consent": bool(session.scalar(consent)),
            "account": session.get_one(Account, world.accounts["former"]).is_active,
        }


NOTHING = dict.fromkeys(("patient", "session", "token", "grant", "consent", "account"), False)


def test_a_restore_in_the_same_data_folder_ends_again_what_was_ended_since(
    settings, world, ended_since, fresh, capsys
):
    archive, what = ended_since
    target = fresh(settings.data_dir)
    store.restore(archive)
    said = capsys.readouterr().out
    assert "erased again: 1 patients, 1 sessions" in said
    assert "revoked: 1 tokens, 1 grants, 1 consents, 1 accounts" in said
    assert "register" in said
    restored = create(target)
    assert held(restored, world, what) == NOTHING
    with read_only(restored) as session:
        again = session.scalars(select(AuditEvent).where(AuditEvent.action == "patient.erase")).one()
        assert (again.patient_id, again.subject_kind) == (world.patient_id, "system")
        assert session.scalar(select(Consent.granted).where(Consent.purpose == "treatment"))
    assert not ended_again.apply(restored, target, ended.read(ended.path_of(target))), "and only once"
    restored.dispose()


def test_a_restore_without_a_register_says_so_and_takes_one_that_is_named(
    settings, world, ended_since, fresh, tmp_path, engine, capsys
):
    archive, what = ended_since
    target = fresh(tmp_path / "elsewhere")
    store.restore(archive)
    assert "Whoever was erased" in capsys.readouterr().out
    restored = create(target)
    assert held(restored, world, what) == dict.fromkeys(NOTHING, True)
    restored.dispose()
    newer = tmp_path / "newer.zip"
    whole.backup(engine, settings, newer)
    for number, register in enumerate((ended.path_of(settings), newer)):
        target = fresh(tmp_path / f"named-{number}")
        store.restore(archive, [register])
        assert "erased again: 1 patients" in capsys.readouterr().out
        restored = create(target)
        assert held(restored, world, what) == NOTHING
        restored.dispose()


def test_a_database_that_was_put_back_by_hand_is_brought_up_at_the_start(
    settings, world, ended_since, fresh, tmp_path, caplog
):
    archive, what = ended_since
    target = fresh(tmp_path / "by-hand")
    store.restore(archive)
    by_hand = target.model_copy(update={"data_dir": settings.data_dir})
    restored = create(by_hand)
    _keep_ended(restored, by_hand)
    assert held(restored, world, what) == NOTHING
    assert "erased again" in caplog.text
    restored.dispose()


def test_the_register_holds_identifiers_only_and_survives_a_crash(settings, engine, world, ended_since):
    path = ended.path_of(settings)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    entries = ended.read(path)
    assert {entry.action for entry in entries} == {
        "patient.erase",
        "session.delete",
        "device_token.revoke",
        "grant.revoke",
        "consent.change",
        "account.switch_off",
    }
    words = json.dumps([entry.details for entry in entries])
    assert {"Ada", "Bert", "phone"} & set(words.split('"')) == set()
    # Cut off in a line, then deleted: the audit trail knows all of it.
    whole_file = path.read_bytes()
    path.write_bytes(whole_file[:-30])
    _keep_ended(engine, settings)
    assert ended.read(path) == entries
    path.unlink()
    _keep_ended(engine, settings)
    assert ended.read(path) == entries
