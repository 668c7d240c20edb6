"""The kind of session that follows the arms; see `app.recordings.analysis.kinds`."""

from dataclasses import replace
from typing import Final

from app.kinds.arm.elbows import with_elbows
from app.kinds.arm.series import SERIES
from app.kinds.arm.slips import SlippedLine, mounted_since_s, report_slips, slips_of
from app.kinds.arm.worn import report_worn
from app.recordings.analysis.heading_line import with_first_headings
from app.recordings.analysis.kinds import SessionKind, Wanted
from app.recordings.analysis.offline import Analysis, estimated, posed, smoothed
from app.recordings.analysis.still import calibrate_still
from estimators import pipelines
from estimators.conventions import PLACEMENTS
from estimators.orientation import DEFAULT
from estimators.pipelines import ArmPipeline, SessionSetup


class ArmKind(SessionKind):
    """Arms and trunk."""

    pipeline = ArmPipeline
    live_frames_hz = 25.0
    series = SERIES

    def analyse(self, wanted: Wanted) -> Analysis:
        """Find the pose where the setup has no calibration, then estimate; the rest from all."""
        context, setup, pose_s, resets = wanted.context, wanted.setup, wanted.pose_s, wanted.resets
        pieces = smoothed(context, setup)
        setup, pose_s, message = posed(setup, pose_s, pieces, search=wanted.search_pose)
        if setup.calibration is not None and pose_s is not None:
            setup = with_elbows(setup, pose_s, pieces)
        if setup.calibration is not None and setup.calibration.unknown_headings:
            setup, resets = with_first_headings(setup, resets, pieces)
        resets = resets if setup.calibration is not None else ()
        from_s = mounted_since_s(context, wanted.resets) if pose_s is None else pose_s[1]
        slips, poses = slips_of(setup, resets, pieces, from_s)
        judged = setup if poses is None else pipelines.judge_worn(poses, setup, from_s)
        report_worn(context, judged, from_s)
        if judged is not setup:
            setup = judged
            slips, _ = slips_of(setup, resets, pieces, from_s)
        line = SlippedLine(pipelines.create(setup), resets, slips)
        found = estimated(context, line, pieces, message=message, progress_from=wanted.progress_from)
        report_slips(context, slips)
        return replace(found, pose_s=pose_s if setup.calibration is not None else None, learnt=pieces.learnt)

    def warm_up(self, orientation: str = DEFAULT) -> None:
        """Stand in the pose, be calibrated, and go on."""
        setup = SessionSetup(self.pipeline.name, PLACEMENTS, 100.0, orientation=orientation)
        calibrate_still(pipelines.create(setup), len(PLACEMENTS))


KIND: Final = ArmKind()
