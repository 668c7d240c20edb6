"""The kind of session with a magnetic source; see `app.recordings.analysis.kinds`."""

import logging
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final, cast

import numpy as np
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import InvalidInput
from app.kinds.magnetic.known_sources import parameters_of
from app.kinds.magnetic.safety import require_confirmed
from app.kinds.magnetic.smoothing import SmoothedModules
from app.kinds.walk.analysis import follow_feet
from app.network.declaration import Declaration
from app.recordings.analysis.heading_line import HeadingLine
from app.recordings.analysis.jobs import JobContext
from app.recordings.analysis.kinds import SessionKind, Wanted
from app.recordings.analysis.offline import Analysis, StoredSession, estimated
from app.recordings.analysis.still import still
from app.recordings.models import MotionSession
from app.recordings.schemas import SessionIn
from estimators import pipelines
from estimators.compiling import Kernel
from estimators.errors import EstimationError
from estimators.magnetic import coil_state
from estimators.orientation import DEFAULT
from estimators.pipelines import FEET, GaitPipeline, RelativePosePipeline, SessionSetup, relative_feet
from estimators.pipelines.relative.pooled_kernel import step_relative
from estimators.recording import ImuChunk
from estimators.sentences import say

logger = logging.getLogger(__name__)
_WALK_FROM: Final = 0.8


class MagneticKind(SessionKind):
    """A worn magnetic source and the sensors around it."""

    pipeline = RelativePosePipeline
    view = "modules"
    calibration_refused = say("live.magnetic_uncalibrated")
    estimator_refused = say("magnetic.one_estimator")

    def analyse(self, wanted: Wanted) -> Analysis:
        """Smooth the whole session."""
        context, setup = wanted.context, wanted.setup
        context.progress(0.0, say("progress.smoothing"))
        pieces = SmoothedModules(StoredSession(context, setup), setup)
        line = HeadingLine(pipelines.create(setup), ())
        return estimated(context, line, pieces, smoothed=True, progress_from=wanted.progress_from)

    def closed(self, context: JobContext, setup: SessionSetup) -> None:
        """Analyse a source on one shoe as a walk as well; the message of that result says what failed."""
        if set(setup.placements) != set(FEET):
            return
        pieces = list(StoredSession(context, setup))
        if not pieces:
            return
        try:
            relative = relative_feet(ImuChunk.join(pieces), setup)
            walking = replace(setup, pipeline=GaitPipeline.name, orientation_parameters={})
            follow_feet(context, walking, pieces, _WALK_FROM, relative)
        except (EstimationError, InvalidInput):
            # Not a walk: nobody asked for one.
            logger.info("session %s holds no walk", context.session_id)

    def parameters(self, session: Session, subject: Subject, wanted: SessionIn) -> dict[str, Any]:
        """Return the estimator's parameters, with the measured coils of the source that is worn."""
        if wanted.magnetic_source_id is None:
            return wanted.orientation_parameters
        return {
            **wanted.orientation_parameters,
            **parameters_of(session, subject, wanted.magnetic_source_id),
        }

    def declared(self, parameters: Mapping[str, Any], network: Declaration) -> dict[str, Any]:
        """Return the parameters with where the magnetometers clip; what somebody set by hand stays."""
        clip_t = network.full_scales.get("magnetometer")
        return dict(parameters) if clip_t is None else {"full_scale_t": clip_t, **parameters}

    def require_safe(self, session: Session, found: MotionSession, hours: float) -> None:
        """Refuse while nobody has confirmed that no implant is near."""
        require_confirmed(session, found, hours)

    def warm_up(self, orientation: str = DEFAULT) -> None:
        """Go from the standstill through the first burst; make ready what takes many sessions together."""
        source = pipelines.create(SessionSetup(self.pipeline.name, ("pelvis", "sternum"), 100.0))
        coil = 0
        for chunk in still(2, 300):
            state = np.zeros((2, chunk.tick_count))
            state[0] = coil_state(coil, 1.3)
            frames = source.step(replace(chunk, coil_state=state))
            # What was asked for is fired in the next packet.
            coil = int(frames.scalar[:, frames.layout.scalars.index("source_ask_coil")].max())
        cast(Kernel, step_relative).prepare()


KIND: Final = MagneticKind()
