"""The kind of session that follows a walk; see `app.recordings.analysis.kinds`."""

from dataclasses import replace
from typing import Final, cast

import numpy as np
from sqlalchemy.orm import Session

from app.kinds.walk.analysis import follow_feet
from app.kinds.walk.compared import walk_source
from app.kinds.walk.shoes import store_shoes
from app.readers import as_feet
from app.recordings.analysis.kinds import SessionKind, Wanted
from app.recordings.analysis.offline import Analysis, StoredSession
from app.recordings.analysis.still import still
from app.recordings.compared import Source
from app.recordings.models import MotionSession, Result
from estimators import pipelines
from estimators.compiling import Kernel
from estimators.conventions import SHOE_PLACEMENTS
from estimators.orientation import DEFAULT
from estimators.pipelines import FEET, GaitPipeline, SessionSetup
from estimators.pipelines.walk.pooled_kernel import step_walks
from estimators.recording import Recording
from estimators.sentences import say


class WalkKind(SessionKind):
    """Walks."""

    pipeline = GaitPipeline
    view = "feet"
    calibration_refused = say("live.walk_uncalibrated")
    estimator_refused = say("walk.one_estimator")
    guidance_refused = say("guided.after_walk")

    def analyse(self, wanted: Wanted) -> Analysis:
        """Follow the feet over the whole walk, with forces and centre of mass where they were measured."""
        context, setup = wanted.context, wanted.setup
        context.progress(wanted.progress_from, say("progress.reading_walk"))
        return follow_feet(context, setup, StoredSession(context, setup), wanted.progress_from)

    def compared(self, session: Session, found: MotionSession, result: Result) -> Source:
        """Take each stride as a repetition."""
        return walk_source(session, found, result)

    def store_auxiliary(self, session: Session, session_id: str, recording: Recording) -> Recording:
        """Store the load cells of instrumented shoes; the feet remain."""
        if not pipelines.has_shoes(recording):
            return recording
        store_shoes(session, session_id, recording)
        return as_feet(recording)

    def warm_up(self, orientation: str = DEFAULT) -> None:
        """Stand, without and with load cells; then make ready what takes many walks together."""
        for feet in (FEET, SHOE_PLACEMENTS):
            walk = pipelines.create(SessionSetup(self.pipeline.name, feet, 100.0))
            forces = np.zeros((len(feet), 5, 3))
            for chunk in still(len(feet), 400):
                walk.step(replace(chunk, force_n=forces, moment_nm=forces))
        cast(Kernel, step_walks).prepare()


KIND: Final = WalkKind()
