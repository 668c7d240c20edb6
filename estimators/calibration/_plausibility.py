"""The first seconds of a session: units, axes, signs, dead and clipped channels, named to the person."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from estimators.calibration._axes import Agreement, agreement
from estimators.calibration._clipping import find_plateau
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ShapeError
from estimators.recording import Float, ImuChunk, SampleQuality
from estimators.sentences import Sentence, say

Hemisphere = Literal["north", "south", "unknown"]
"""Of the place: the magnetic field points down in the north and up in the south."""
FindingCode = Literal[
    "accelerometer_axes",
    "accelerometer_clipped",
    "accelerometer_dead",
    "accelerometer_unit",
    "gravity_reversed",
    "gyroscope_axes",
    "gyroscope_clipped",
    "gyroscope_dead",
    "gyroscope_or_accelerometer_axes",
    "gyroscope_unit",
    "magnetic_disturbance",
    "magnetometer_axes",
    "magnetometer_dead",
    "magnetometer_unit",
    "no_data",
]

_STILL_WINDOW_S: Final = 0.5
_STILL_SPREAD: Final = 0.02
_GRAVITY_RANGE: Final = (0.9 * GRAVITY_MPS2, 1.1 * GRAVITY_MPS2)
_FORCE_UNITS: Final = (
    (0.0, 0.6, say("readings.force_without_gravity")),
    (0.9, 1.1, say("readings.force_in_g")),
    (29.0, 35.0, say("readings.force_in_feet")),
    (900.0, 1100.0, say("readings.force_in_milli_g")),
    (1850.0, 40000.0, say("readings.force_in_counts")),
)
_REST_RATE_RADPS: Final = math.radians(15.0)
_FASTEST_RADPS: Final = 70.0
_SMALLEST_RATE_RANGE_RADPS: Final = math.radians(30.0)
_SMALLEST_FORCE_RANGE_MPS2: Final = 1.5 * GRAVITY_MPS2
_FIELD_RANGE_T: Final = (20e-6, 75e-6)
_FIELD_UNITS: Final = (
    (20.0, 75.0, say("readings.field_in_microtesla")),
    (0.2, 0.75, say("readings.field_in_gauss")),
    (0.85, 1.15, say("readings.field_normalised")),
    (200.0, 750.0, say("readings.field_in_milligauss")),
    (20_000.0, 75_000.0, say("readings.field_in_nanotesla")),
)
_DISTURBED: Final = 0.15
_LEAST_DIP_SINE: Final = 0.3


@dataclass(frozen=True)
class Finding:
    """Something about the readings of one sensor that must not be estimated silently.

    Attributes
    ----------
    sensor : str
        Its name.
    code : str
        One of `FindingCode`, for programs.
    severity : {"refuse", "warning"}
        `refuse`: the estimate would be wrong; `warning`: it will be worse.
    message : Sentence
        What is wrong and what to do, for people; its parameter `where` names the sensor.
    value : float
        What was measured, in the unit that the message names.
    """

    sensor: str
    code: FindingCode
    severity: Literal["refuse", "warning"]
    message: Sentence
    value: float

    @property
    def subject(self) -> tuple[str, str]:
        """What it is about: another stretch may blame another triad of the sensor for the same mix of axes."""
        return self.sensor, "axes" if self.code.endswith("_axes") else self.code


def check_plausibility(
    chunk: ImuChunk,
    names: Sequence[str],
    *,
    hemisphere: Hemisphere = "north",
) -> tuple[Finding, ...]:
    """Look for wrong units, axes, signs, dead and clipped channels in the first seconds.

    Parameters
    ----------
    chunk : ImuChunk
        A few seconds, as declared (rad/s, m/s^2, T); stillness tells units, movement (ten seconds at most are
        used) tells axes and the unit of the gyroscope.
    names : sequence of str, length S
        What to call the sensors.
    hemisphere : {"north", "south", "unknown"}
        Of the place: the field points down in the north and up in the south.

    Returns
    -------
    tuple of Finding
        Empty if nothing was found; what the movement does not tell is not claimed.

    Raises
    ------
    ShapeError
        If there are not as many names as sensors.
    """
    if len(names) != chunk.sensor_count:
        raise ShapeError(f"{len(names)} names for {chunk.sensor_count} sensors")
    found: list[Finding] = []
    for s, name in enumerate(names):
        found += _Sensor(chunk, s, name).findings(hemisphere)
    return tuple(found)


class _Sensor:
    """One sensor's readings and what was found about them."""

    def __init__(self, chunk: ImuChunk, sensor: int, name: str) -> None:
        self.name, self.where = name, [name]
        self.step_s = chunk.time_step_s
        self.rate = chunk.gyroscope_radps[sensor]
        self.force = chunk.accelerometer_mps2[sensor]
        field = None if chunk.magnetometer_t is None else chunk.magnetometer_t[sensor]
        self.field = None if field is None or not np.isfinite(field).any() else field
        self.is_marked_clipped = bool(((chunk.quality[sensor] & SampleQuality.SATURATED) != 0).any())
        self.found: list[Finding] = []

    def tell(
        self,
        code: FindingCode,
        message: Sentence,
        value: float,
        severity: Literal["refuse", "warning"] = "refuse",
    ) -> None:
        self.found.append(Finding(self.name, code, severity, message, float(value)))

    def findings(self, hemisphere: str) -> list[Finding]:
        finite = np.isfinite(self.rate).all(axis=1) & np.isfinite(self.force).all(axis=1)
        if finite.mean() < 0.2 or finite.sum() * self.step_s < 0.3:
            self.tell("no_data", say("readings.no_data", where=self.where), float(finite.mean()))
            return self.found
        still = _still(self.force, self.step_s)
        is_force_alive = self._force(still)
        is_rate_alive = self._rate(still)
        is_field_alive = self._field()
        bias = np.zeros(3)
        if still.sum() * self.step_s >= _STILL_WINDOW_S:
            bias = np.nanmean(self.rate[still], axis=0)
        rate = self.rate - bias
        by_force = agreement(rate, self.force, self.step_s) if is_force_alive else None
        by_field = None
        # A field that changes with the place, or a magnet's own, says nothing about how the sensor turned.
        is_field_steady = all(f.code != "magnetic_disturbance" for f in self.found)
        if is_field_alive and is_field_steady and self.field is not None:
            by_field = agreement(rate, self.field, self.step_s)
        if is_rate_alive:
            self._unit_of_rate(by_force, by_field)
            self._axes(by_force, by_field)
        if is_force_alive and is_field_alive and hemisphere != "unknown":
            self._sign(still, hemisphere)
        return self.found

    def _force(self, still: NDArray[np.bool_]) -> bool:
        if _is_constant(self.force):
            self.tell("accelerometer_dead", say("readings.accelerometer_dead", where=self.where), 0.0)
            return False
        used = self.force[still] if still.any() else self.force
        size = float(np.nanmedian(np.linalg.norm(used, axis=1)))
        clip = find_plateau(self.force, _SMALLEST_FORCE_RANGE_MPS2)
        if clip is not None:
            self.tell(
                "accelerometer_clipped",
                say("readings.accelerometer_clipped", where=self.where, level_mps2=clip),
                clip,
                "warning",
            )
        if _GRAVITY_RANGE[0] <= size <= _GRAVITY_RANGE[1] or (
            not still.any() and 0.5 < size / GRAVITY_MPS2 < 2.0
        ):
            return True
        for low, high, remedy in _FORCE_UNITS:
            if low <= size <= high:
                self.tell(
                    "accelerometer_unit",
                    say("readings.accelerometer_unit", where=self.where, value=size, remedy=remedy),
                    size,
                )
                return size > 0.6
        remedy = say("readings.force_unknown")
        self.tell(
            "accelerometer_unit",
            say("readings.accelerometer_unit", where=self.where, value=size, remedy=remedy),
            size,
        )
        return True

    def _rate(self, still: NDArray[np.bool_]) -> bool:
        dead = [axis for k, axis in enumerate("xyz") if _is_constant(self.rate[:, k : k + 1])]
        if dead:
            self.tell(
                "gyroscope_dead",
                say("readings.gyroscope_dead", where=self.where, axes=dead, count=len(dead)),
                float(len(dead)),
            )
        clip = find_plateau(self.rate, _SMALLEST_RATE_RANGE_RADPS)
        if clip is not None or self.is_marked_clipped:
            level = float(np.nanmax(np.abs(self.rate))) if clip is None else clip
            self.tell(
                "gyroscope_clipped",
                say("readings.gyroscope_clipped", where=self.where, level_radps=level),
                level,
            )
        return not dead

    def _unit_of_rate(self, by_force: Agreement | None, by_field: Agreement | None) -> None:
        told = [a for a in (by_field, by_force) if a is not None and a.mapping is not None]
        fastest = float(np.nanmax(np.abs(self.rate)))
        scale = told[0].scale if told else float("nan")
        if scale == 0.0:
            self.tell("gyroscope_dead", say("readings.gyroscope_silent", where=self.where), 0.0)
        elif scale < 0.5 or (math.isnan(scale) and fastest > _FASTEST_RADPS):
            self.tell(
                "gyroscope_unit",
                say("readings.gyroscope_in_degrees", where=self.where),
                fastest,
            )
        elif scale > 2.0:
            self.tell(
                "gyroscope_unit",
                say("readings.gyroscope_twice", where=self.where),
                fastest,
            )
        elif math.isnan(scale):
            still = _still(self.force, self.step_s)
            if still.sum() * self.step_s >= _STILL_WINDOW_S:
                rest = float(np.linalg.norm(np.nanmedian(self.rate[still], axis=0)))
                spread = float(np.linalg.norm(np.nanstd(self.rate[still], axis=0)))
                if max(rest, spread) > _REST_RATE_RADPS:
                    self.tell(
                        "gyroscope_unit",
                        say(
                            "readings.gyroscope_restless",
                            where=self.where,
                            rate_radps=max(rest, spread),
                        ),
                        max(rest, spread),
                        # A trembling hand may look still to the accelerometer.
                        "refuse" if rest > _REST_RATE_RADPS else "warning",
                    )

    def _axes(self, by_force: Agreement | None, by_field: Agreement | None) -> None:
        force = None if by_force is None else by_force.mapping
        field = None if by_field is None else by_field.mapping
        wrong_force = force is not None and not _is_identity(force)
        wrong_field = field is not None and not _is_identity(field)
        if wrong_force and wrong_field and force is not None and field is not None and (force == field).all():
            self.tell(
                "gyroscope_axes",
                say("readings.gyroscope_against_others", where=self.where, mapping=_mapping(force)),
                0.0,
            )
        elif wrong_force and force is not None:
            if field is not None and not wrong_field:
                self.tell(
                    "accelerometer_axes",
                    say("readings.accelerometer_against_others", where=self.where, mapping=_mapping(force.T)),
                    0.0,
                )
            elif np.linalg.det(force) < 0.0:
                # Whatever is done to an accelerometer's axes looks like a proper turn from the gyroscope.
                self.tell(
                    "gyroscope_axes",
                    say(
                        "readings.gyroscope_against_accelerometer", where=self.where, mapping=_mapping(force)
                    ),
                    0.0,
                )
            else:
                self.tell(
                    "gyroscope_or_accelerometer_axes",
                    say("readings.axes_apart", where=self.where, mapping=_mapping(force)),
                    0.0,
                )
        elif wrong_field and field is not None:
            if force is None and np.linalg.det(field) < 0.0:
                self.tell(
                    "gyroscope_axes",
                    say("readings.gyroscope_against_magnetometer", where=self.where, mapping=_mapping(field)),
                    0.0,
                )
            else:
                self.tell(
                    "magnetometer_axes",
                    say(
                        "readings.magnetometer_against_gyroscope", where=self.where, mapping=_mapping(field.T)
                    ),
                    0.0,
                )

    def _field(self) -> bool:
        if self.field is None:
            return False
        size = np.linalg.norm(self.field[np.isfinite(self.field).all(axis=1)], axis=1)
        if not size.any() or _is_constant(self.field):
            self.tell(
                "magnetometer_dead",
                say("readings.magnetometer_constant", where=self.where)
                if size.any()
                else say("readings.magnetometer_zero", where=self.where),
                float(size.mean()),
                "refuse",
            )
            return False
        middle = float(np.median(size))
        if not _FIELD_RANGE_T[0] <= middle <= _FIELD_RANGE_T[1]:
            for low, high, remedy in _FIELD_UNITS:
                if low <= middle <= high:
                    self.tell(
                        "magnetometer_unit",
                        say("readings.magnetometer_unit", where=self.where, value=middle, remedy=remedy),
                        middle,
                    )
                    return True
            severity: Literal["refuse", "warning"] = "warning" if 5e-6 < middle < 1e-3 else "refuse"
            self.tell(
                "magnetometer_unit" if severity == "refuse" else "magnetic_disturbance",
                say("readings.field_off", where=self.where, field_t=middle),
                middle,
                severity,
            )
        elif (share := float(np.std(size)) / middle) > _DISTURBED:
            told = say("readings.field_varies", where=self.where, share=share)
            self.tell("magnetic_disturbance", told, share, "warning")
        return True

    def _sign(self, still: NDArray[np.bool_], hemisphere: str) -> None:
        if self.field is None:
            return
        used = still & np.isfinite(self.field).all(axis=1)
        if used.sum() < 10 or any(f.code in ("accelerometer_axes", "magnetometer_axes") for f in self.found):
            return
        force, field = self.force[used].mean(axis=0), self.field[used].mean(axis=0)
        down = -float(force @ field) / float(np.linalg.norm(force) * np.linalg.norm(field))
        if hemisphere == "south":
            down = -down
        if down < -_LEAST_DIP_SINE:
            angle_rad = -math.asin(max(down, -1.0))
            self.tell(
                "gravity_reversed",
                say("readings.field_up", where=self.where, angle_rad=angle_rad)
                if hemisphere == "north"
                else say("readings.field_down", where=self.where, angle_rad=angle_rad),
                down,
            )


def _mapping(mapping: Float) -> list[str]:
    """Return for each axis that is wrong what it should be: `x → -y`."""
    return [
        f"{axis} → {'-' if mapping[k].sum() < 0 else ''}{'xyz'[int(np.argmax(np.abs(mapping[k])))]}"
        for k, axis in enumerate("xyz")
        if mapping[k, k] != 1.0
    ]


def _is_identity(mapping: Float) -> bool:
    return bool((mapping == np.eye(3)).all())


def _is_constant(values: Float) -> bool:
    finite = values[np.asarray(np.isfinite(values)).all(axis=1)]
    return len(finite) >= 20 and bool((finite == finite[0]).all())


def _still(force: Float, step_s: float) -> NDArray[np.bool_]:
    """Return where specific force hardly varies, whatever its unit, shape (N,)."""
    half = max(1, round(0.5 * _STILL_WINDOW_S / step_s))
    finite: NDArray[np.bool_] = np.asarray(np.isfinite(force).all(axis=1))
    held = np.where(finite[:, None], force, 0.0)
    index = np.arange(len(force))
    start, stop = np.maximum(index - half, 0), np.minimum(index + half + 1, len(force))
    width = (stop - start)[:, None]

    def mean(table: Float) -> Float:
        total = np.concatenate((np.zeros((1, table.shape[1])), np.cumsum(table, axis=0)))
        return np.asarray((total[stop] - total[start]) / width)

    centre = held - held.mean(axis=0)
    variance = np.maximum(mean(centre**2) - mean(centre) ** 2, 0.0).sum(axis=1)
    size = np.linalg.norm(mean(held), axis=1)
    whole = mean(np.asarray(finite[:, None], dtype=np.float64))[:, 0] > 0.999
    # Devices that remove gravity rest at their noise; there the absolute limit counts.
    return np.asarray(whole & (np.sqrt(variance) < np.maximum(_STILL_SPREAD * size, 0.0)))


__all__ = ["Finding", "FindingCode", "Hemisphere", "check_plausibility"]
