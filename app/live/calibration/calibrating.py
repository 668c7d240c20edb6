"""The guided calibration of a live session: collect, evaluate between two steps of the pipeline, tell."""

import asyncio
import logging
import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from app.errors import Conflict
from app.live.calibration.collectors import Collector, MovementSteps, Outcome, PoseStep, findings_out
from app.live.calibration.device_collectors import Compass, SixPositions
from app.live.calibration.messages import (
    CalibrationIn,
    CalibrationKind,
    CalibrationMessage,
    Phase,
    SensorFinding,
)
from app.live.session.estimation import EstimationLine
from app.recordings.schemas import CalibrationOut
from estimators.calibration import Hemisphere, MisplacedError
from estimators.conventions import Placement
from estimators.errors import CalibrationError, EstimationError
from estimators.recording import ImuChunk
from estimators.sentences import say

logger = logging.getLogger(__name__)

TELL_EVERY_S: Final = 0.2
REVIEW_S: Final = 1.0
"""How often the progress of sensors in the hand is worked out again."""
LINK_PATIENCE_S: Final = 10.0
"""A calibration goes on when the link was away no longer, from the moment in which it was known to be lost."""
NOT_EVALUATED: Final = say("live.not_evaluated")
COLLECTORS: Final[dict[CalibrationKind, type[Collector]]] = {
    "static_bias": PoseStep,
    "n_pose": PoseStep,
    "t_pose": PoseStep,
    "heading_reset": PoseStep,
    "functional": MovementSteps,
    "passive": MovementSteps,
    "six_position": SixPositions,
    "magnetometer": Compass,
}


class CalibrationController:
    """Runs one guided calibration at a time.

    Parameters
    ----------
    hemisphere : {"north", "south", "unknown"}
        Of the place; tells how the earth's field points.
    tell : callable(message)
        Publishes to the live socket.
    changed : callable()
        Progress or hint of the session's state are new.
    done : callable(outcome, kind)
        It is in force.
    failed : callable(message)
        It is not, with what to do.
    """

    def __init__(
        self,
        placements: tuple[Placement, ...],
        time_step_s: float,
        line: EstimationLine,
        *,
        hemisphere: Hemisphere = "north",
        tell: Callable[[CalibrationMessage], None],
        changed: Callable[[], None],
        done: Callable[[Outcome, CalibrationKind], None],
        failed: Callable[[str], None],
    ) -> None:
        self._placements, self._step_s, self._line = placements, time_step_s, line
        self._hemisphere = hemisphere
        self._tell, self._changed, self._done, self._failed = tell, changed, done, failed
        self._loop = asyncio.get_running_loop()
        self._collector: Collector | None = None
        self._is_evaluating = False
        self._reviewing: asyncio.Task[None] | None = None
        self._last: CalibrationMessage | None = None
        self._told_s = 0.0
        self._lost_s = math.inf
        self._hint = ""

    @property
    def message(self) -> CalibrationMessage | None:
        """The newest message, also after the end; None before the first calibration."""
        return self._last

    @property
    def progress(self) -> float | None:
        """Of all steps, from 0 to 1; None when nothing is being calibrated."""
        found = self._collector
        if found is None:
            return None
        return min(1.0, (found.step + found.step_progress * (not found.is_complete)) / len(found.steps))

    @property
    def hint(self) -> str:
        """What the person should do."""
        return self._hint if self._collector is None else self._collector.hint

    @property
    def is_active(self) -> bool:
        """Whether a calibration runs."""
        return self._collector is not None

    def start(self, wanted: CalibrationIn) -> CalibrationMessage:
        """Begin, or begin again.

        Raises
        ------
        Conflict
            It cannot be done with the sensors worn.
        """
        if self._is_evaluating:
            raise Conflict(say("live.still_evaluating"))
        self._collector = COLLECTORS[wanted.kind](wanted, self._placements, self._step_s)
        self._collector.hemisphere = self._hemisphere
        return self._publish("collecting")

    def next(self) -> CalibrationMessage:
        """End the present step.

        Raises
        ------
        Conflict
            Nothing is being calibrated, or the step ends by itself or too early.
        """
        found = self._running()
        found.next()
        self._evaluate_when_complete()
        return self._publish("evaluating" if self._is_evaluating else "collecting")

    def cancel(self) -> CalibrationMessage:
        """End without a result.

        Raises
        ------
        Conflict
            Nothing is being calibrated.
        """
        self._running()
        message = self._publish("cancelled")
        self._collector, self._hint = None, ""
        return message

    def link_lost(self) -> None:
        """Wait for the link where a gap only delays the present step; collect no more where it spoils it."""
        self._lost_s = time.monotonic()
        if self._collector is not None and not self._collector.is_delayed_by_gaps:
            self.end()

    def link_back(self) -> bool:
        """Go on where the link was lost; return whether a calibration runs.

        After `LINK_PATIENCE_S` it is over: whoever stood still then may have taken the sensors off.
        """
        if time.monotonic() - self._lost_s > LINK_PATIENCE_S:
            self.end()
        return self.is_active

    def end(self) -> None:
        """Collect no more: the session ends, or nothing can come of it."""
        if self._collector is not None and not self._is_evaluating:
            self._publish("cancelled")
            self._collector, self._hint = None, ""

    def add(self, chunk: ImuChunk) -> None:
        """Take ticks that the pipeline has just seen."""
        found = self._collector
        if found is None:
            return
        before = (found.hint, found.step, round(found.step_progress, 1))
        found.add(chunk)
        if self._is_evaluating:
            return
        if found.trouble:
            self._refused(found, found.trouble)
            return
        if found.is_reviewed and self._reviewing is None and not found.is_complete:
            self._reviewing = asyncio.create_task(self._review(found), name="calibration review")
        self._evaluate_when_complete()
        if (found.hint, found.step, round(found.step_progress, 1)) != before:
            self._changed()
            if time.monotonic() - self._told_s >= TELL_EVERY_S or found.step != before[1]:
                self._publish("evaluating" if self._is_evaluating else "collecting")

    def _running(self) -> Collector:
        if self._collector is None or self._is_evaluating:
            raise Conflict(say("live.no_step"))
        return self._collector

    async def _review(self, found: Collector) -> None:
        """Work out the progress in a thread, again as long as something new comes."""
        try:
            seen = -1
            while found is self._collector and not self._is_evaluating and found.newest_tick != seen:
                seen = found.newest_tick
                await asyncio.to_thread(found.review)
                if found is not self._collector or self._is_evaluating:
                    break
                self._evaluate_when_complete()
                self._changed()
                self._publish("evaluating" if self._is_evaluating else "collecting")
                await asyncio.sleep(REVIEW_S)
        except Exception:
            logger.exception("the progress of a calibration could not be worked out")
        finally:
            self._reviewing = None

    def _evaluate_when_complete(self) -> None:
        found = self._collector
        if found is not None and found.is_complete and not self._is_evaluating:
            self._is_evaluating = True
            self._line.call(partial(self._evaluate, found))

    def _evaluate(self, found: Collector) -> None:
        """Run in the thread of the estimation line."""
        try:
            outcome = found.evaluate(self._line.pipeline)
        except EstimationError as error:
            findings = findings_out(error.findings) if isinstance(error, MisplacedError) else ()
            redo = error.redo if isinstance(error, CalibrationError) else ()
            self._loop.call_soon_threadsafe(self._refused, found, error.message, findings, redo)
        except Exception:
            # A calibration that cannot be worked out must not end the session it belongs to.
            logger.exception("a calibration could not be evaluated")
            self._loop.call_soon_threadsafe(self._refused, found, NOT_EVALUATED)
        else:
            self._loop.call_soon_threadsafe(self._settled, found, outcome)

    def _settled(self, found: Collector, outcome: Outcome) -> None:
        self._publish("done", outcome)
        self._collector, self._is_evaluating, self._hint = None, False, ""
        self._done(outcome, found.wanted.kind)

    def _refused(
        self,
        found: Collector,
        text: str,
        findings: tuple[SensorFinding, ...] = (),
        redo: tuple[str, ...] = (),
    ) -> None:
        self._publish("redo", text=text, findings=findings, redo=redo)
        self._collector, self._is_evaluating, self._hint = None, False, text
        self._failed(text)

    def _publish(
        self,
        phase: Phase,
        outcome: Outcome | None = None,
        text: str = "",
        findings: tuple[SensorFinding, ...] = (),
        redo: tuple[str, ...] = (),
    ) -> CalibrationMessage:
        found = self._collector
        assert found is not None
        calibration = None if outcome is None else outcome.calibration
        message = CalibrationMessage(
            kind=found.wanted.kind,
            phase=phase,
            steps=found.steps,
            step=found.step,
            step_progress=round(found.step_progress, 3),
            hint=text or found.hint,
            sensors=found.sensors,
            directions=found.directions,
            score=None if outcome is None else outcome.score,
            reasons=[text] if text else list(outcome.reasons) if outcome else [],
            redo_steps=redo_steps(found, redo) if text else [],
            axes=list(outcome.axes) if outcome else [],
            findings=list(outcome.findings if outcome else findings),
            fields=list(outcome.fields) if outcome else [],
            result=None if calibration is None else CalibrationOut.of(calibration),
        )
        self._last, self._told_s = message, time.monotonic()
        self._tell(message)
        return message


def redo_steps(found: Collector, redo: Sequence[str] = ()) -> list[str]:
    """Return the steps that a refusal names; all when it names none."""
    keys = [step.key for step in found.steps]
    return [key for key in keys if key in redo] or keys
