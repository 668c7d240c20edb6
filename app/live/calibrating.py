"""The calibration of a live session: hold the pose, evaluate it between two steps of the pipeline, tell."""

import asyncio
from collections.abc import Callable
from functools import partial

from app.live.estimation import EstimationLine
from app.live.pose import PoseCollector
from estimators.errors import CalibrationError
from estimators.pipelines import Calibration
from estimators.recording import ImuChunk


class CalibrationDesk:
    """Collects the pose and has the pipeline evaluate it.

    Parameters
    ----------
    pose : PoseCollector
    line : EstimationLine
    changed : callable()
        Progress or hint are new.
    done : callable(calibration, pose)
        The calibration is in force.
    failed : callable(message, pose or None)
        It is not, with what to do; without a pose the patient was never still.
    """

    def __init__(
        self,
        pose: PoseCollector,
        line: EstimationLine,
        changed: Callable[[], None],
        done: Callable[[Calibration, ImuChunk], None],
        failed: Callable[[str, ImuChunk | None], None],
    ) -> None:
        self._pose, self._line = pose, line
        self._changed, self._done, self._failed = changed, done, failed
        self._loop = asyncio.get_running_loop()

    @property
    def progress(self) -> float | None:
        """From 0 to 1; None when no pose is awaited."""
        return self._pose.progress

    @property
    def hint(self) -> str:
        """What the patient should do."""
        return self._pose.hint

    def begin(self) -> None:
        """Begin to look for the pose."""
        self._pose.begin()

    def end(self) -> None:
        """Look no more."""
        self._pose.end()

    def add(self, chunk: ImuChunk) -> None:
        """Take ticks that the pipeline has just seen."""
        was_active, before = self._pose.is_active, (self._pose.hint, round(self._pose.progress or 0.0, 1))
        pose = self._pose.add(chunk)
        if pose is not None:
            self._line.call(partial(self._evaluate, pose))
        elif was_active and not self._pose.is_active:
            self._failed(self._pose.hint, None)
        elif (self._pose.hint, round(self._pose.progress or 0.0, 1)) != before:
            self._changed()

    def _evaluate(self, pose: ImuChunk) -> None:
        """Run in the thread of the estimation line."""
        try:
            found = self._line.pipeline.calibrate(pose)
        except CalibrationError as error:
            self._loop.call_soon_threadsafe(self._refused, str(error), pose)
        else:
            self._loop.call_soon_threadsafe(self._done, found, pose)

    def _refused(self, message: str, pose: ImuChunk) -> None:
        self._pose.end(message)
        self._failed(message, pose)
