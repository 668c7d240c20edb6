"""Collectors of the stream for each kind of calibration, and its evaluation in the end.

A collector sees every aligned chunk on the event loop and says how far the person is; `evaluate` runs in the
thread of the estimation line, between two steps of the pipeline. Collectors go on collecting until then, so that
what they hold ends with the newest tick.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from app.errors import Conflict
from app.live.calibration.guides import GUIDES
from app.live.calibration.messages import (
    AxisOut,
    CalibrationIn,
    CalibrationStep,
    FieldOut,
    SensorFinding,
    SensorProgress,
)
from app.live.calibration.pose import PoseCollector
from app.recordings.analysis.heading_line import HeadingReset
from estimators.calibration import (
    DeviceCalibration,
    Hemisphere,
    PlacementFinding,
    check_distinct,
    check_mounting,
)
from estimators.conventions import Placement
from estimators.errors import CalibrationError
from estimators.pipelines import Calibration, Pipeline
from estimators.recording import ImuChunk
from estimators.sentences import say

LONGEST_STEP_S = 120.0
LEAST_MOVEMENT_S = 3.0
"""A movement that a person ended sooner cannot hold three repetitions."""


@dataclass(frozen=True)
class Outcome:
    """What an evaluation found; `calibration` is in force in the pipeline already.

    Attributes
    ----------
    calibration : Calibration or None
        None when only devices were calibrated.
    start_s, end_s : float
        Session time of the samples.
    details : dict
        Stored with the event: enough to repeat the evaluation with another estimator.
    """

    score: float
    reasons: tuple[str, ...] = ()
    calibration: Calibration | None = None
    devices: dict[Placement, DeviceCalibration] = field(default_factory=dict)
    device_scores: dict[Placement, float] = field(default_factory=dict)
    start_s: float = 0.0
    end_s: float = 0.0
    details: Mapping[str, Any] = field(default_factory=dict)
    axes: tuple[AxisOut, ...] = ()
    findings: tuple[SensorFinding, ...] = ()
    fields: tuple[FieldOut, ...] = ()


class Collector(ABC):
    """One running guided calibration.

    Parameters
    ----------
    placements : tuple of Placement
        Sensors of the session in the order of the packets.
    """

    is_reviewed: ClassVar[bool] = False
    """Whether progress is worked out by `review`, in a thread, instead of by `add`."""

    def __init__(self, wanted: CalibrationIn, placements: tuple[Placement, ...], time_step_s: float) -> None:
        self.wanted, self.placements, self.step_s = wanted, placements, time_step_s
        self.steps: list[CalibrationStep] = list(GUIDES[wanted.kind].steps)
        self.step = 0
        self.hint = self.steps[0].said("instruction")
        self.hemisphere: Hemisphere = "unknown"
        """Of the place; whoever begins a calibration says it."""
        self.trouble = ""
        """Why nothing can come of it any more; empty while it can."""

    @property
    def is_complete(self) -> bool:
        """Whether it is time to evaluate."""
        return self.step >= len(self.steps)

    @property
    def is_delayed_by_gaps(self) -> bool:
        """Whether a gap only delays the present step: what is held without one is awaited again."""
        return False

    @property
    @abstractmethod
    def step_progress(self) -> float:
        """Of the present step, 0 to 1."""

    @property
    def sensors(self) -> list[SensorProgress]:
        """Return how far each sensor is, where sensors are calibrated one by one."""
        return []

    @property
    def directions(self) -> list[tuple[float, float, float]]:
        """Return the directions that `visited` of the sensors refers to."""
        return []

    @abstractmethod
    def add(self, chunk: ImuChunk) -> None:
        """Take ticks that the pipeline has just seen."""

    def next(self) -> None:
        """End the present step because a person says so.

        Raises
        ------
        Conflict
            It ends by itself, or too early.
        """
        raise Conflict(say("live.step_ends_itself"), step=self.steps[self.step].key)

    @property
    def newest_tick(self) -> int:
        """Number of the tick after the newest one, where `review` counts."""
        return 0

    def review(self) -> None:  # noqa: B027 - poses and movements need none
        """Work out the progress; runs in a thread, `add` goes on meanwhile."""

    @abstractmethod
    def evaluate(self, pipeline: Pipeline) -> Outcome:
        """Evaluate what was collected; raises `CalibrationError` with what to redo."""


class PoseStep(Collector):
    """One pose held still: `static_bias`, `n_pose`, `t_pose`, `heading_reset`."""

    def __init__(self, wanted: CalibrationIn, placements: tuple[Placement, ...], time_step_s: float) -> None:
        super().__init__(wanted, placements, time_step_s)
        self._pose = PoseCollector(placements, time_step_s, self.steps[0].said("instruction"))
        self._pose.begin()
        self._held: list[ImuChunk] = []
        self.hint = self._pose.hint

    @property
    def is_delayed_by_gaps(self) -> bool:
        """Always: a pose counts by the seconds in which nothing is missing."""
        return True

    @property
    def step_progress(self) -> float:
        """Of the present step, 0 to 1."""
        return 1.0 if self.is_complete else self._pose.progress or 0.0

    def add(self, chunk: ImuChunk) -> None:
        """Wait for three still seconds."""
        if self.is_complete:
            return
        held = self._pose.add(chunk)
        self.hint = self._pose.hint
        if held is not None:
            self._held, self.step = [held], 1
        elif not self._pose.is_active:
            self.trouble = self._pose.hint

    def evaluate(self, pipeline: Pipeline) -> Outcome:
        """Evaluate the still seconds."""
        pose = ImuChunk.join(self._held)
        check_distinct(pose.gyroscope_radps, pose.accelerometer_mps2, self.placements)
        before = pipeline.setup.calibration
        details: dict[str, Any] = {"kind": self.wanted.kind}
        if self.wanted.kind == "heading_reset":
            limbs = limb_placements(self.wanted.limbs, self.placements)
            found = pipeline.reset_heading(pose, limbs)
            details |= HeadingReset.details(limbs, before)
        else:
            method = "bias" if self.wanted.kind == "static_bias" else self.wanted.kind
            found = pipeline.calibrate(pose, method)
        return Outcome(
            found.score,
            found.reasons,
            found,
            start_s=pose.first_tick * self.step_s,
            end_s=(pose.first_tick + pose.tick_count) * self.step_s,
            details=details,
            findings=findings_out(check_mounting(found, before)) if "pose" in self.wanted.kind else (),
        )


class MovementSteps(Collector):
    """Rest, then movements that a person ends one by one: `functional` and `passive`."""

    def __init__(self, wanted: CalibrationIn, placements: tuple[Placement, ...], time_step_s: float) -> None:
        super().__init__(wanted, placements, time_step_s)
        self._sides = arms_of(wanted.limbs, placements)
        if not self._sides:
            raise Conflict(say("live.functional_sensors"))
        self._pose = PoseCollector(placements, time_step_s, self.steps[0].said("instruction"))
        self._pose.begin()
        self._held: list[ImuChunk] = []
        self._ranges: dict[str, tuple[int, int]] = {}
        self._begin_tick = 0
        self._next_tick = 0

    @property
    def is_delayed_by_gaps(self) -> bool:
        """While the rest is awaited; a movement with a gap is lost."""
        return self.step == 0

    @property
    def step_progress(self) -> float:
        """Of the present step, 0 to 1."""
        if self.is_complete:
            return 1.0
        if self.step == 0:
            return self._pose.progress or 0.0
        return min(1.0, (self._next_tick - self._begin_tick) * self.step_s / LEAST_MOVEMENT_S)

    def add(self, chunk: ImuChunk) -> None:
        """Keep everything from the rest on."""
        self._next_tick = chunk.first_tick + chunk.tick_count
        if self.step > 0:
            self._held.append(chunk)
            if not self.is_complete and (self._next_tick - self._begin_tick) * self.step_s > LONGEST_STEP_S:
                self.trouble = say("live.movement_not_ended")
            return
        held = self._pose.add(chunk)
        self.hint = self._pose.hint
        if held is not None:
            self._held = [held]
            self._ranges["rest"] = (held.first_tick, self._next_tick)
            self._advance()
        elif not self._pose.is_active:
            self.trouble = self._pose.hint

    def next(self) -> None:
        """End the present movement."""
        if self.is_complete or self.step == 0:
            raise Conflict(say("live.rest_ends_itself"), step="rest")
        if (self._next_tick - self._begin_tick) * self.step_s < LEAST_MOVEMENT_S:
            raise Conflict(
                say("live.movement_too_short", least_s=LEAST_MOVEMENT_S),
                step=self.steps[self.step].key,
            )
        self._ranges[self.steps[self.step].key] = (self._begin_tick, self._next_tick)
        self._advance()

    def _advance(self) -> None:
        self.step += 1
        self._begin_tick = self._next_tick
        self.hint = "" if self.is_complete else self.steps[self.step].said("instruction")

    def evaluate(self, pipeline: Pipeline) -> Outcome:
        """Evaluate rest and movements."""
        chunk = ImuChunk.join(self._held)
        rest = self._held[0]
        check_distinct(rest.gyroscope_radps, rest.accelerometer_mps2, self.placements)
        movements = {
            f"{name}{ending}": bounds
            for name, bounds in self._ranges.items()
            for ending in ([""] if name == "rest" else [f"_{side}" for side in self._sides])
        }
        before = pipeline.setup.calibration
        found = pipeline.calibrate_by_movement(chunk, movements, assisted=self.wanted.kind == "passive")
        return Outcome(
            found.calibration.score,
            found.calibration.reasons,
            found.calibration,
            start_s=chunk.first_tick * self.step_s,
            end_s=max(stop for _, stop in movements.values()) * self.step_s,
            details={
                "kind": self.wanted.kind,
                "movements_s": {
                    name: [start * self.step_s, stop * self.step_s]
                    for name, (start, stop) in movements.items()
                },
            },
            axes=tuple(
                AxisOut(
                    name=axis.name,
                    range_deg=round(57.29578 * axis.range_rad, 1),
                    sigma_deg=round(57.29578 * axis.sigma_rad, 1),
                )
                for axis in found.axes
            ),
            findings=findings_out(check_mounting(found.calibration, before)),
        )


def findings_out(findings: Sequence[PlacementFinding]) -> tuple[SensorFinding, ...]:
    """Return findings as the browser sees them."""
    return tuple(
        SensorFinding(code=found.code, placements=list(found.placements), text=found.text)
        for found in findings
    )


def limb_placements(limbs: Sequence[str], worn: Sequence[Placement]) -> list[Placement]:
    """Return the worn sensors of some limbs; of all when none is named."""
    parts: dict[str, tuple[str, ...]] = {
        "left_arm": ("shoulder_left", "upper_arm_left", "forearm_left", "hand_left"),
        "right_arm": ("shoulder_right", "upper_arm_right", "forearm_right", "hand_right"),
        "trunk": ("head", "sternum", "pelvis"),
        "legs": tuple(f"{p}_{side}" for p in ("thigh", "shank", "foot") for side in ("left", "right")),
    }
    wanted = {name for limb in (limbs or parts) for name in parts[limb]}
    found = [name for name in worn if name in wanted]
    if not found:
        raise CalibrationError(say("live.no_sensor_of_limb"))
    return found


def arms_of(limbs: Sequence[str], worn: Sequence[Placement]) -> list[str]:
    """Return the sides whose arm moves: those named, or all with sensors on upper arm and forearm."""
    able = [s for s in ("left", "right") if {f"upper_arm_{s}", f"forearm_{s}"} <= set(worn)]
    named = [s for s in able if f"{s}_arm" in limbs]
    return named or able
