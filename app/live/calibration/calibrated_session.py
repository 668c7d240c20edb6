"""The part of a live session that is calibrated: guided steps, what comes of them, what is remembered."""

import asyncio
from abc import abstractmethod
from dataclasses import replace
from functools import partial

from app.errors import Conflict
from app.live import repository
from app.live.calibration.calibrating import CalibrationController
from app.live.calibration.collectors import Outcome
from app.live.calibration.device_rows import save_device_calibrations
from app.live.calibration.messages import CalibrationIn, CalibrationKind, CalibrationMessage
from app.live.checks.worn_watch import WornWatch
from app.live.messages import LayoutMessage
from app.live.session.estimation import EstimationLine
from app.live.session.session_log import SessionLog
from app.network.declaration import Declaration
from app.recordings.analysis.kinds import kind_of
from estimators.calibration import JUDGED, Calibration, Hemisphere
from estimators.pipelines import ArmPipeline, Frames, Pipeline
from estimators.sentences import CATALOGUE, say


class CalibratedSession(SessionLog):
    """A session with a pipeline that can be calibrated while it streams."""

    line: EstimationLine
    stored: repository.StoredSession
    result_id: str
    _worn: WornWatch | None
    _loop: asyncio.AbstractEventLoop

    @property
    @abstractmethod
    def pipeline(self) -> Pipeline:
        """The session's estimators."""

    @property
    @abstractmethod
    def declaration(self) -> Declaration:
        """The network."""

    @abstractmethod
    def layout(self) -> LayoutMessage:
        """Return the columns of the frames."""

    def prepare_calibration(self, hemisphere: Hemisphere) -> None:
        """Make the controller; once, when pipeline and line are there."""
        self._calibration = CalibrationController(
            self.declaration.placements,
            self.declaration.time_step_s,
            self.line,
            hemisphere=hemisphere,
            tell=self.channels["calibration"].publish,
            changed=self._publish_state,
            done=self._calibrated,
            failed=self._calibration_failed,
        )

    @property
    def is_calibrated(self) -> bool:
        """Whether joint angles mean anything; not when only biases or a remembered mounting are known.

        Some kinds of session need no calibration.
        """
        if not self.pipeline.needs_pose:
            return True
        found = self.pipeline.setup.calibration
        return found is not None and bool(found.q_sensor_segment) and not found.unknown_headings

    @property
    def calibration_message(self) -> CalibrationMessage | None:
        """The newest message of a guided calibration."""
        return self._calibration.message

    @property
    def is_calibrating(self) -> bool:
        """Whether a calibration is under way."""
        return self._calibration.is_active

    def start_calibration(self, wanted: CalibrationIn) -> CalibrationMessage:
        """Begin a guided calibration.

        Raises
        ------
        Conflict
            No packets come, a recording runs, or the sensors worn do not allow it.
        """
        if self.machine.state not in {"calibrating", "ready"}:
            raise Conflict(
                say("live.cannot_calibrate"),
                state=self.machine.state,
            )
        if refused := kind_of(self.pipeline.setup).calibration_refused:
            raise Conflict(refused)
        message = self._calibration.start(wanted)
        self._change("calibrating", message.steps[0].said("title"))
        return message

    def next_calibration_step(self) -> CalibrationMessage:
        """End the present step of a guided calibration."""
        return self._calibration.next()

    def cancel_calibration(self) -> CalibrationMessage:
        """End a guided calibration; what was in force stays."""
        message = self._calibration.cancel()
        self._back_to_ready(say("live.calibration_cancelled"))
        return message

    def _calibration_failed(self, text: str) -> None:
        self.add_event("error", self.session_time_s, text=text)
        self._back_to_ready(text)

    def _back_to_ready(self, text: str) -> None:
        if self.is_calibrated and self.machine.state == "calibrating":
            self._change("ready", say("live.calibration_stays", reason=text))
        else:
            self.machine.reason = text
            self._publish_state()

    def _watch_worn(self, frames: Frames, pipeline: Pipeline) -> None:
        """Let movements judge the standing pose, until the sensors may be taken off."""
        if self._worn is None or self.recording_end_s is not None or self._calibration.is_active:
            return
        known = pipeline.setup.calibration
        found = self._worn.add(frames, known)
        if found is not None:
            self.line.call(partial(self._put_in_force, pipeline, known, found))

    def _put_in_force(self, pipeline: Pipeline, known: Calibration | None, found: Calibration) -> None:
        """Run in the thread of the estimation line."""
        if isinstance(pipeline, ArmPipeline) and pipeline.setup.calibration is known:
            pipeline.adopt(found)
            self._loop.call_soon_threadsafe(self._judged, found)

    def _judged(self, found: Calibration) -> None:
        """Tell what movements said of the pose; what they only contradict, the analysis judges once more."""
        if not found.contradicted:
            self._save_calibration()
        reasons = [one for one in found.reasons if getattr(one, "code", "") in JUDGED]
        for reason in reasons:
            self.add_event("calibration_checked", self.session_time_s, text=reason)
        self.machine.reason = CATALOGUE.together(reasons)
        self._publish_state()

    def _save_calibration(self) -> None:
        setup = self.pipeline.setup
        self.stored = replace(self.stored, setup=setup.to_dict())
        self._saver.save(partial(repository.save_calibration, self._engine, self.id, self.result_id, setup))

    def _calibrated(self, found: Outcome, kind: CalibrationKind) -> None:
        self._save_calibration()
        setup = self.pipeline.setup
        if found.devices:
            serials = self.declaration.serial_of
            self._saver.save(
                partial(
                    save_device_calibrations,
                    self._engine,
                    self.id,
                    serials,
                    found.devices,
                    found.device_scores,
                )
            )
        self.add_event(
            "calibration" if found.calibration is not None else "device_calibration",
            found.start_s,
            found.end_s - found.start_s,
            text=CATALOGUE.together(found.reasons),
            details=dict(found.details),
        )
        self.channels["layout"].publish(self.layout())
        if self.machine.state == "calibrating" and self.is_calibrated:
            self._change("ready", say("live.calibrated", score=found.score))
        else:
            done = say("live.calibration_done", kind=kind, score=found.score)
            left = [] if setup.calibration is None else list(setup.calibration.unknown_headings)
            self.machine.reason = CATALOGUE.together(
                [done, say("live.directions_left", places=left) if left else ""]
            )
            self._publish_state()
