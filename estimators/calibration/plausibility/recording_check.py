"""Readings that cannot be right: units, axes, signs and dead channels, found by what does not depend on itself."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from estimators.calibration.force.verdict import Correction, correction, is_found
from estimators.calibration.plausibility.finding import Finding, Hemisphere
from estimators.calibration.plausibility.readings import Readings
from estimators.calibration.plausibility.verdict import BESIDE_CORRECTION, Verdict
from estimators.errors import ShapeError
from estimators.orientation._screen import SampleScreen
from estimators.recording import Float, ImuChunk, SampleQuality

STRETCH_S: Final = 60.0
"""What is looked at together; memory and time stay bounded however long a recording is."""


class RecordingCheck:
    """Looks at a recording stretch by stretch and says what cannot be right so far.

    Parameters
    ----------
    names : sequence of str, length S
        What to call the sensors.
    hemisphere : {"north", "south", "unknown"}
        Of the place: the field points down in the north and up in the south.
    clip_levels : ndarray, shape (S, 2, 2, 3), optional
        As `clip_levels` of a check of what came before.
    corrects : bool
        Whether `corrections` will be asked for: a whole recording, not a session that goes on.

    Notes
    -----
    Nothing is judged by itself: a gyroscope by how gravity and field turn in the sensor, also where it reads nothing;
    axes of accelerometer and magnetometer by the gyroscope and each other; force by gravity where it is calm.
    """

    def __init__(
        self,
        names: Sequence[str],
        hemisphere: Hemisphere = "north",
        clip_levels: Float | None = None,
        *,
        corrects: bool = False,
    ) -> None:
        self._hemisphere = hemisphere
        known = [None] * len(names) if clip_levels is None else clip_levels
        self._sensors = [
            Readings(name, levels, is_corrected=corrects) for name, levels in zip(names, known, strict=True)
        ]
        self._next_tick = 0
        self._screen: SampleScreen | None = None

    def add(self, chunk: ImuChunk) -> None:
        """Take the next stretch.

        Parameters
        ----------
        chunk : ImuChunk
            As declared (rad/s, m/s^2, T), at least some seconds.

        Raises
        ------
        ShapeError
            If it has not as many sensors as there are names.
        """
        if len(self._sensors) != chunk.sensor_count:
            raise ShapeError(f"{len(self._sensors)} names for {chunk.sensor_count} sensors")
        is_next = chunk.first_tick == self._next_tick
        self._next_tick = chunk.first_tick + chunk.tick_count
        if not is_next:
            self.interrupt()
        if self._screen is None:
            self._screen = SampleScreen(chunk.sensor_count, chunk.time_step_s)
        self._screen.screened(chunk)
        lost = self._screen.lost_field
        for s, sensor in enumerate(self._sensors):
            sensor.add_freezes(None if lost is None else lost[s], chunk.time_step_s)
            field = None if chunk.magnetometer_t is None else chunk.magnetometer_t[s]
            sensor.add(
                chunk.gyroscope_radps[s],
                chunk.accelerometer_mps2[s],
                field,
                chunk.time_step_s,
                (chunk.quality[s] & SampleQuality.BRIDGED) != 0,
            )
            sensor.is_marked_clipped |= bool((chunk.quality[s] & SampleQuality.SATURATED).any())

    def interrupt(self) -> None:
        """Forget what only a stretch that follows at once goes on from: it does not come."""
        self._screen = None
        for sensor in self._sensors:
            sensor.joined.forget()
            sensor.freeze_s = 0.0

    def forget(self, name: str) -> None:
        """Begin again with one sensor: another device may have come in its place."""
        for s, sensor in enumerate(self._sensors):
            if sensor.name == name:
                self._sensors[s] = Readings(name)
                if self._screen is not None:
                    self._screen.memory[s] = 0.0

    @property
    def clip_levels(self) -> Float:
        """From which on samples are cut off, as far as values piled up, infinite where none did.

        Shape (S, 2, 2, 3): gyroscope (rad/s) and accelerometer (m/s^2), positive and negative side, axis. A larger
        value later shows that a level was none.
        """
        return np.array([(known.rate_clips.levels, known.force_clips.levels) for known in self._sensors])

    @property
    def corrections(self) -> dict[str, Correction]:
        """By name: what takes the errors of an accelerometer off that the movement shows, and what that leaves unknown.

        Only of sensors of which nothing else is in doubt.
        """
        found = {}
        for sensor in self._sensors:
            doubts = {one.code for one in Verdict(sensor).findings(self._hemisphere)}
            errors = sensor.force.errors
            if errors is None or not is_found(errors) or not doubts <= BESIDE_CORRECTION:
                continue
            refined = sensor.force.refined
            if refined is not None:
                found[sensor.name] = correction(sensor.name, refined, sensor.dip_rad)
        return found

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was found; what the movement does not say is not claimed."""
        return tuple(
            found for sensor in self._sensors for found in Verdict(sensor).findings(self._hemisphere)
        )


def check_recording(
    chunk: ImuChunk, names: Sequence[str], *, hemisphere: Hemisphere = "north"
) -> tuple[Finding, ...]:
    """Look for wrong units, axes, signs, and dead channels in a whole recording.

    Parameters
    ----------
    chunk : ImuChunk
        As declared (rad/s, m/s^2, T).
    names : sequence of str, length S

    Raises
    ------
    ShapeError
        If there are not as many names as sensors.
    """
    check = RecordingCheck(names, hemisphere, corrects=True)
    parts = max(1, round(chunk.tick_count * chunk.time_step_s / STRETCH_S))
    bounds = [round(chunk.tick_count * part / parts) for part in range(parts + 1)]
    for first, stop in pairwise(bounds):
        check.add(chunk.ticks(first, stop))
    return check.findings
