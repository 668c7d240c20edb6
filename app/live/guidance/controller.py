"""The guidance of one live session: fed with its frames, steered by its patient, heard on the live socket.

Everything runs on the event loop's thread. What stops is looked at before anything else, and the patient's own
buttons ask no estimator. An error ends the guidance, never the session.
"""

import logging
from collections.abc import Callable
from typing import Any, Final, Protocol

import numpy as np

from app.assessment.design.prescribed import PrescribedGuidance
from app.assessment.design.rules import said
from app.errors import Conflict
from app.live.guidance.messages import (
    GuidanceCause,
    GuidanceCommand,
    GuidanceCounts,
    GuidanceMessage,
    GuidanceStatus,
)
from app.live.guidance.resume_state import ResumeState
from app.live.guidance.words import HELD, PAUSED, RESUMED, STOPPED, counted
from estimators.comparison import channel_name, channel_unit
from estimators.guidance import CountedRepetition, Cue, GuidanceChunk, Stopped
from estimators.guidance.live import GuidanceRunner
from estimators.pipelines import Frames
from estimators.sentences import say

logger = logging.getLogger(__name__)

CUE_SHOWN_S: Final = 4.0
"""Session time for which a cue stays on the page."""
SURE: Final = 0.1
"""Above this sigma of the phase the example stays where it was last certain."""


class AddEvent(Protocol):
    """`SessionLog.add_event`."""

    def __call__(
        self, kind: str, time_s: float, *, text: str = "", details: dict[str, Any] | None = None
    ) -> None:
        """Store and publish something on the time line."""


class GuidanceController:
    """Guides one session.

    Parameters
    ----------
    prescribed : PrescribedGuidance or None
        None: nothing to follow; pausing, pain and stopping are taken all the same.
    taken_up : ResumeState
        What was counted before a restart.
    add_event : callable
        Takes entries of the time line.
    publish : callable(message)
        Takes what the live socket sends.
    trouble : str
        Why the template cannot be followed; empty where it can.
    notice : str
        Why nothing is followed though a template is prescribed, and that is as it should be; empty otherwise.
    """

    def __init__(
        self,
        prescribed: PrescribedGuidance | None,
        tick_s: float,
        taken_up: ResumeState,
        add_event: AddEvent,
        publish: Callable[[GuidanceMessage], None],
        *,
        trouble: str = "",
        notice: str = "",
    ) -> None:
        self._add_event, self._publish = add_event, publish
        self._counts = taken_up.counts.model_copy()
        self._in_set, self._is_done = taken_up.in_set.model_copy(), taken_up.is_done
        self._dose = None if prescribed is None else prescribed.dose
        if self._dose is not None:
            self._is_done = self._is_done or self._dose.is_done_before
            if not taken_up.has_ended_a_set:
                # The set that an earlier session of the day had begun goes on.
                self._in_set.valid += self._dose.before % self._dose.set_valid
        self._following: GuidanceRunner | None = None
        if prescribed is not None:
            ordered = prescribed.guidance
            self._following = GuidanceRunner(
                ordered.ready,
                tick_s,
                valid_share=ordered.valid_share,
                rules=ordered.rules,
                stops=ordered.stops,
                pace=ordered.pace,
            )
        self._has_told_limits = taken_up.has_set_aside
        if self._following is not None and taken_up.time_s and not taken_up.has_set_aside:
            # The exercise was under way when the service restarted: its limits hold from the first frame.
            self._following.watch_all()
        self._cause: GuidanceCause = taken_up.cause
        self._is_stopped = taken_up.is_stopped
        if self._cause and self._following is not None:
            # What was stopped before a restart of the service stays so.
            self._following.hold()
        self._has_failed = bool(trouble)
        self._last: CountedRepetition | None = None
        self._cue: Cue | None = None
        self._cue_number = 0
        self._cue_until_s = 0.0
        self._ghost_phase: float | None = None
        self._time_s = taken_up.time_s
        self.message = self._told(None)
        if trouble:
            add_event("guidance_failed", self._time_s, text=trouble)
        if notice:
            add_event("guidance_off", self._time_s, text=notice)

    @property
    def is_following(self) -> bool:
        """Whether it looks at frames as they come."""
        return self._following is not None and not self._has_failed

    # --- frames -----------------------------------------------------------------------------------------

    def see(self, frames: Frames, *, is_counting: bool, is_live: bool) -> None:
        """Take the frames of a chunk.

        Parameters
        ----------
        is_counting : bool
            Within the interval in which repetitions count.
        is_live : bool
            False for what came late: it is counted, but no cue is said of it.
        """
        self._time_s = (frames.first_tick + frames.tick_count) * frames.time_step_s
        if self._following is None or self._has_failed or not frames.tick_count:
            return
        if not is_counting:
            self._following.leave()
            self._tell(None)
            return
        if not self._following.measures_main(frames):
            channel = channel_name(self._following.main)
            self._fail(say("guided.main_not_measured", channel=channel))
            return
        try:
            self._follow(self._following, frames, is_live=is_live)
        except Exception:
            logger.exception("the guidance failed")
            self._fail(say("guided.failed"))

    def _fail(self, why: str) -> None:
        self._has_failed = True
        self._add_event("guidance_failed", self._time_s, text=why)
        self._tell(None)

    def _follow(self, following: GuidanceRunner, frames: Frames, *, is_live: bool) -> None:
        chunk, is_settled = following.feed(frames)
        self._report_set_aside(following)
        first_s = self._time_s - len(chunk.phase) * frames.time_step_s

        def time_of(tick: int) -> float:
            return first_s + (tick - chunk.first_tick) * frames.time_step_s

        for stop in chunk.stops:
            self._stop_by(stop, time_of(stop.tick))
        for one in chunk.repetitions if is_settled else ():
            self._count(one, time_of(one.start_tick), time_of(one.end_tick))
        for cue in chunk.cues if is_settled and not self._cause else ():
            self._say(cue, time_of(cue.tick), is_live=is_live)
        if self._cause in ("lost", "unsure") and following.is_tracked(chunk):
            self._go_on("")
        self._tell(chunk if is_settled else None)

    def _count(self, one: CountedRepetition, start_s: float, end_s: float) -> None:
        if one.kind == "ignored":
            return
        self._last = one
        self._counts, number = _one_more(self._counts, one.kind)
        self._in_set, _ = _one_more(self._in_set, one.kind)
        details = {
            "kind": one.kind,
            "start_s": start_s,
            "attained": [float(q) for q in one.quotient],
            "wrong_share": one.wrong_share,
        }
        self._add_event("repetition", end_s, text=counted(one.kind, number), details=details)
        self._end_set(end_s)

    def _end_set(self, time_s: float) -> None:
        """Hold the exercise where the finished repetition was the last one of a set, or of all."""
        if self._dose is None or self._following is None or self._cause:
            return
        in_set = self._in_set
        attempts = in_set.valid + in_set.partial + in_set.wrong
        reached = self._dose.reached(self._counts.valid, in_set.valid, attempts, is_done=self._is_done)
        if not reached:
            return
        self._in_set = GuidanceCounts()
        self._is_done = self._is_done or reached == "valid_count"
        self._following.hold()
        self._cause, self._is_stopped, self._cue = reached, reached != "set", None
        kind = "guidance_pause" if reached == "set" else "guidance_stop"
        self._add_event(kind, time_s, text=HELD[reached], details={"cause": reached})

    def _say(self, cue: Cue, time_s: float, *, is_live: bool) -> None:
        words = said(cue.sentence)
        details = {
            "sentence": cue.sentence,
            "phase": cue.phase,
            "value": _number(cue.value),
            "limit": _number(cue.limit),
        }
        self._add_event("cue", time_s, text=words, details=details)
        if is_live:
            self._cue, self._cue_number = cue, self._cue_number + 1
            self._cue_until_s = time_s + CUE_SHOWN_S

    def _stop_by(self, stop: Stopped, time_s: float) -> None:
        if self._cause:
            # Nothing that is noticed later takes the place of a stop, least of all of pain.
            return
        self._cause, self._is_stopped = stop.kind, not stop.is_pause
        self._cue = None
        details = {"cause": stop.kind, "value": _number(stop.value), "limit": _number(stop.limit)}
        kind = "guidance_pause" if stop.is_pause else "guidance_stop"
        self._add_event(kind, time_s, text=HELD[stop.kind], details=details)

    def _report_set_aside(self, following: GuidanceRunner) -> None:
        """Tell the therapist, and not the patient, of limits that rest itself breaks."""
        found = () if self._has_told_limits else following.take_set_aside()
        self._has_told_limits = self._has_told_limits or bool(found)
        for rule, value in found:
            is_length = channel_unit(rule.channel) == "m"
            rests = say("size.length", value_m=value) if is_length else say("size.angle", value_rad=value)
            limit = (
                say("size.length", value_m=rule.limit)
                if is_length
                else say("size.angle", value_rad=rule.limit)
            )
            words = say("guided.limit_at_rest", channel=channel_name(rule.channel), value=rests, limit=limit)
            details = {"channel": rule.channel, "side": rule.side, "value": value, "limit": rule.limit}
            self._add_event("limit_at_rest", self._time_s, text=words, details=details)

    # --- the patient's buttons --------------------------------------------------------------------------

    def obey(self, command: GuidanceCommand) -> GuidanceMessage:
        """Carry out what the patient asks, at once; asking twice is asking once.

        Raises
        ------
        Conflict
            To go on after everything was ended.
        """
        if command == "resume":
            if self._cause and not (self._is_stopped and self._cause == "person"):
                self._go_on("person")
            elif self._cause:
                raise Conflict(say("guided.ended"))
        elif command == "pause":
            if not self._cause or self._cause in ("lost", "unsure"):
                # Otherwise it would go on by itself once the sensors are seen again.
                self._hold("person", is_stopped=False)
        elif self._cause != ("pain" if command == "pain" else "person") or not self._is_stopped:
            self._hold("pain" if command == "pain" else "person", is_stopped=True)
        self._tell(None)
        return self.message

    def _hold(self, cause: GuidanceCause, *, is_stopped: bool) -> None:
        if self._following is not None:
            self._following.hold()
        self._cause, self._is_stopped, self._cue = cause, is_stopped, None
        kind = "pain" if cause == "pain" else "guidance_stop" if is_stopped else "guidance_pause"
        words = HELD.get(cause, STOPPED if is_stopped else PAUSED)
        self._add_event(kind, self._time_s, text=words, details={"cause": cause})

    def _go_on(self, by: str) -> None:
        if self._following is not None:
            self._following.go_on()
        self._add_event("guidance_resume", self._time_s, text=RESUMED, details={"by": by})
        self._cause, self._is_stopped = "", False

    # --- telling ----------------------------------------------------------------------------------------

    def _tell(self, chunk: GuidanceChunk | None) -> None:
        before, self.message = self.message, self._told(chunk)
        if self.message.status == "moving" or before != self.message.model_copy(
            update={"time_s": before.time_s}
        ):
            self._publish(self.message)

    def _told(self, chunk: GuidanceChunk | None) -> GuidanceMessage:
        status = self._status(chunk)
        phase = sigma = None
        if status == "moving" and chunk is not None:
            phase, sigma = float(chunk.phase[-1]), float(chunk.sigma[-1])
            if sigma < SURE or self._ghost_phase is None:
                self._ghost_phase = phase
        else:
            # It waits at the start; while there is nothing to follow it shows how it is done.
            self._ghost_phase = 0.0 if status == "ready" else None
        if self._cue is not None and self._time_s > self._cue_until_s:
            self._cue = None
        kind = None if self._last is None or self._last.kind == "ignored" else self._last.kind
        return GuidanceMessage(
            status=status,
            cause=self._cause,
            time_s=self._time_s,
            phase=phase,
            sigma=sigma,
            ghost_phase=self._ghost_phase,
            counts=self._counts,
            goal=None if self._dose is None else self._dose.goal,
            before=0 if self._dose is None else self._dose.before,
            last=kind,
            cue="" if self._cue is None else said(self._cue.sentence),
            cue_number=self._cue_number,
        )

    def _status(self, chunk: GuidanceChunk | None) -> GuidanceStatus:
        if self._cause:
            return "stopped" if self._is_stopped else "paused"
        if self._has_failed:
            return "failed"
        if self._following is None:
            return "off"
        if chunk is None or not len(chunk.phase):
            return "waiting"
        return "moving" if chunk.moving[-1] and np.isfinite(chunk.phase[-1]) else "ready"


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _one_more(counts: GuidanceCounts, kind: str) -> tuple[GuidanceCounts, int]:
    number = getattr(counts, kind) + 1
    return counts.model_copy(update={kind: number}), number
