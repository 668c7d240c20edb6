"""Calibrations of sensors in the hand: six positions and the compass."""

import math
import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np

from app.errors import Conflict
from app.live.calibration.collectors import Collector, Outcome
from app.live.calibration.messages import CalibrationIn, FieldOut, SensorProgress
from estimators.calibration import (
    DeviceCalibration,
    LocalField,
    MagnetometerCollector,
    MagnetometerProgress,
    doubted_turns,
    ferraris,
    find_positions,
    odd_fields,
)
from estimators.conventions import Placement
from estimators.errors import CalibrationError
from estimators.pipelines import Pipeline
from estimators.recording import Float, ImuChunk
from estimators.sentences import Sentence, say

LONGEST_S = 600.0
_FIELD_HZ = 20.0
"""Readings a second that the compass fit takes: turned by hand, more tell nothing more."""


class _InHand(Collector):
    """Sensors that somebody handles; the others are left alone."""

    is_reviewed: ClassVar[bool] = True

    def __init__(self, wanted: CalibrationIn, placements: tuple[Placement, ...], time_step_s: float) -> None:
        super().__init__(wanted, placements, time_step_s)
        unknown = [p for p in wanted.placements if p not in placements]
        if unknown:
            raise Conflict(say("session.no_sensor", places=list(unknown)), placements=list(placements))
        self.handled: tuple[Placement, ...] = tuple(wanted.placements) or placements
        self.rows = [placements.index(p) for p in self.handled]
        self.first_tick: int | None = None
        self.next_tick = 0

    def add(self, chunk: ImuChunk) -> None:
        """Collect."""
        if self.first_tick is None:
            self.first_tick = chunk.first_tick
        self.next_tick = chunk.first_tick + chunk.tick_count
        if self.is_complete:
            return
        self.collect(chunk)
        if self.seconds > LONGEST_S:
            self.trouble = say("live.too_long")

    @property
    def newest_tick(self) -> int:
        """Number of the tick after the newest one."""
        return self.next_tick

    @property
    def seconds(self) -> float:
        """Since it began."""
        return 0.0 if self.first_tick is None else (self.next_tick - self.first_tick) * self.step_s

    def collect(self, chunk: ImuChunk) -> None:
        """Keep what is needed of a chunk."""
        raise NotImplementedError

    def outcome(
        self,
        pipeline: Pipeline,
        found: Mapping[Placement, DeviceCalibration],
        scores: Mapping[Placement, float],
        reasons: tuple[str, ...],
    ) -> Outcome:
        """Bring what was found into force."""
        known = pipeline.setup.devices
        devices = {p: merged(known.get(p), new) for p, new in found.items()}
        pipeline.set_devices(devices)
        return Outcome(
            min(scores.values()),
            reasons,
            None,
            devices,
            dict(scores),
            start_s=(self.first_tick or 0) * self.step_s,
            end_s=self.next_tick * self.step_s,
            details={"kind": self.wanted.kind, "placements": list(self.handled)},
        )


def merged(known: DeviceCalibration | None, new: DeviceCalibration) -> DeviceCalibration:
    """Return what is known of a device with what was found again in its place."""
    if known is None:
        return new
    return DeviceCalibration(
        new.accelerometer or known.accelerometer,
        new.gyroscope or known.gyroscope,
        new.magnetometer or known.magnetometer,
        new.field if new.magnetometer else known.field,
    )


class SixPositions(_InHand):
    """Six faces and three turns, in any order, each found on the stream."""

    def __init__(self, wanted: CalibrationIn, placements: tuple[Placement, ...], time_step_s: float) -> None:
        super().__init__(wanted, placements, time_step_s)
        self._rates: list[Float] = []
        self._forces: list[Float] = []
        self._found: list[list[str]] = [[] for _ in self.handled]
        self._doubted: list[dict[str, float]] = [{} for _ in self.handled]

    @property
    def step_progress(self) -> float:
        """Of the present step, 0 to 1."""
        return min(len(found) for found in self._found) / len(self.steps)

    @property
    def sensors(self) -> list[SensorProgress]:
        """Return how far each sensor is."""
        return [
            SensorProgress(
                placement=p,
                progress=len(found) / len(self.steps),
                hint=self._missing(found, doubted),
                is_done=len(found) == len(self.steps),
                found=found,
            )
            for p, found, doubted in zip(self.handled, self._found, self._doubted, strict=True)
        ]

    def _missing(self, found: list[str], doubted: dict[str, float]) -> str:
        step = next((step for step in self.steps if step.key not in found), None)
        if step is None:
            return ""
        axis = step.key.removeprefix("turn_")
        if axis not in doubted:
            return step.said("instruction")
        turned_rad = 2.0 * math.pi * abs(doubted[axis])
        if doubted[axis] > 0:
            return say("live.turned_too_far", axis=axis, excess_rad=turned_rad)
        return say("live.turned_too_little", axis=axis, missing_rad=turned_rad)

    def collect(self, chunk: ImuChunk) -> None:
        """Keep what is needed of a chunk."""
        self._rates.append(chunk.gyroscope_radps[self.rows])
        self._forces.append(chunk.accelerometer_mps2[self.rows])

    def _samples(self, sensor: int) -> tuple[Float, Float]:
        """Return all samples, lost ones as NaN: what turned meanwhile is not known, so its ends must not meet."""
        # The event loop goes on appending: both lists are cut to the same length first.
        forces = list(self._forces)
        rates = self._rates[: len(forces)]
        return (
            np.concatenate([part[sensor] for part in rates]),
            np.concatenate([part[sensor] for part in forces]),
        )

    def review(self) -> None:
        """Look for positions and turns again."""
        for i in range(len(self.handled)):
            if len(self._found[i]) < len(self.steps):
                self._found[i] = self._seen(i)
        keys = [s.key for s in self.steps]
        done = set(keys).intersection(*self._found)
        self.step = next((i for i, key in enumerate(keys) if key not in done), len(self.steps))
        behind = min(range(len(self.handled)), key=lambda i: len(self._found[i]))
        self.hint = "" if self.is_complete else self._missing(self._found[behind], self._doubted[behind])

    def _seen(self, sensor: int) -> list[str]:
        if not self._forces:
            return []
        rate, force = self._samples(sensor)
        if len(rate) * self.step_s < 1.0:
            return []
        rests, turns = find_positions(rate, force, 1.0 / self.step_s)
        faces = {f"face_{r.face[1]}_{'up' if r.face[0] == '+' else 'down'}" for r in rests}
        self._doubted[sensor] = doubted_turns(turns)
        turned = {f"turn_{t.axis}" for t in turns if t.axis not in self._doubted[sensor]}
        return [s.key for s in self.steps if s.key in faces | turned]

    def evaluate(self, pipeline: Pipeline) -> Outcome:
        """Fit every sensor; one that fails fails all, named."""
        found: dict[Placement, DeviceCalibration] = {}
        scores: dict[Placement, float] = {}
        reasons: list[str] = []
        for i, placement in enumerate(self.handled):
            try:
                result = ferraris(*self._samples(i), 1.0 / self.step_s)
            except CalibrationError as error:
                raise CalibrationError(_of(placement, error.message), redo=error.redo) from error
            found[placement], scores[placement] = result.device, result.score
            reasons += [_of(placement, reason) for reason in result.reasons]
        return self.outcome(pipeline, found, scores, tuple(reasons))


class Compass(_InHand):
    """Turned in all directions; coverage and residual are shown while it is turned."""

    def __init__(self, wanted: CalibrationIn, placements: tuple[Placement, ...], time_step_s: float) -> None:
        super().__init__(wanted, placements, time_step_s)
        self._fits = [MagnetometerCollector() for _ in self.handled]
        self._progress: list[MagnetometerProgress] = [fit.progress() for fit in self._fits]
        self._stride = max(1, round(1.0 / (_FIELD_HZ * time_step_s)))
        self._pending: deque[tuple[Float, Float]] = deque()
        # `review` and `evaluate` run in threads of their own, at the same time when somebody ends the turning.
        self._fitting = threading.Lock()

    @property
    def step_progress(self) -> float:
        """Of the present step, 0 to 1."""
        return min(self._part(p) for p in self._progress)

    @property
    def directions(self) -> list[tuple[float, float, float]]:
        """Return the directions that `visited` refers to."""
        return [
            (round(float(x), 3), round(float(y), 3), round(float(z), 3))
            for x, y, z in self._progress[0].directions
        ]

    @property
    def sensors(self) -> list[SensorProgress]:
        """Return how far each sensor is."""
        return [
            SensorProgress(
                placement=p,
                progress=self._part(now),
                hint=now.hint,
                is_done=now.is_complete,
                coverage=now.coverage,
                visited=[bool(v) for v in now.visited],
                residual_percent=_finite(100.0 * now.residual),
                heading_sigma_deg=_finite(math.degrees(now.heading_sigma_rad)),
            )
            for p, now in zip(self.handled, self._progress, strict=True)
        ]

    @staticmethod
    def _part(now: MagnetometerProgress) -> float:
        return 1.0 if now.is_complete else min(0.99, now.coverage / 0.85)

    def collect(self, chunk: ImuChunk) -> None:
        """Keep what is needed of a chunk."""
        if chunk.magnetometer_t is None:
            self.trouble = say("live.no_magnetometer")
            return
        picked = slice(-chunk.first_tick % self._stride, None, self._stride)
        self._pending.append(
            (chunk.magnetometer_t[self.rows][:, picked], chunk.accelerometer_mps2[self.rows][:, picked])
        )

    def _take(self) -> None:
        """Take what has come; only while `_fitting` is held."""
        while self._pending:
            field, force = self._pending.popleft()
            for fit, one, other in zip(self._fits, field, force, strict=True):
                fit.add(one, other)

    def review(self) -> None:
        """Take what has come and fit it."""
        with self._fitting:
            self._take()
            self._progress = [fit.progress() for fit in self._fits]
        least = min(range(len(self.handled)), key=lambda i: self._part(self._progress[i]))
        hint = self._progress[least].hint
        self.hint = hint if len(self.handled) == 1 or not hint else _of(self.handled[least], hint)
        if all(now.is_complete and now.coverage > 0.8 for now in self._progress):
            self.step = 1

    def next(self) -> None:
        """End now, with what was seen."""
        self.step = 1

    def evaluate(self, pipeline: Pipeline) -> Outcome:
        """Fit every sensor; one that fails fails all, named."""
        found: dict[Placement, DeviceCalibration] = {}
        scores: dict[Placement, float] = {}
        reasons: list[str] = []
        fields: dict[Placement, LocalField] = {}
        with self._fitting:
            self._take()
            self._progress = [fit.progress() for fit in self._fits]
            for placement, fit in zip(self.handled, self._fits, strict=True):
                try:
                    result = fit.result()
                except CalibrationError as error:
                    raise CalibrationError(_of(placement, error.message)) from error
                found[placement] = DeviceCalibration(magnetometer=result.calibration, field=result.field)
                fields[placement], scores[placement] = result.field, result.score
                reasons += [_of(placement, reason) for reason in result.reasons]
        reported, doubts = self._reported(fields, pipeline.setup.devices)
        return replace(self.outcome(pipeline, found, scores, (*reasons, *doubts)), fields=reported)

    def _reported(
        self, fields: Mapping[Placement, LocalField], known: Mapping[Placement, DeviceCalibration]
    ) -> tuple[tuple[FieldOut, ...], list[str]]:
        """Return the field that each sensor saw, and why it cannot be the earth's."""
        odd = odd_fields({str(placement): seen for placement, seen in fields.items()})
        reported: list[FieldOut] = []
        doubts: list[str] = []
        for placement, seen in fields.items():
            why = [*seen.doubts(self.hemisphere), *([odd[placement]] if placement in odd else [])]
            doubts += [_of(placement, one) for one in why]
            reported.append(
                FieldOut.of(placement, seen, known[placement].field if placement in known else None, not why)
            )
        return tuple(reported), doubts


def _of(placement: Placement, what: str) -> Sentence:
    """Return what is said of one sensor, with its place on the body before it."""
    return say("live.of_sensor", place=placement, what=what)


def _finite(value: float) -> float | None:
    return round(value, 2) if math.isfinite(value) else None
