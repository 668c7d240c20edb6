"""The kind of session that tests balance; see `app.recordings.analysis.kinds`."""

from dataclasses import replace
from types import MappingProxyType
from typing import Final

from app.kinds.balance.trials import CONDITIONS, REST
from app.recordings.analysis.heading_line import HeadingLine
from app.recordings.analysis.kinds import SessionKind, Wanted
from app.recordings.analysis.offline import Analysis, estimated, posed, smoothed
from app.recordings.analysis.still import calibrate_still
from estimators import pipelines
from estimators.orientation import DEFAULT
from estimators.pipelines import TRUNK, BalancePipeline, SessionSetup
from estimators.sentences import say


class BalanceKind(SessionKind):
    """Quiet standing and reaching, each beginning at a mark; see `app.kinds.balance.trials`."""

    pipeline = BalancePipeline
    marks = MappingProxyType({**CONDITIONS, REST: say("balance.rest")})

    def analyse(self, wanted: Wanted) -> Analysis:
        """Find the pose where the setup has no calibration, then estimate."""
        context = wanted.context
        pieces = smoothed(context, wanted.setup)
        setup, pose_s, message = posed(wanted.setup, wanted.pose_s, pieces, search=wanted.search_pose)
        line = HeadingLine(pipelines.create(setup), wanted.resets if setup.calibration is not None else ())
        found = estimated(context, line, pieces, message=message, progress_from=wanted.progress_from)
        return replace(found, pose_s=pose_s, learnt=pieces.learnt)

    def warm_up(self, orientation: str = DEFAULT) -> None:
        """Stand in the pose, be calibrated, and go on."""
        setup = SessionSetup(self.pipeline.name, TRUNK, 100.0, orientation=orientation)
        calibrate_still(pipelines.create(setup), len(TRUNK))


KIND: Final = BalanceKind()
