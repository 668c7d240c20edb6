"""Watches whether joints of a live session bend as they can, and so whether its standing pose was what it should be."""

from estimators.calibration import HINGES, Calibration
from estimators.pipelines import ArmPipeline, Frames, Pipeline, WornCheck


class WornWatch:
    """Follows the frames of one session, from each calibration on."""

    def __init__(self) -> None:
        self._known: Calibration | None = None
        self._check: WornCheck | None = None

    @classmethod
    def of(cls, pipeline: Pipeline) -> "WornWatch | None":
        """Return a watch over the frames of a pipeline; None where no worn joint tells anything."""
        if not isinstance(pipeline, ArmPipeline):
            return None
        worn = pipeline.setup.placements
        tells = any(one.lower in worn and one.upper in worn for one in HINGES)
        return cls() if tells or any(name.startswith("upper_arm") for name in worn) else None

    def add(self, frames: Frames, calibration: Calibration | None) -> Calibration | None:
        """Take frames.

        Parameters
        ----------
        frames : Frames
            The next ones.
        calibration : Calibration or None
            In force.

        Returns
        -------
        Calibration or None
            What movements leave of it, once they contradict it.
        """
        if calibration is not self._known:
            self._known, self._check = calibration, None
            if calibration is not None and self._is_judged(calibration):
                self._check = WornCheck(calibration)
        return None if self._check is None else self._check.add(frames)

    @staticmethod
    def _is_judged(calibration: Calibration) -> bool:
        is_by_pose = "pose" in calibration.method
        return is_by_pose and not calibration.unknown_headings and not calibration.contradicted
