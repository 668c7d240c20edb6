"""The kind of session that follows single sensors; see `app.recordings.analysis.kinds`."""

from dataclasses import replace
from typing import Final

from app.recordings.analysis.heading_line import HeadingLine
from app.recordings.analysis.kinds import SessionKind, Wanted
from app.recordings.analysis.offline import Analysis, estimated, smoothed
from app.recordings.analysis.still import still
from estimators import pipelines
from estimators.conventions import PLACEMENTS
from estimators.orientation import DEFAULT
from estimators.pipelines import OrientationPipeline, SessionSetup


class OrientationKind(SessionKind):
    """Single sensors. Nothing is worn: there is no pose, and the filters find what they need."""

    pipeline = OrientationPipeline
    view = "modules"
    live_frames_hz = 25.0

    def analyse(self, wanted: Wanted) -> Analysis:
        """Estimate, smoothed where the setup names a smoother."""
        context, setup = wanted.context, wanted.setup
        pieces = smoothed(context, setup)
        line = HeadingLine(pipelines.create(setup), ())
        found = estimated(context, line, pieces, progress_from=wanted.progress_from)
        return replace(found, learnt=pieces.learnt)

    def warm_up(self, orientation: str = DEFAULT) -> None:
        """Lie still."""
        placements = PLACEMENTS[:2]
        sensors = pipelines.create(
            SessionSetup(self.pipeline.name, placements, 100.0, orientation=orientation)
        )
        for chunk in still(len(placements), 400):
            sensors.step(chunk)


KIND: Final = OrientationKind()
