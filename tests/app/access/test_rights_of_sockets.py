"""Open sockets are asked for together: each answer is that of the written table, and that of the question by itself."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import timedelta
from itertools import product
from typing import Any

import pytest
from sqlalchemy import Engine, event, update
from sqlalchemy.exc import OperationalError

from app.accounts.consents import set_consent
from app.accounts.credentials.sign_in import create_sign_in
from app.accounts.device_tokens import create_device_token, device_subject
from app.accounts.models import Account, DeviceToken, SignIn
from app.accounts.subject import Subject
from app.database.base import new_id, utc_now
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import TelemotionError
from app.live.rights import authorization_checks as module
from app.live.rights.authorization_checks import AuthorizationCheck, answers, answers_apart, still_allowed
from app.patients.access import Level
from app.patients.models import Grant, Patient
from app.recordings.models import MotionSession
from app.settings import Settings
from tests.app.conftest import World

LEVELS: tuple[Level, ...] = ("status", "read", "record", "treat", "manage", "erase")
NONE = "patient.not_found"
STATEMENTS = 7
"""Browser sessions, devices, accounts, sessions, patients, grants, consents."""

HELD: dict[str, set[Level]] = {
    "administrator": {"status", "read", "manage", "erase"},
    "therapist": {"status", "read", "record", "treat", "manage"},
    "reader": {"status", "read"},
    "colleague": set(),
    "former": set(),
    "expired": set(),
    "integrator": set(),
    "patient": {"status", "read", "record"},
    "other_patient": set(),
    "foreign_therapist": set(),
    "foreign_administrator": set(),
    "device": {"status", "record"},
    "other_device": set(),
    "system": set(LEVELS),
    "foreign_system": set(),
}
"""Who has which level for the session of Ada: the table in the text of `app.patients.access`."""

AT_HOME = {"patient", "device"}


@pytest.fixture
def sessions(world: World, engine: Engine) -> dict[str, str]:
    """A session of Ada, of Bert and of Carl, who is of another clinic."""
    found = {}
    with unit_of_work(engine) as session:
        for name, patient_id, clinic_id in (
            ("ada", world.patient_id, world.clinic_id),
            ("bert", world.other_patient_id, world.clinic_id),
            ("carl", world.foreign_patient_id, world.foreign_clinic_id),
        ):
            found[name] = new_id()
            session.add(
                MotionSession(
                    id=found[name], clinic_id=clinic_id, patient_id=patient_id, setup={}, created_by="test"
                )
            )
    return found


@pytest.fixture
def subjects(world: World, engine: Engine, settings: Settings) -> dict[str, Subject]:
    found = dict(world.subjects)
    with unit_of_work(engine) as session:
        for name, patient_id in (("device", world.patient_id), ("other_device", world.other_patient_id)):
            giver = world.subjects["therapist"]
            row, _ = create_device_token(session, settings, giver, patient_id, name, 1)
            found[name] = device_subject(row)
    found["system"] = Subject.system(world.clinic_id)
    found["foreign_system"] = Subject.system(world.foreign_clinic_id)
    return found


@contextmanager
def counted(engine: Engine) -> Iterator[list[str]]:
    statements: list[str] = []

    def note(connection: Any, cursor: Any, statement: str, *_: Any) -> None:
        if statement.startswith("SELECT"):
            statements.append(statement)

    event.listen(engine, "before_cursor_execute", note)
    yield statements
    event.remove(engine, "before_cursor_execute", note)


def word(refusal: Exception | None) -> str | None:
    if refusal is None:
        return None
    assert isinstance(refusal, TelemotionError)
    assert refusal.sentence is not None
    return refusal.sentence.code


def alone(engine: Engine, question: AuthorizationCheck) -> TelemotionError | None:
    try:
        still_allowed(engine, question)
    except TelemotionError as error:
        return error
    return None


def all_of(engine: Engine, asked: list[AuthorizationCheck]) -> list[TelemotionError | None]:
    """Ask together, and hold it against the questions by themselves: kind, sentence and details of each error."""
    together = answers(engine, asked)
    apart = [alone(engine, one) for one in asked]
    assert [(type(one), str(one), getattr(one, "details", None)) for one in together] == [
        (type(one), str(one), getattr(one, "details", None)) for one in apart
    ]
    return together


def expected(name: str, level: Level, state: str) -> str | None:
    """The answer for the session of Ada, as the text of `app.patients.access` has it."""
    if not HELD[name]:
        return NONE
    if level not in HELD[name]:
        return "patient.level"
    if level not in {"record", "treat"} or name == "system":
        return None
    if state in {"archived", "patient.no_consent", "patient.consent_withdrawn"}:
        return "patient.archived" if state == "archived" else state
    if state == "patient.no_home_consent" and level == "record" and name in AT_HOME:
        return state
    return None


def bring_into(engine: Engine, world: World, state: str) -> None:
    """Bring Ada's consents or her record into a state."""
    by = world.accounts["therapist"]
    with unit_of_work(engine) as session:
        if state == "archived":
            session.execute(
                update(Patient).where(Patient.id == world.patient_id).values(archived_at=utc_now())
            )
        elif state == "patient.consent_withdrawn":
            set_consent(session, world.patient_id, "treatment", False, by)
        elif state == "patient.no_home_consent":
            set_consent(session, world.patient_id, "home_streaming", False, by)
        elif state == "patient.no_consent":
            session.connection().exec_driver_sql("DELETE FROM consent WHERE purpose = 'treatment'")


def check_table(engine: Engine, world: World, sessions: Any, subjects: Any, state: str) -> None:
    bring_into(engine, world, state)
    cases = list(product(HELD, LEVELS))
    asked = [AuthorizationCheck(subjects[name], sessions["ada"], level) for name, level in cases]
    with counted(engine) as statements:
        answers(engine, asked)
    assert len(statements) <= STATEMENTS - 1, "nobody is asked for by a browser session"
    assert [word(one) for one in all_of(engine, asked)] == [
        expected(name, level, state) for name, level in cases
    ]


STATES = [
    "as it was",
    "archived",
    "patient.no_consent",
    "patient.consent_withdrawn",
    "patient.no_home_consent",
]


@pytest.mark.parametrize("state", STATES)
def test_every_subject_and_level_has_the_answer_of_the_table(
    engine: Engine, world: World, sessions: Any, subjects: Any, state: str
) -> None:
    check_table(engine, world, sessions, subjects, state)


def revoke(name: str) -> Callable[[Any, World], None]:
    def do(session: Any, world: World) -> None:
        past = utc_now() - timedelta(seconds=1)
        therapist = world.accounts["therapist"]
        match name:
            case "account off":
                session.execute(update(Account).where(Account.id == therapist).values(is_active=False))
            case "signed out":
                session.connection().exec_driver_sql("DELETE FROM sign_in")
            case "sign-in too old":
                session.execute(update(SignIn).values(expires_at=past))
            case "idle":
                session.execute(update(SignIn).values(last_seen_at=past - timedelta(days=2)))
            case "new password":
                session.execute(update(Account).values(must_change_password=True))
            case "no role":
                session.execute(update(Account).where(Account.id == therapist).values(role="nobody"))
            case "grant revoked":
                session.execute(update(Grant).where(Grant.account_id == therapist).values(revoked_at=past))
            case "grant expired":
                session.execute(update(Grant).where(Grant.account_id == therapist).values(expires_at=past))
            case "device revoked":
                session.execute(update(DeviceToken).values(revoked_at=past))
            case "device expired":
                session.execute(update(DeviceToken).values(expires_at=past))
            case "session erased":
                session.connection().exec_driver_sql("DELETE FROM motion_session")

    return do


@pytest.mark.parametrize(
    ("what", "shown", "taken", "device"),
    [
        ("nothing", None, None, None),
        ("account off", "sign_in.required", "sign_in.required", None),
        ("signed out", "sign_in.required", "sign_in.required", None),
        ("sign-in too old", "sign_in.required", "sign_in.required", None),
        ("idle", "sign_in.required", None, None),
        ("new password", "sign_in.change_password_first", None, None),
        ("no role", "sign_in.no_role", "sign_in.no_role", None),
        ("grant revoked", NONE, NONE, None),
        ("grant expired", NONE, NONE, None),
        ("device revoked", None, None, "live.token_expired"),
        ("device expired", None, None, "live.token_expired"),
        ("session erased", "session.not_found", "session.not_found", "session.not_found"),
    ],
)
def test_whatever_is_taken_away_ends_the_sockets_it_concerns_and_no_others(
    engine: Engine,
    world: World,
    sessions: Any,
    subjects: Any,
    settings: Settings,
    what: str,
    shown: str | None,
    taken: str | None,
    device: str | None,
) -> None:
    """A socket that shows something must be in use; one that takes movement ends with the sign-out all the same."""
    with unit_of_work(engine) as session:
        _, row = create_sign_in(session, settings, world.accounts["therapist"], "tests")
        therapist = replace(subjects["therapist"], sign_in_id=row.id)
    ada = sessions["ada"]
    asked = [
        AuthorizationCheck(therapist, ada, "read", settings),
        AuthorizationCheck(therapist, ada, "record"),
        AuthorizationCheck(subjects["device"], ada, "record"),
        AuthorizationCheck(subjects["foreign_therapist"], sessions["carl"], "read"),
    ]
    assert all_of(engine, asked) == [None] * 4
    with unit_of_work(engine) as session:
        revoke(what)(session, world)
    with counted(engine) as statements:
        answers(engine, asked)
    assert len(statements) <= STATEMENTS
    rest = "session.not_found" if what == "session erased" else None
    assert [word(one) for one in all_of(engine, asked)] == [shown, taken, device, rest]


def test_many_sockets_cost_no_more_statements_than_one_of_each_kind(
    engine: Engine, sessions: Any, subjects: Any
) -> None:
    each = [
        AuthorizationCheck(subjects["therapist"], sessions["bert"], "record"),
        AuthorizationCheck(subjects["device"], sessions["ada"], "record"),
    ]
    with counted(engine) as few:
        answers(engine, each)
    with counted(engine) as many:
        assert answers(engine, each * 250) == [None] * 500
    assert len(few) == len(many) == STATEMENTS - 1
    with counted(engine) as watching:
        answers(engine, [AuthorizationCheck(subjects["patient"], sessions["ada"], "read")] * 100)
    assert len(watching) == 3, "what no answer depends on is not asked for: account, session, patient"
    assert answers(engine, []) == []


def test_a_question_that_fails_harms_no_other_and_a_silent_database_answers_nobody(
    engine: Engine, sessions: Any, subjects: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = AuthorizationCheck(subjects["therapist"], sessions["ada"], "read")
    bad = AuthorizationCheck(subjects["therapist"], "broken", "read")
    lost = AuthorizationCheck(subjects["former"], sessions["ada"], "read")
    real = module.answers

    def failing(engine: Engine, asked: Any) -> Any:
        if bad in asked:
            raise ValueError("broken")
        return real(engine, asked)

    monkeypatch.setattr(module, "answers", failing)
    first, second, third, fourth = answers_apart(engine, [good, bad, lost, good])
    assert first is None
    assert isinstance(second, ValueError)
    assert word(third) == NONE
    assert fourth is None

    def silent(engine: Engine, asked: Any) -> Any:
        raise OperationalError("", {}, Exception())

    monkeypatch.setattr(module, "answers", silent)
    with pytest.raises(OperationalError):
        answers_apart(engine, [good, lost])


def test_rights_are_found_by_an_index(engine: Engine, sessions: Any, subjects: Any) -> None:
    """The pairs of patient and account are looked up, not compared with every grant of the clinic."""
    plans = []

    def note(connection: Any, cursor: Any, statement: str, parameters: Any, *_: Any) -> None:
        if "expires_at" in statement and "account_id" in statement:
            plans.append((statement, parameters))

    event.listen(engine, "before_cursor_execute", note)
    answers(engine, [AuthorizationCheck(subjects["therapist"], sessions["ada"], "read")] * 2)
    event.remove(engine, "before_cursor_execute", note)
    ((statement, parameters),) = plans
    with read_only(engine) as session:
        rows = session.connection().exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", parameters)
        plan = [str(row[3]) for row in rows]
    assert any("SEARCH grant USING INDEX" in line for line in plan), plan


@pytest.mark.postgres
class TestOnPostgresql:
    @pytest.fixture
    def settings(self, settings_on_postgresql: Settings) -> Settings:
        return settings_on_postgresql

    def test_the_table(self, engine: Engine, world: World, sessions: Any, subjects: Any) -> None:
        for state in ("as it was", "patient.no_home_consent", "patient.consent_withdrawn", "archived"):
            check_table(engine, world, sessions, subjects, state)
