"""The status of a session that is not live here, from its row."""

from app.live.blocks import layout_message
from app.live.messages import LayoutMessage, StateMessage
from app.live.repository import StoredSession, calibration_of
from app.recordings.schemas import CalibrationOut
from estimators import pipelines
from estimators.pipelines import SessionSetup
from estimators.sentences import Sentence


def stored_state(stored: StoredSession, sent_away: Sentence | None = None) -> StateMessage:
    """Return the state of a session that is not live here.

    Parameters
    ----------
    sent_away : Sentence, optional
        Why its gateway is to come again later.
    """
    calibration = calibration_of(stored.setup)
    return StateMessage(
        state=stored.state,
        reason=sent_away or stored.state_reason,
        session_time_s=0.0,
        recording_start_s=None,
        calibration=calibration and CalibrationOut.of(calibration),
        calibration_progress=None,
    )


def stored_layout(stored: StoredSession) -> LayoutMessage:
    """Return the columns that the session's frames will have."""
    setup = SessionSetup.from_dict(stored.setup)
    pipeline = pipelines.create(setup)
    return layout_message(stored.id, pipeline.layout, setup.rate_hz, pipeline.delay_ticks)
