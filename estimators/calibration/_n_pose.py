"""Sensor-to-segment orientation from standing still with hanging arms."""

import cmath
import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.calibration._contract import UNUSABLE_SCORE, Calibration
from estimators.calibration._device import vector
from estimators.calibration._mounting import FACING_ORDER, N_POSE_TURN_RAD, OUTWARD_HEADING_RAD, PUT_ON_RAD
from estimators.calibration._rest import (
    SWAY_RAD,
    Verdict,
    mean_orientation,
    mostly,
    wrapped,
)
from estimators.calibration._static import UNUSUAL_BIAS_SCORE, StaticBias, static_bias, unusual_bias
from estimators.conventions import GRAVITY_MPS2, Placement
from estimators.errors import CalibrationError, ShapeError
from estimators.orientation import OrientationFlag
from estimators.recording import Float
from estimators.sentences import say

_STEEP_RAD = math.radians(75.0)
_SLANTED_RAD = math.radians(55.0)
_QUIET_RADPS = math.radians(4.0)
_RESTLESS_RADPS = math.radians(25.0)
_NORM_WARNING = 0.03
_NORM_FAULT = 0.15
_DISAGREEMENT_RAD = math.radians(40.0)
_CONCURRING_RAD = math.radians(15.0)
_AGREEMENT = 0.9
_CLOSE_AGREEMENT = 0.97
"""Of two, within 14 degrees of their mean."""
_ARM = ("upper_arm", "forearm", "hand")
_WITNESSES = 3
_SETTLED_RAD = (math.radians(0.7), math.radians(0.7), math.radians(2.3))
"""Tilt and heading of a sensor at rest, where its filter tells no sigma (those of the BROAD set)."""
_ASSUMED_SCORE = 0.85


def n_pose(
    q_earth_sensor: Float,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    placements: Sequence[Placement],
    flags: NDArray[np.uint8] | None = None,
    *,
    time_step_s: float = 0.01,
    facing_rad: float | None = None,
    arms: Literal["hanging", "sideways"] = "hanging",
    sigma_rad: Float | None = None,
    facing_sigma_rad: float | None = None,
) -> Calibration:
    """Find how every sensor sits on its segment from one N-pose, or from one T-pose.

    Parameters
    ----------
    q_earth_sensor : ndarray, shape (S, K, 4)
        Orientations from the running filter during the pose, K at least 1 (need not be every tick).
        NaN where there was none.
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (S, N, 3)
        Samples of the pose.
    placements : sequence of Placement, length S
    flags : ndarray of uint8, shape (S, K), optional
        `OrientationFlag` bits of the orientations; absent means sound and with a shared heading.
    time_step_s : float
        Of the samples.
    facing_rad : float, optional
        Where the patient faces in the earth frame, when movements have shown it; otherwise the mounting rule
        below does.
    arms : {"hanging", "sideways"}
        `sideways`: the T-pose, arms level with palms down. There the arms' own sensors cannot tell where the
        patient faces, so a trunk sensor must, and each of them needs a compass.
    sigma_rad : ndarray, shape (S, M, 3), optional
        One-sigma of the orientations about the earth's axes, as the filter tells it; the last one counts.
    facing_sigma_rad : float, optional
        Of a given `facing_rad`.

    Returns
    -------
    Calibration
        With a score from 0 to 1 and reasons for what is missing to 1.

    Raises
    ------
    CalibrationError
        If the pose cannot be used, with what to redo.

    Notes
    -----
    Inclination comes from gravity: in the N-pose every segment's z axis is vertical. Where the patient
    faces cannot be distinguished from one pose of arbitrarily mounted sensors. Assumed is the mounting rule of
    `OUTWARD_HEADING_RAD` for *one* sensor, the first of `FACING_ORDER` that is worn, shares the common
    heading and whose z axis is not nearly vertical: the sternum's z axis points forward; without it, the
    upper arm's points sideways (of both arms the mean). Other sensors that share the magnetic heading may
    be mounted any way round; those that by the rule say nearly the same (within 15 degrees, fading to 30)
    are averaged with it, because a degree of facing error is about a degree of cross-talk between flexion
    and abduction. Those whose heading is not trusted (no magnetometer) each need the rule:
    `heading_offset_rad` turns their z axis to its expected direction.
    """
    flags = _checked_flags(q_earth_sensor, flags, len(placements))
    bias = static_bias(
        gyroscope_radps, accelerometer_mps2, time_step_s, require_still=False, names=placements
    )
    verdict = Verdict()
    means = [
        mean_orientation(q, bits, p, verdict)
        for q, bits, p in zip(q_earth_sensor, flags, placements, strict=True)
    ]
    q_mean = np.stack(means)
    _judge_samples(bias, accelerometer_mps2, q_mean, placements, verdict)
    _judge_flags(flags, placements, verdict)
    heading_rad, steepness_rad = _outward(q_mean)
    own_heading = mostly(flags, OrientationFlag.HEADING_NOT_TRUSTED)
    reference: Placement | None = None
    raised = np.array([arms == "sideways" and p.startswith(_ARM) for p in placements])
    if (raised & own_heading).any():
        raise CalibrationError(say("calibration.level_arms"))
    if facing_rad is None:
        # A steep sensor shows no facing, and neither does a raised arm's own.
        steepness_rad = np.where(raised, 0.5 * np.pi, steepness_rad)
        facing_rad, reference, facing_sigma_rad = _facing(
            placements, heading_rad, steepness_rad, own_heading, verdict
        )
    settled_rad = _settled(sigma_rad, len(placements))
    offsets = _put_on(placements, own_heading, steepness_rad, heading_rad, facing_rad, verdict)
    if reference is not None:
        _judge_agreement(placements, heading_rad, steepness_rad, own_heading, facing_rad, reference, verdict)
    if verdict.score < UNUSABLE_SCORE:
        raise CalibrationError(say("calibration.pose_unusable", reasons=verdict.reasons))
    q_sensor_segment: dict[Placement, tuple[float, float, float, float]] = {}
    mounting_sigma_rad: dict[Placement, tuple[float, float, float]] = {}
    for s, placement in enumerate(placements):
        posed = _posed(placement, bool(raised[s]))
        q_sensor_segment[placement] = _seat(q_mean[s], offsets.get(placement, 0.0) - facing_rad, posed)
        about_z = PUT_ON_RAD if own_heading[s] else math.hypot(settled_rad[s, 2], facing_sigma_rad or 0.0)
        mounting_sigma_rad[placement] = _in_segment(posed, settled_rad[s], about_z)
    return Calibration(
        q_sensor_segment=q_sensor_segment,
        gyroscope_bias_radps=dict(zip(placements, map(vector, bias.gyroscope_bias_radps), strict=True)),
        facing_rad=facing_rad,
        heading_offset_rad=offsets,
        method="t_pose" if arms == "sideways" else "n_pose",
        score=verdict.score,
        reasons=tuple(verdict.reasons),
        mounting_sigma_rad=mounting_sigma_rad,
    )


def _outward(q_earth_sensor: Float) -> tuple[Float, Float]:
    """Return where each sensor's z axis points: its heading, and how far it is from level."""
    outward = rotation.rotate(q_earth_sensor, [0.0, 0.0, 1.0])
    heading_rad = np.arctan2(outward[:, 1], outward[:, 0])
    return heading_rad, np.abs(np.arcsin(np.clip(outward[:, 2], -1.0, 1.0)))


def _put_on(
    placements: Sequence[Placement],
    own_heading: NDArray[np.bool_],
    steepness_rad: Float,
    heading_rad: Float,
    facing_rad: float,
    verdict: Verdict,
) -> dict[Placement, float]:
    """Return by how much to turn each sensor that has a heading of its own, put on as the mounting rule says."""
    offsets: dict[Placement, float] = {}
    for s, placement in enumerate(placements):
        if own_heading[s]:
            _require_compass_for_steep(placement, float(steepness_rad[s]), verdict)
            offsets[placement] = wrapped(facing_rad + OUTWARD_HEADING_RAD[placement] - heading_rad[s])
    if offsets:
        verdict.lower(_ASSUMED_SCORE, say("calibration.put_on", where=list(offsets), sigma_rad=PUT_ON_RAD))
    return offsets


def _settled(sigma_rad: Float | None, sensors: int) -> Float:
    """Return the last sigmas that a filter stated, (S, 3), or those of one that has settled."""
    stated = np.full((sensors, 3), np.nan) if sigma_rad is None else sigma_rad[:, -1]
    return np.where(np.isfinite(stated), stated, _SETTLED_RAD)


def _seat(q_earth_sensor: Float, turn_rad: float, q_room_segment: Float) -> tuple[float, float, float, float]:
    """Return `q_sensor_segment` of a sensor whose earth frame is turned into the room by this angle."""
    q_room_sensor = rotation.multiply(rotation.about_z(turn_rad), q_earth_sensor)
    w, x, y, z = rotation.positive(rotation.multiply(rotation.conjugate(q_room_sensor), q_room_segment))
    return float(w), float(x), float(y), float(z)


def _checked_flags(q_earth_sensor: Float, flags: NDArray[np.uint8] | None, sensors: int) -> NDArray[np.uint8]:
    """Return the flags of orientations whose shape fits the placements; all sound where none are given."""
    if q_earth_sensor.ndim != 3 or q_earth_sensor.shape[0] != sensors or q_earth_sensor.shape[2] != 4:
        raise ShapeError(f"q_earth_sensor has shape {q_earth_sensor.shape}; it must be ({sensors}, K, 4)")
    if flags is None:
        flags = np.zeros(q_earth_sensor.shape[:2], dtype=np.uint8)
    if flags.shape != q_earth_sensor.shape[:2]:
        raise ShapeError(f"flags have shape {flags.shape}; they must be {q_earth_sensor.shape[:2]}")
    return flags


def _posed(placement: Placement, is_raised: bool) -> Float:
    """Return the orientation of a segment in the pose, in a room whose x axis is where the patient faces."""
    q_room_segment = rotation.about_z(N_POSE_TURN_RAD.get(placement, 0.0))
    if is_raised:
        level = 0.5 * math.pi if placement.endswith("left") else -0.5 * math.pi
        q_room_segment = rotation.multiply(rotation.exp(np.array([level, 0.0, 0.0])), q_room_segment)
    return q_room_segment


def _require_compass_for_steep(placement: Placement, steepness_rad: float, verdict: Verdict) -> None:
    """Judge a sensor whose own z axis must say its heading: nearly vertical it says none."""
    if steepness_rad > _STEEP_RAD:
        raise CalibrationError(say("calibration.flat_no_compass", where=[placement]))
    if steepness_rad > _SLANTED_RAD:
        verdict.lower(0.7, say("calibration.flat", where=[placement]))


def _in_segment(q_room_segment: Float, sigma_rad: Float, about_z_rad: float) -> tuple[float, float, float]:
    """Return the sigma of a mounting about the segment's axes: tilt of the sensor, heading as given."""
    tilt = float(sigma_rad[0] ** 2 + sigma_rad[1] ** 2) / 2.0
    turned = rotation.to_matrix(q_room_segment).T ** 2 @ np.array([tilt, tilt, about_z_rad**2])
    x, y, z = np.sqrt(turned)
    return float(x), float(y), float(z)


def _judge_samples(
    bias: StaticBias,
    accelerometer_mps2: Float,
    q_mean: Float,
    placements: Sequence[Placement],
    verdict: Verdict,
) -> None:
    """Look for motion, faulty accelerometers and orientations that contradict gravity."""
    restless = np.sqrt(np.sum(bias.gyroscope_sd_radps**2, axis=1))
    for s, placement in enumerate(placements):
        if restless[s] > _RESTLESS_RADPS:
            raise CalibrationError(say("calibration.was_moving", where=[placement]))
        if restless[s] > _QUIET_RADPS:
            verdict.lower(
                max(0.3, _QUIET_RADPS / restless[s]), say("calibration.not_still", where=[placement])
            )
        if bias.unusual[s]:
            verdict.lower(UNUSUAL_BIAS_SCORE, unusual_bias([placement]))
        force = np.nanmedian(accelerometer_mps2[s], axis=0)
        error = abs(float(np.linalg.norm(force)) / GRAVITY_MPS2 - 1.0)
        if error > _NORM_FAULT:
            raise CalibrationError(say("calibration.gravity_fault", where=[placement], error=error))
        if error > _NORM_WARNING:
            verdict.lower(
                _NORM_WARNING / error, say("calibration.gravity_off", where=[placement], error=error)
            )
        tilt = rotation.rotate(q_mean[s], force / np.linalg.norm(force))
        away = math.acos(min(1.0, float(tilt[2])))
        if away > SWAY_RAD:
            verdict.lower(
                max(0.2, SWAY_RAD / away),
                say("calibration.not_settled", where=[placement], angle_rad=away),
            )


def _judge_flags(flags: NDArray[np.uint8], placements: Sequence[Placement], verdict: Verdict) -> None:
    def hit(flag: OrientationFlag) -> list[Placement]:
        return [p for p, bad in zip(placements, mostly(flags, flag), strict=True) if bad]

    if where := hit(OrientationFlag.MAGNETIC_DISTURBANCE):
        verdict.lower(0.6, say("calibration.iron_near", where=where))
    if where := hit(OrientationFlag.CONVERGING):
        verdict.lower(0.8, say("calibration.just_started", where=where))
    if where := hit(OrientationFlag.SATURATED):
        verdict.lower(0.5, say("calibration.at_limit", where=where))


def _facing(
    placements: Sequence[Placement],
    heading_rad: Float,
    steepness_rad: Float,
    own_heading: NDArray[np.bool_],
    verdict: Verdict,
) -> tuple[float, Placement, float]:
    """Return where the patient faces in the earth frame, the sensor that says so, and the sigma of it."""
    shared = [p for p in placements if not own_heading[placements.index(p)]]
    candidates = [p for p in FACING_ORDER if p in (shared or placements)]
    usable = [p for p in candidates if steepness_rad[placements.index(p)] <= _STEEP_RAD]
    if not usable:
        raise CalibrationError(say("calibration.facing_unknown", where=candidates))
    chosen = usable[0]
    if chosen != candidates[0]:
        verdict.lower(0.8, say("calibration.facing_by_other", where=[candidates[0]], by=[chosen]))
    if steepness_rad[placements.index(chosen)] > _SLANTED_RAD:
        verdict.lower(0.6, say("calibration.nearly_flat", where=[chosen]))
    rows = {p: placements.index(p) for p in usable}
    implied = {p: float(heading_rad[row]) - OUTWARD_HEADING_RAD[p] for p, row in rows.items()}
    # A sensor that was put on by the rule tells the direction again, with an error of its own; one that was
    # put on any other way round is far off. The weight fades between the two, without a step.
    pair = {chosen, chosen.replace("right", "left"), chosen.replace("left", "right")} if shared else {chosen}
    asked = cmath.phase(sum(cmath.exp(1j * angle) for p, angle in implied.items() if p in pair))
    total, weights, squares = complex(0.0), 0.0, 0.0
    for p, angle in implied.items():
        weight = 1.0 if p in pair else 0.0
        if shared and p not in pair and steepness_rad[rows[p]] <= _SLANTED_RAD:
            away_rad = abs(wrapped(angle - asked))
            weight = float(np.interp(away_rad, (_CONCURRING_RAD, 2.0 * _CONCURRING_RAD), (1.0, 0.0)))
        total += weight * cmath.exp(1j * angle)
        weights, squares = weights + weight, squares + weight**2
    return cmath.phase(total), chosen, PUT_ON_RAD * math.sqrt(squares) / weights


def _judge_agreement(
    placements: Sequence[Placement],
    heading_rad: Float,
    steepness_rad: Float,
    own_heading: NDArray[np.bool_],
    facing_rad: float,
    reference: Placement,
    verdict: Verdict,
) -> None:
    """Say so when the other sensors, by their rule, agree on another facing direction than the reference."""
    implied = [
        heading_rad[s] - OUTWARD_HEADING_RAD[p]
        for s, p in enumerate(placements)
        if p != reference and not own_heading[s] and steepness_rad[s] <= _SLANTED_RAD
    ]
    if len(implied) < 2:
        return
    agreement = _AGREEMENT if len(implied) >= _WITNESSES else _CLOSE_AGREEMENT
    mean = complex(np.mean(np.exp(1j * np.array(implied))))
    away_rad = abs(wrapped(math.atan2(mean.imag, mean.real) - facing_rad))
    # Sensors mounted any way round do not agree with each other; only a common opinion counts.
    if abs(mean) > agreement and away_rad > _DISAGREEMENT_RAD:
        verdict.lower(0.7, say("calibration.faces_away", where=[reference], angle_rad=away_rad))
