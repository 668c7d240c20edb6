"""Six-position calibration: a sensor laid on each of its sides and turned about each of its axes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import signals
from estimators.calibration._contract import UNUSABLE_SCORE
from estimators.calibration._device import DeviceCalibration, TriadCalibration, matrix, vector
from estimators.calibration.field.full_turns import FullTurn, best_turns, judge_turns, refuse_doubted
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import CalibrationError, SetupError, ShapeError
from estimators.recording import Float
from estimators.sentences import say

FACES: Final = ("+x", "-x", "+y", "-y", "+z", "-z")
"""Which axis points up."""
_AXES: Final = "xyz"
_SHORTEST_REST_S = 1.0
_MARGIN_S = 0.4
_SLANT = math.cos(math.radians(25.0))
_TURNING_RADPS = math.radians(12.0)
_PURE_TURN = 0.95
_TURN_TOLERANCE = 0.15
_SQUARE_RAD = math.radians(2.0)
_RESIDUAL_MPS2 = 0.05
_GAIN_LIMIT = 0.25


@dataclass(frozen=True)
class Rest:
    """One stretch `[start, stop)` of samples in which the sensor lay still with `face` up."""

    start: int
    stop: int
    face: str


@dataclass(frozen=True)
class FerrarisResult:
    """What a six-position calibration found.

    Attributes
    ----------
    device : DeviceCalibration
        Accelerometer and gyroscope; no magnetometer.
    rests, turns : tuple
        The stretches that were used.
    residual_mps2 : float
        Root mean square of what bias, scale and cross-axis leave of the positions: 18 readings, 12 unknowns.
    square_error_rad : float
        Largest deviation from a right angle between two accelerometer axes, as seen from the sides it lay on:
        the sensor's own, plus a table that is not level or a case that is not square.
    """

    device: DeviceCalibration
    rests: tuple[Rest, ...]
    turns: tuple[FullTurn, ...]
    residual_mps2: float
    square_error_rad: float
    score: float
    reasons: tuple[str, ...]


def find_positions(
    gyroscope_radps: Float, accelerometer_mps2: Float, rate_hz: float
) -> tuple[tuple[Rest, ...], tuple[FullTurn, ...]]:
    """Find the positions and the turns of a calibration recorded in one go, in any order.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
        Right to some 10 percent: counts must have been scaled by the data sheet.

    Returns
    -------
    rests : tuple of Rest
        Still for a second at least, with one axis within 25 degrees of the vertical.
    turns : tuple of FullTurn
        Between two rests on the same side, about one axis, within 15 percent of whole turns, and without a lost
        sample: what turned meanwhile is not known. `doubted_turns` says which are hardly whole ones.
    """
    _check(gyroscope_radps, accelerometer_mps2, rate_hz)
    sound = np.asarray(np.isfinite(np.hstack((gyroscope_radps, accelerometer_mps2))).all(axis=1))
    if not sound.any():
        return (), ()
    gyroscope_radps = _filled(gyroscope_radps, sound)
    accelerometer_mps2 = _filled(accelerometer_mps2, sound)
    still = signals.stillness(gyroscope_radps, accelerometer_mps2, rate_hz)
    still &= sound
    if not still.any():
        return (), ()
    # A steady turn has no spread: it shows in how far the rate is from what it reads at rest.
    bias = np.median(gyroscope_radps[still], axis=0)
    half = max(1, round(0.1 * rate_hz))
    still &= np.linalg.norm(_moving_mean(gyroscope_radps - bias, half), axis=1) < _TURNING_RADPS
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False])).astype(np.int8)))
    stretches = [
        (int(a), int(b))
        for a, b in zip(edges[::2], edges[1::2], strict=True)
        if b - a >= _SHORTEST_REST_S * rate_hz
    ]
    # A hand that begins to turn slowly still counts as still for a moment: that goes to the turn.
    margins = [min(round(_MARGIN_S * rate_hz), (b - a) // 4) for a, b in stretches]
    rests = [
        Rest(a + margin, b - margin, face)
        for (a, b), margin in zip(stretches, margins, strict=True)
        if (face := _face_up(accelerometer_mps2[a:b])) is not None
    ]
    if not rests:
        return (), ()
    bias = np.mean([gyroscope_radps[r.start : r.stop].mean(axis=0) for r in rests], axis=0)
    turns = []
    for before, after in pairwise(rests):
        if before.face != after.face:
            continue
        a, b = before.stop, after.start
        if not sound[a:b].all():
            continue
        angle = (gyroscope_radps[a:b] - bias).sum(axis=0) / rate_hz
        axis = int(np.argmax(np.abs(angle)))
        count = round(float(angle[axis]) / (2.0 * np.pi))
        total = float(np.linalg.norm(angle))
        if count and abs(angle[axis]) > _PURE_TURN * total:
            error = float(angle[axis]) / (2.0 * np.pi * count) - 1.0
            if abs(error * count) < _TURN_TOLERANCE:
                turns.append(FullTurn(a, b, _AXES[axis], count, error))
    return tuple(rests), tuple(turns)


def _refuse_gaps(
    parts: Sequence[Rest | FullTurn], gyroscope_radps: Float, accelerometer_mps2: Float, rate_hz: float
) -> None:
    for part in parts:
        within = slice(part.start, part.stop)
        if not (np.isfinite(gyroscope_radps[within]).all() and np.isfinite(accelerometer_mps2[within]).all()):
            raise CalibrationError(
                say("six_position.gap", start_s=part.start / rate_hz, stop_s=part.stop / rate_hz)
            )


def _scale_of(turns: Sequence[FullTurn], measured_rad: Sequence[Float]) -> Float:
    """Return the scale of a gyroscope, shape (3, 3), that makes turns of the angles measured for them."""
    angles = np.stack([2.0 * np.pi * turn.turns * _direction(f"+{turn.axis}") for turn in turns])
    return np.linalg.lstsq(angles, np.stack(measured_rad), rcond=None)[0].T.astype(np.float64)


def ferraris(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    rate_hz: float,
    *,
    rests: Sequence[Rest] | None = None,
    turns: Sequence[FullTurn] | None = None,
    gravity_mps2: float = GRAVITY_MPS2,
) -> FerrarisResult:
    """Calibrate accelerometer and gyroscope from six positions and three turns.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
        Of one sensor, right to some 10 percent.
    rests, turns : sequence, optional
        Where they are; found automatically by default.
    gravity_mps2 : float
        At the place.

    Raises
    ------
    CalibrationError
        If a side or a turn is missing, a turn was hardly a whole one, or the score would be below 0.25; says which
        to repeat.
    SetupError
        For a rate that is none.

    Notes
    -----
    Ferraris, Grimaldi and Parvis (1995), Procedure for effortless in-field calibration of three-axial rate
    gyro and accelerometers, Sensors and Materials 7:311. Accelerometer: measured = M g + b, M from the
    differences and b from the sums of opposite positions. Gyroscope: b and its dependence on acceleration from
    the positions, then M from the integral of each turn, which is 2 pi along the axis. The integral is exact
    when the sensor turns about an axis fixed to it, as on a table. The direction of a turn is taken from the
    reading: a gyroscope whose sign is wrong is not found here but by `check_recording`.
    """
    _check(gyroscope_radps, accelerometer_mps2, rate_hz)
    if rests is None or turns is None:
        found_rests, found_turns = find_positions(gyroscope_radps, accelerometer_mps2, rate_hz)
        rests = found_rests if rests is None else rests
        turns = found_turns if turns is None else turns
    _require(rests, turns)
    _refuse_gaps((*rests, *turns), gyroscope_radps, accelerometer_mps2, rate_hz)
    force, rate = (
        np.stack([_mean_on(face, rests, values) for face in FACES])
        for values in (accelerometer_mps2, gyroscope_radps)
    )
    # FACES pairs opposite sides: half the difference is the scale, half the sum the bias. A table that is not
    # level shows in the two axes across, so the bias of an axis comes from the pair along it alone.
    scale = (force[0::2] - force[1::2]).T / (2.0 * gravity_mps2)
    bias = np.diag(0.5 * (force[0::2] + force[1::2]))
    up = np.stack([_direction(face) for face in FACES])
    residual = float(np.sqrt(np.mean((force - gravity_mps2 * up @ scale.T - bias) ** 2)))
    accelerometer = TriadCalibration(matrix(_inverse(scale, "accelerometer")), vector(bias))
    per_force = (rate[0::2] - rate[1::2]).T / (2.0 * gravity_mps2)
    rate_bias = rate.mean(axis=0)
    measured: dict[FullTurn, Float] = {}
    for turn in turns:
        within = slice(turn.start, turn.stop)
        rest_rate = rate_bias + accelerometer.apply(accelerometer_mps2[within]) @ per_force.T
        angle = (gyroscope_radps[within] - rest_rate).sum(axis=0) / rate_hz
        error = float(angle[_AXES.index(turn.axis)]) / (2.0 * np.pi * turn.turns) - 1.0
        measured[replace(turn, error=error)] = angle
    turns = best_turns(tuple(measured))
    refuse_doubted(turns)
    rate_scale = _scale_of(turns, [measured[turn] for turn in turns])
    gyroscope = TriadCalibration(
        matrix(_inverse(rate_scale, "gyroscope")), vector(rate_bias), matrix(per_force)
    )
    columns = scale / np.linalg.norm(scale, axis=0)
    cosines = columns.T @ columns - np.eye(3)
    square_error = float(np.arcsin(np.clip(np.abs(cosines).max(), 0.0, 1.0)))
    score, reasons = _judge(residual, square_error, turns)
    return FerrarisResult(
        DeviceCalibration(accelerometer, gyroscope),
        tuple(rests),
        tuple(turns),
        residual,
        square_error,
        score,
        reasons,
    )


def _check(gyroscope_radps: Float, accelerometer_mps2: Float, rate_hz: float) -> None:
    shape = gyroscope_radps.shape
    if len(shape) != 2 or shape[1] != 3 or accelerometer_mps2.shape != shape:
        raise ShapeError(f"gyroscope {shape} and accelerometer {accelerometer_mps2.shape} must be (N, 3)")
    if not 0.0 < rate_hz < math.inf:
        raise SetupError(f"the rate is {rate_hz} Hz; give the samples a second")


def _filled(values: Float, sound: NDArray[np.bool_]) -> Float:
    """Draw lines across lost samples, so that filters pass; what lies there is not used."""
    index = np.arange(len(values))
    return np.stack([np.interp(index, index[sound], column[sound]) for column in values.T], axis=1)


def _moving_mean(values: Float, half: int) -> Float:
    total = np.concatenate((np.zeros((1, 3)), np.cumsum(np.nan_to_num(values), axis=0)))
    index = np.arange(len(values))
    start, stop = np.maximum(index - half, 0), np.minimum(index + half + 1, len(values))
    return np.asarray((total[stop] - total[start]) / (stop - start)[:, None])


def _face_up(force: Float) -> str | None:
    mean = force.mean(axis=0)
    axis = int(np.argmax(np.abs(mean)))
    if abs(mean[axis]) < _SLANT * np.linalg.norm(mean):
        return None
    return ("+" if mean[axis] > 0 else "-") + _AXES[axis]


def _direction(face: str) -> Float:
    if len(face) != 2 or face not in FACES:
        raise SetupError(f"no side is called {face!r}; known are {', '.join(FACES)}")
    up = np.zeros(3)
    up[_AXES.index(face[1])] = 1.0 if face[0] == "+" else -1.0
    return up


def _require(rests: Sequence[Rest], turns: Sequence[FullTurn]) -> None:
    """Name what is missing in words that say what to do."""
    held = {rest.face for rest in rests}
    missing = [face for face in FACES if face not in held]
    turned = {turn.axis for turn in turns}
    unturned = [axis for axis in _AXES if axis not in turned]
    wanted = []
    if missing:
        wanted.append(say("six_position.rest_missing", faces=missing))
    if unturned:
        wanted.append(say("six_position.turn_missing", axes=unturned))
    if wanted:
        raise CalibrationError(
            say("six_position.incomplete", wanted=wanted),
            redo=[f"face_{face[1]}_{'up' if face[0] == '+' else 'down'}" for face in missing]
            + [f"turn_{axis}" for axis in unturned],
        )


def _mean_on(face: str, rests: Sequence[Rest], values: Float) -> Float:
    """Return what was read, shape (3,), with this side up: the mean over its rests."""
    return np.asarray(
        np.mean([values[r.start : r.stop].mean(axis=0) for r in rests if r.face == face], axis=0)
    )


def _inverse(scale: Float, name: str) -> Float:
    correction = np.abs(scale - np.eye(3)).max()
    if correction > _GAIN_LIMIT:
        raise CalibrationError(say("six_position.correction", triad=name, correction=correction))
    return np.asarray(np.linalg.inv(scale))


def _judge(residual: float, square_error: float, turns: Sequence[FullTurn]) -> tuple[float, tuple[str, ...]]:
    score, reasons = 1.0, []
    if residual > _RESIDUAL_MPS2:
        score = _RESIDUAL_MPS2 / residual
        reasons.append(say("six_position.contradict", residual_mps2=residual))
    if square_error > _SQUARE_RAD:
        score = min(score, _SQUARE_RAD / square_error)
        reasons.append(say("six_position.not_square", angle_rad=square_error))
    factor, doubts = judge_turns(turns)
    score = min(score, factor)
    reasons += doubts
    if score < UNUSABLE_SCORE:
        raise CalibrationError(say("six_position.unusable", reasons=reasons))
    return score, tuple(reasons)
