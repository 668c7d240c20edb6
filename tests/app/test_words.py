"""Words for people on their way: through the database, and to clients with code and parameters."""

import pytest
from sqlalchemy import text

from app.database.unit_of_work import read_only, unit_of_work
from app.errors import InvalidInput
from app.live.calibration.guides import GUIDES
from app.network.messages import ErrorMessage
from app.recordings.models import SessionEvent
from app.recordings.schemas import CalibrationOut, SessionEventOut
from estimators.sentences import Sentence, say
from tests.app.recordings.conftest import new_session  # noqa: F401 - a fixture

FAILED = say("job.analysis_failed", reason=say("sign_in.too_many", seconds=12))


def stored_and_read(engine, session_id, words):
    with unit_of_work(engine) as session:
        session.add(SessionEvent(session_id=session_id, kind="mark", time_s=0.0, text=words))
    with read_only(engine) as session:
        return session.query(SessionEvent).one().text


def test_a_sentence_comes_back_from_the_database(engine, new_session):  # noqa: F811
    back = stored_and_read(engine, new_session(), FAILED)
    assert isinstance(back, Sentence)
    assert back == FAILED == "Analysis failed. Too many failed sign-ins; try again in 12 s."
    assert back.to_dict() == FAILED.to_dict()


@pytest.mark.parametrize(
    "note", ["Left arm hurts.", "", '{"code": "sign_in.wrong", "params": {}, "text": ""}', "{"]
)
def test_notes_and_rows_of_older_versions_stay_plain_text(engine, new_session, note):  # noqa: F811
    back = stored_and_read(engine, new_session(), note)
    assert not isinstance(back, Sentence)
    assert back.strip() == note


def test_long_plain_text_is_cut(engine, new_session):  # noqa: F811
    assert stored_and_read(engine, new_session(), "a" * 600) == "a" * 500


def test_the_words_of_a_code_that_is_gone_are_still_shown(engine, new_session):  # noqa: F811
    stored_and_read(engine, new_session(), FAILED)
    with engine.begin() as connection:
        connection.execute(
            text("UPDATE session_event SET text = replace(text, 'job.analysis_failed', 'job.gone')")
        )
    with read_only(engine) as session:
        assert session.query(SessionEvent).one().text == str(FAILED)


def test_clients_get_code_and_parameters_beside_the_words():
    event = SessionEventOut(kind="error", time_s=0.0, duration_s=0.0, placement=None, text=FAILED)
    assert event.text == str(FAILED)
    assert event.model_dump()["sentences"] == {"text": FAILED.to_dict()}
    back = SessionEventOut.model_validate_json(event.model_dump_json())
    assert back == event
    found = CalibrationOut(method="n_pose", score=0.5, reasons=[say("sign_in.wrong"), "Of an older version."])
    assert found.model_dump()["sentences"]["reasons"] == [
        say("sign_in.wrong").to_dict(),
        "Of an older version.",
    ]
    assert (
        SessionEventOut(kind="mark", time_s=0.0, duration_s=0.0, placement=None, text="Hurts").sentences == {}
    )


def test_refusals_carry_their_sentence(nobody):
    refused = nobody.get("/api/patients").json()
    assert refused["message"] == "Please sign in."
    assert refused["sentences"] == {
        "message": {"code": "sign_in.required", "params": {}, "text": "Please sign in."}
    }
    message = ErrorMessage.of(InvalidInput(say("account.password_wrong"), field="old_password"), closing=True)
    assert message.sentences["message"].code == "account.password_wrong"


def test_a_field_gives_its_code_back_for_telling_it_elsewhere():
    step = GUIDES["six_position"].steps[-1]
    instruction = step.said("instruction")
    assert isinstance(instruction, Sentence)
    assert (instruction, instruction.code) == (step.instruction, "guide_six_position.turn")
    assert instruction.parameters == {"axis": "z"}
    plain = SessionEventOut(kind="mark", time_s=0.0, duration_s=0.0, placement=None, text="Left arm hurts.")
    assert plain.said("text") == "Left arm hurts."
