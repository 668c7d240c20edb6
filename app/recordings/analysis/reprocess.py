"""The task `reprocess`: estimate a stored session again, and what follows when a session was closed.

Earlier results stay; a new one names the versions and parameters it was made with.
"""

from dataclasses import replace

from sqlalchemy.orm import Session

from app.database.unit_of_work import read_only, unit_of_work
from app.recordings.analysis.heading_line import calibration_in_force
from app.recordings.analysis.jobs import JobContext
from app.recordings.analysis.kinds import Wanted, kind_of
from app.recordings.analysis.offline import Analysis
from app.recordings.analysis.smoothing import remember, smoother_for
from app.recordings.models import Job, MotionSession
from app.recordings.signals.store import stored_ranges
from estimators.pipelines import SessionSetup


def reprocess(context: JobContext) -> str:
    """Task `reprocess`: estimate again; on closing a session also count, name the main result and compare.

    Arguments: `orientation`, `orientation_parameters` (absent: as in the session's setup), `close`. On closing
    the smoother of the session's filter takes its place, where there is one; the live result stays beside.
    """
    closing = bool(context.arguments.get("close"))
    with read_only(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        setup = SessionSetup.from_dict(found.setup)
        pose_s, resets = calibration_in_force(session, found.id)
    if resets and setup.calibration is not None:
        # Each holds from its own moment on; the analysis makes them again.
        setup = replace(setup, calibration=resets[0].undone(setup.calibration))
    kind = kind_of(setup)
    follower = smoother_for(setup.orientation) if kind.pipeline.takes_estimator else None
    wanted = context.arguments.get("orientation") or (closing and follower) or setup.orientation
    parameters = context.arguments.get("orientation_parameters", setup.orientation_parameters)
    is_other = wanted != setup.orientation or parameters != setup.orientation_parameters
    setup = replace(setup, orientation=wanted, orientation_parameters=dict(parameters))
    method = "" if setup.calibration is None else setup.calibration.method
    # A mounting found by movement holds for the smoother too: both face north, and there is no pose to repeat.
    holds = wanted == follower and method != "" and "pose" not in method
    if is_other and pose_s is not None and not holds:
        # Another filter has another heading to begin with: the pose is evaluated with its own orientation.
        setup = replace(setup, calibration=None)
    analysis = kind.analyse(Wanted(context, setup, pose_s, resets=resets))
    if closing:
        kind.closed(context, setup)
    with unit_of_work(context.engine) as session:
        found = session.get_one(MotionSession, context.session_id)
        if closing or found.main_result_id is None:
            found.main_result_id = analysis.result_id
        if closing:
            count_session(session, found, analysis)
            remember(session, found, analysis.learnt)
            enqueue_comparison(session, found)
    return analysis.message


def enqueue_comparison(session: Session, found: MotionSession) -> None:
    """Queue what follows the analysis of a closed session: comparison, where a template is prescribed."""
    session.add(
        Job(session_id=found.id, kind="compare", arguments={"close": True}, created_by=found.created_by)
    )


def count_session(session: Session, found: MotionSession, analysis: Analysis) -> None:
    """Write how long the session was and what is missing of it."""
    stored = stored_ranges(session, found.id)
    found.packets_stored = len(stored)
    found.packets_missing = stored.missing_count
    found.duration_s = analysis.ticks / float(found.setup["rate_hz"])
