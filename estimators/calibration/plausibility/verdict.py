"""Verdict on one sensor's readings: units, axes, signs, dead channels, and what only does not fit."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.force.verdict import is_uncalibrated
from estimators.calibration.plausibility.explanation import Explanation, explain
from estimators.calibration.plausibility.finding import Finding, FindingCode, Hemisphere, Severity
from estimators.calibration.plausibility.readings import Readings
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float
from estimators.sentences import Sentence, say

_GRAVITY_NEAR, _GRAVITY_SURE = 1.15, 2.5
"""How far calm specific force may be from gravity before it is a doubt, and from when on it is no gravity."""
_FORCE_UNITS: Final = (
    (0.0, 0.6, say("readings.force_without_gravity")),
    (0.9, 1.1, say("readings.force_in_g")),
    (29.0, 35.0, say("readings.force_in_feet")),
    (900.0, 1100.0, say("readings.force_in_milli_g")),
    (1850.0, 40000.0, say("readings.force_in_counts")),
)
_REST_RATE_RADPS: Final = math.radians(15.0)
_FASTEST_RADPS: Final = 70.0
_SHAKEN_MPS2: Final = 3.0
_LEAST_TURNING: Final = 0.04
"""A limb that is shaken turns: on sound recordings the fastest hundredth of turning over that of what is added to
gravity is 0.12 to 2.5 rad/s for each m/s^2."""
_SILENT_RADPS: Final = 0.05
_OFFSET_RADPS: Final = 0.1
"""Gyroscopes have offsets up to half of this on an axis; less than this between two readings of the axes may be one."""
_FIELD_RANGE_T: Final = (20e-6, 75e-6)
_FIELD_SURE_T: Final = (2e-6, 1e-3)
_FIELD_UNITS: Final = (
    (20.0, 75.0, say("readings.field_in_microtesla")),
    (0.2, 0.75, say("readings.field_in_gauss")),
    (0.85, 1.15, say("readings.field_normalised")),
    (200.0, 750.0, say("readings.field_in_milligauss")),
    (20_000.0, 75_000.0, say("readings.field_in_nanotesla")),
)
_FIELD_DOUBT_T: Final = (10e-6, 150e-6)
_DISTURBED: Final = 0.15
_LEAST_DIP_SINE: Final = 0.3
BESIDE_CORRECTION: Final = {
    "accelerometer_uncalibrated",
    "magnetic_disturbance",
    "magnetometer_frozen",
    "gravity_reversed",
}
"""What may be found of a sensor whose accelerometer is corrected all the same."""
_FROZEN_S: Final = 1.0
"""A compass that repeats itself for so long in movement is worth a word; shorter ones are flagged where they are."""


class Verdict:
    """What is said of the readings of one sensor."""

    def __init__(self, readings: Readings) -> None:
        self.readings, self.name = readings, readings.name
        self.found: list[Finding] = []

    def findings(self, hemisphere: Hemisphere) -> list[Finding]:
        """Return what is wrong so far."""
        share = self.readings.sound_ticks / max(self.readings.ticks, 1)
        if share < 0.2 or share * self.readings.time_s < 0.3:
            self._tell("no_data", say("readings.no_data", where=[self.name]), share)
            return self.found
        is_force_alive = self._force()
        is_rate_alive = self._rate_channels()
        is_field_alive = self._field()
        self._clips()
        readings = self.readings
        explanation = explain(readings.evidence, readings.fastest_radps)
        if is_rate_alive:
            self._unit_of_rate(explanation)
            is_of_axes = explanation is not None and explanation.scale == explanation.pace == 1.0
            if is_force_alive and explanation is not None and is_of_axes and self._decides(explanation):
                self._axes(explanation, hemisphere if is_field_alive else "unknown")
            # Turns that are cut off look like a pace, and are said by themselves.
            is_said = explanation is not None and explanation.is_brief and self._is_cut_off()
            if explanation is not None and explanation.is_amiss and not is_said:
                self._unexplained(explanation)
        if is_force_alive and is_field_alive and hemisphere != "unknown":
            self._sign(hemisphere)
        if {found.code for found in self.found} <= BESIDE_CORRECTION:
            self._calibration()
        return self.found

    def _tell(
        self, code: FindingCode, message: Sentence, value: float, severity: Severity = "refuse"
    ) -> None:
        self.found.append(Finding(self.name, code, severity, message, float(value)))

    def _is_constant(self, triad: str) -> NDArray[np.bool_]:
        """Return which axes have never changed; none while hardly anything came."""
        if self.readings.sound_ticks < 20 or triad not in self.readings.changing:
            return np.zeros(3, dtype=np.bool_)
        return ~self.readings.changing[triad]

    def _force(self) -> bool:
        where = [self.name]
        if self._is_constant("accelerometer").all():
            self._tell("accelerometer_dead", say("readings.accelerometer_dead", where=where), 0.0)
            return False
        # Where nothing lies still the calmest moments are taken: they tell another unit, not some per cent.
        seen, is_at_rest = self.readings.resting_mps2, bool(self.readings.resting_mps2)
        seen = seen if is_at_rest else self.readings.calm
        size = float(seen.median()[0]) if seen else GRAVITY_MPS2
        factor = max(size, 1e-300) / GRAVITY_MPS2
        factor = max(factor, 1.0 / factor)
        if factor <= _GRAVITY_NEAR or (factor <= _GRAVITY_SURE and not is_at_rest):
            return True
        errors = self.readings.force.errors
        if factor <= _GRAVITY_SURE and errors is not None and is_uncalibrated(errors):
            # What explains it is said instead.
            return True
        remedies = [remedy for low, high, remedy in _FORCE_UNITS if low <= size <= high]
        off = say("readings.force_unknown") if factor > _GRAVITY_SURE else say("readings.force_off")
        remedy = remedies[0] if remedies else off
        self._tell(
            "accelerometer_unit",
            say("readings.accelerometer_unit", where=where, value=size, remedy=remedy),
            size,
            "refuse" if factor > _GRAVITY_SURE else "warning",
        )
        return not (size < 0.6 and remedies)

    def _rate_channels(self) -> bool:
        dead = [
            axis for axis, constant in zip("xyz", self._is_constant("gyroscope"), strict=True) if constant
        ]
        if dead:
            message = say("readings.gyroscope_dead", where=[self.name], axes=dead, count=len(dead))
            self._tell("gyroscope_dead", message, float(len(dead)))
        return not dead

    def _clips(self) -> None:
        """Warn of what is cut off: it costs precision, which the estimate's uncertainty says."""
        where = [self.name]
        if (level := self.readings.force_clips.level) is not None:
            message = say("readings.accelerometer_clipped", where=where, level_mps2=level)
            self._tell("accelerometer_clipped", message, level, "warning")
        level = self.readings.rate_clips.level
        # A mark does not say of which triad it is: with a level of the other it may be that one's.
        if level is None and self.readings.force_clips.level is None and self.readings.is_marked_clipped:
            level = self.readings.rate_clips.largest
        if level is not None:
            message = say("readings.gyroscope_clipped", where=where, level_radps=level)
            self._tell("gyroscope_clipped", message, level, "warning")

    def _unit_of_rate(self, explanation: Explanation | None) -> None:
        where, fastest = [self.name], self.readings.fastest_radps
        shaken = self.readings.shaken_mps2
        scale = 1.0 if explanation is None else explanation.scale
        is_certain = explanation is not None and explanation.is_certain
        fits = explanation is not None and explanation.fits and explanation.is_clear
        if explanation is not None and explanation.pace != 1.0 and not self._is_cut_off():
            severity: Severity = "refuse" if is_certain and fits else "warning"
            self._tell("gyroscope_unit", self._pace_message(explanation.pace), explanation.pace, severity)
        elif scale != 1.0 and fits and (is_certain or fastest >= _SILENT_RADPS):
            self._tell(
                "gyroscope_unit",
                _unit_message(where, 1.0 / scale),
                fastest,
                "refuse" if is_certain else "warning",
            )
        elif fastest < _SILENT_RADPS and self.readings.evidence.windows.any():
            self._tell("gyroscope_dead", say("readings.gyroscope_silent", where=where), fastest)
        elif fastest > _FASTEST_RADPS:
            self._tell("gyroscope_unit", say("readings.gyroscope_in_degrees", where=where), fastest)
        elif shaken > _SHAKEN_MPS2 and fastest < _LEAST_TURNING * shaken:
            message = say("readings.gyroscope_too_calm", where=where, rate_radps=fastest, force_mps2=shaken)
            self._tell("gyroscope_unit", message, fastest, "warning")
        elif self.readings.resting_radps and not self.readings.evidence.windows.any():
            rest, spread = self.readings.resting_radps.median()
            if (rate := float(max(rest, spread))) > _REST_RATE_RADPS:
                # It may be turning about the vertical, or tremble.
                message = say("readings.gyroscope_restless", where=where, rate_radps=rate)
                self._tell("gyroscope_unit", message, rate, "warning")

    def _is_cut_off(self) -> bool:
        """Tell whether turns are missing where the gyroscope stops: then the sensor turns farther than it says."""
        return self.readings.is_marked_clipped or self.readings.rate_clips.level is not None

    def _pace_message(self, pace: float) -> Sentence:
        """Return the sentence about a clock or a range that is wrong; the signals do not tell which."""
        where, said_hz = [self.name], 1.0 / self.readings.step_s
        return say(
            "readings.gyroscope_pace", where=where, factor=pace, said_hz=said_hz, rate_hz=said_hz / pace
        )

    def _unexplained(self, explanation: Explanation) -> None:
        """Say that gyroscope, gravity and field do not fit where nothing on the list explains it."""
        message = say("readings.unexplained", where=[self.name])
        self._tell("unexplained", message, explanation.gain, "warning")

    def _calibration(self) -> None:
        """Warn of an accelerometer with an offset or scale error that tilts everything."""
        errors = self.readings.force.errors
        if errors is None or not is_uncalibrated(errors):
            return
        message = say("readings.accelerometer_uncalibrated", where=[self.name], angle_rad=errors.tilt_rad)
        self._tell("accelerometer_uncalibrated", message, errors.tilt_rad, "warning")

    def _decides(self, explanation: Explanation) -> bool:
        """Tell whether the sensor turned about the axes that would be exchanged by more than an offset does.

        A limb that swings about one axis of its sensor leaves on the other two little but the offset of the gyroscope,
        and its axes are not quite square: exchanging these two only turns its errors, and may fit better by chance.
        """
        proper = explanation.mapping
        if "gyroscope" not in explanation.triads:
            # Of these only the turn shows, whatever the sign of all axes.
            proper = proper * np.sign(np.linalg.det(proper))
        return self.readings.moved(proper) > _OFFSET_RADPS**2

    def _axes(self, explanation: Explanation, hemisphere: Hemisphere) -> None:
        triads, mapping, where = explanation.triads, explanation.mapping, [self.name]
        seen_force, seen_field = (self.readings.evidence.windows > 0).tolist()
        severity: Severity = "refuse" if explanation.is_certain else "warning"
        if triads in ({"accelerometer"}, {"magnetometer"}):
            mapping = self._signed(mapping, next(iter(triads)), hemisphere)
        axes = _mapping(mapping)
        code: FindingCode = "gyroscope_axes"
        if triads == {"gyroscope"} and seen_force and seen_field:
            message = say("readings.gyroscope_against_others", where=where, mapping=axes)
        elif triads == {"gyroscope"} and seen_force:
            message = say("readings.gyroscope_against_accelerometer", where=where, mapping=axes)
        elif triads == {"gyroscope"}:
            message = say("readings.gyroscope_against_magnetometer", where=where, mapping=axes)
        elif triads == {"accelerometer"}:
            code = "accelerometer_axes"
            message = say("readings.accelerometer_against_others", where=where, mapping=axes)
        elif triads == {"magnetometer"}:
            code = "magnetometer_axes"
            message = say("readings.magnetometer_against_gyroscope", where=where, mapping=axes)
        elif "magnetometer" in triads:
            code = "gyroscope_or_magnetometer_axes"
            message = say("readings.field_axes_apart", where=where, mapping=axes)
        else:
            code = "gyroscope_or_accelerometer_axes"
            message = say("readings.axes_apart", where=where, mapping=axes)
        if not explanation.fits:
            return
        # Which triad, and how its axes would be right, is reported where the readings then fit clearly better.
        if not explanation.is_certain:
            message = (
                say("readings.axes_in_doubt", where=where)
                if seen_field
                else say("readings.axes_in_doubt_six", where=where)
            )
        elif not explanation.is_clear:
            message = say("readings.axes_unclear", where=where)
        self._tell(code, message, explanation.gain, severity)

    def _signed(self, mapping: Float, triad: str, hemisphere: Hemisphere) -> Float:
        """Return the mapping or its negative: that with which the field points down, else that of fewer changes."""
        product = self.readings.still_product
        if product is not None and hemisphere != "unknown":
            product = mapping @ product if triad == "accelerometer" else product @ mapping.T
            down = -float(np.trace(product)) * (1.0 if hemisphere == "north" else -1.0)
            if abs(down) > _LEAST_DIP_SINE:
                return mapping if down > 0.0 else -mapping
        return mapping if np.trace(mapping) >= 0.0 else -mapping

    def _field(self) -> bool:
        if not self.readings.field_t:
            return False
        where, middle = [self.name], float(self.readings.field_t.median()[0])
        if middle == 0.0 or self._is_constant("magnetometer").all():
            message = (
                say("readings.magnetometer_constant", where=where)
                if middle
                else say("readings.magnetometer_zero", where=where)
            )
            self._tell("magnetometer_dead", message, middle)
            return False
        if (lasts_s := self.readings.longest_freeze_s) > _FROZEN_S:
            message = say("readings.magnetometer_frozen", where=where, lasts_s=lasts_s)
            self._tell("magnetometer_frozen", message, lasts_s, "warning")
        if _FIELD_RANGE_T[0] <= middle <= _FIELD_RANGE_T[1]:
            if (share := float(self.readings.field_spread.median()[0])) > _DISTURBED:
                message = say("readings.field_varies", where=where, share=share)
                self._tell("magnetic_disturbance", message, share, "warning")
            return True
        for low, high, remedy in _FIELD_UNITS:
            if low <= middle <= high:
                message = say("readings.magnetometer_unit", where=where, value=middle, remedy=remedy)
                self._tell("magnetometer_unit", message, middle)
                return True
        is_sure = not _FIELD_SURE_T[0] < middle < _FIELD_SURE_T[1]
        is_doubt = not _FIELD_DOUBT_T[0] < middle < _FIELD_DOUBT_T[1]
        self._tell(
            "magnetometer_unit" if is_doubt else "magnetic_disturbance",
            say("readings.field_off", where=where, field_t=middle),
            middle,
            "refuse" if is_sure else "warning",
        )
        return True

    def _sign(self, hemisphere: Hemisphere) -> None:
        if any(f.code.endswith("_axes") or f.code == "gyroscope_unit" for f in self.found):
            return
        down, is_certain = self.readings.dip_sine()
        if hemisphere == "south":
            down = -down
        if down < -_LEAST_DIP_SINE:
            angle_rad = -math.asin(max(down, -1.0))
            message = (
                say("readings.field_up", where=[self.name], angle_rad=angle_rad)
                if hemisphere == "north"
                else say("readings.field_down", where=[self.name], angle_rad=angle_rad)
            )
            self._tell("gravity_reversed", message, down, "refuse" if is_certain else "warning")


def _unit_message(where: list[str], factor: float) -> Sentence:
    """Return the sentence about a gyroscope that reads `factor` times what the sensor turns."""
    if math.isclose(factor, 180.0 / math.pi, rel_tol=0.01):
        return say("readings.gyroscope_in_degrees", where=where)
    if math.isclose(factor, math.pi / 180.0, rel_tol=0.01):
        return say("readings.gyroscope_twice", where=where)
    return say("readings.gyroscope_scale", where=where, factor=factor)


def _mapping(mapping: Float) -> list[str]:
    """Return for each axis that is wrong what it should be: `x → -y`."""
    return [
        f"{axis} → {'-' if mapping[k].sum() < 0 else ''}{'xyz'[int(np.argmax(np.abs(mapping[k])))]}"
        for k, axis in enumerate("xyz")
        if mapping[k, k] != 1.0
    ]
