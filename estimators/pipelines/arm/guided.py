"""Calibration by movement and headings set anew, on a running body network."""

import cmath
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from estimators import rotation
from estimators.calibration import Calibration, FunctionalResult, functional, static_bias
from estimators.calibration._mounting import N_POSE_TURN_RAD, PUT_ON_RAD
from estimators.calibration._rest import mostly, wrapped
from estimators.conventions import Placement
from estimators.errors import CalibrationError, SetupError
from estimators.orientation import OrientationEstimator, OrientationFlag, OrientationResult
from estimators.pipelines._biases import bias_along_gravity, bias_sigma
from estimators.pipelines.arm.body import BodyNetwork
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

_OFF_POSE_RAD: Final = math.radians(25.0)
"""More tilt than this between a segment and the N-pose: the limb does not hang."""
_FROM_POSE: Final = ("n_pose", "t_pose")
_UP: Final = np.array([0.0, 0.0, 1.0])
_TELL_FACING: Final[tuple[Placement, ...]] = ("sternum", "pelvis")
"""Where worn and asked for, they alone say where the patient faces: arms hang more or less turned."""


def by_movement(
    network: BodyNetwork, chunk: ImuChunk, movements: Mapping[str, tuple[int, int]], *, assisted: bool
) -> FunctionalResult:
    """Calibrate from movements; a filter that began with their rest, its bias known, takes over.

    Parameters
    ----------
    chunk : ImuChunk
        As measured, from before the rest on; best up to the newest tick, so that the filter can take over.
    movements : mapping of str to (start, stop)
        Session ticks.
    """
    corrected = network.corrected(chunk)
    ticks = {name: (a - chunk.first_tick, b - chunk.first_tick) for name, (a, b) in movements.items()}
    if "rest" not in ticks:
        raise CalibrationError(say("calibration.rest_missing"), redo=["rest"])
    rest = corrected.ticks(*ticks["rest"])
    force_bias = bias_along_gravity(rest.accelerometer_mps2)
    corrected = replace(corrected, accelerometer_mps2=corrected.accelerometer_mps2 - force_bias[:, None])
    bias = static_bias(rest.gyroscope_radps, rest.accelerometer_mps2, chunk.time_step_s, require_still=False)
    fresh = network.new_filter(force_bias)
    fresh.set_gyroscope_bias(bias.gyroscope_bias_radps, bias_sigma(bias))
    result = fresh.update(corrected)
    found = functional(
        result.q_earth_sensor,
        corrected.gyroscope_radps,
        corrected.accelerometer_mps2,
        network.setup.placements,
        ticks,
        # Its bias is known: it did not begin like one that was just switched on.
        result.flags & np.uint8(0xFF & ~int(OrientationFlag.CONVERGING)),
        time_step_s=chunk.time_step_s,
        assisted=assisted,
    )
    lacking = [p for p in network.setup.placements if p not in found.calibration.q_sensor_segment]
    if lacking:
        known = network.setup.calibration
        if known is None or any(p not in known.q_sensor_segment for p in lacking):
            raise CalibrationError(say("calibration.movements_tell_nothing", where=lacking))
        retained = {p: known.q_sensor_segment[p] for p in lacking}
        own_heading = mostly(result.flags, OrientationFlag.HEADING_NOT_TRUSTED)
        untold = [p for p in lacking if own_heading[network.setup.placements.index(p)]]
        found = replace(
            found,
            calibration=replace(
                found.calibration,
                q_sensor_segment={**found.calibration.q_sensor_segment, **retained},
                mounting_sigma_rad={**known.mounting_sigma_rad, **found.calibration.mounting_sigma_rad},
                unknown_headings=tuple(p for p in untold if p in known.unknown_headings),
            ),
        )
    calibration = replace(
        found.calibration,
        accelerometer_bias_mps2={
            p: (float(b[0]), float(b[1]), float(b[2]))
            for p, b in zip(network.setup.placements, force_bias, strict=True)
        },
    )
    is_newest = chunk.first_tick + chunk.tick_count == network.next_tick
    network.adopt(calibration, fresh if is_newest else None)
    return replace(found, calibration=calibration)


def reset_heading(network: BodyNetwork, pose: ImuChunk, placements: Sequence[Placement]) -> Calibration:
    """Turn the named segments about the vertical so that they face as in the N-pose now held.

    Parameters
    ----------
    network : BodyNetwork
        Calibrated, or with a mounting remembered from an earlier session. Then the pose also tells what the
        gyroscopes read at rest and, where all that is worn is posed, how sensors that were put on anew are tilted
        (a mounting found by movement stays: it does not depend on how the limbs hang). And one sensor tells where
        the patient faces for all that share the heading of their compasses, also for those not named: who cannot
        stand sits still and has the trunk set.
    pose : ImuChunk
        As measured, among the last ticks.

    Raises
    ------
    CalibrationError
        If there is no calibration yet, or a limb does not hang as in the N-pose.
    """
    known = network.setup.calibration
    if known is None or not known.q_sensor_segment:
        raise CalibrationError(say("calibration.reset_needs_one"))
    worn = network.setup.placements
    unknown = [p for p in placements if p not in worn]
    if unknown:
        raise SetupError(say("calibration.not_worn", where=unknown))
    anew = None
    is_remembered = not set(worn) <= set(known.gyroscope_bias_radps)
    if is_remembered:
        known, anew = _begun_at_rest(network, pose, known)
    q_earth_sensor, flags = network.during(pose, anew)
    heading_rad = {
        p: _heading_off(p, rotation.mean(q_earth_sensor[worn.index(p)]), known) for p in placements
    }
    if is_remembered and set(placements) == set(worn):
        known = _put_on_anew(known, {p: rotation.mean(q_earth_sensor[worn.index(p)]) for p in worn})
    own_heading = mostly(flags, OrientationFlag.HEADING_NOT_TRUSTED)
    sharing = [p for p in known.unknown_headings if not own_heading[worn.index(p)]]
    stated = [p for p in _TELL_FACING if p in sharing and p in placements] or [
        p for p in placements if p in sharing
    ]
    turn_rad = cmath.phase(sum(cmath.exp(1j * heading_rad[p]) for p in stated)) if stated else 0.0
    offsets = dict(known.heading_offset_rad)
    for p in worn:
        # Sensors that share the common heading turn with it, also those that were not asked for.
        wanted_rad = heading_rad.get(p, turn_rad if p in sharing else 0.0)
        if wanted_rad != turn_rad or p in offsets:
            offsets[p] = wrapped(offsets.get(p, 0.0) + wanted_rad - turn_rad)
    now_known = {*placements, *(sharing if stated else ())}
    found = replace(
        known,
        facing_rad=known.facing_rad - turn_rad,
        heading_offset_rad=offsets,
        unknown_headings=tuple(p for p in known.unknown_headings if p not in now_known),
    )
    network.adopt(found, None if anew is None else anew[0])
    return found


def _heading_off(placement: Placement, q_earth_sensor: Float, known: Calibration) -> float:
    """Return by how much a segment must turn to face as in the N-pose; refuse one that does not hang so."""
    turn = rotation.about_z(known.heading_offset_rad.get(placement, 0.0) - known.facing_rad)
    segment = rotation.multiply(rotation.multiply(turn, q_earth_sensor), known.q_sensor_segment[placement])
    expected = rotation.about_z(N_POSE_TURN_RAD.get(placement, 0.0))
    apart = rotation.multiply(expected, rotation.conjugate(segment))
    tilt = 2.0 * math.acos(min(1.0, math.hypot(float(apart[0]), float(apart[3]))))
    if tilt > _OFF_POSE_RAD:
        raise CalibrationError(say("calibration.off_pose", where=[placement], angle_rad=tilt))
    return wrapped(2.0 * math.atan2(float(apart[3]), float(apart[0])))


def _put_on_anew(known: Calibration, q_earth_sensor: Mapping[Placement, Float]) -> Calibration:
    """Let every segment hang as in the N-pose, whose sensor sits by some degrees otherwise than it is remembered.

    The turn about the limb stays as it is remembered: the pose does not show it.
    """
    is_posed = known.method in _FROM_POSE
    seats, sigmas = dict(known.q_sensor_segment), dict(known.mounting_sigma_rad)
    for placement, q_sensor in q_earth_sensor.items():
        if is_posed:
            segment = rotation.multiply(q_sensor, known.q_sensor_segment[placement])
            upright = rotation.shortest(rotation.rotate(segment, _UP), _UP)
            hanging = rotation.multiply(upright, segment)
            seat = rotation.positive(rotation.multiply(rotation.conjugate(q_sensor), hanging))
            seats[placement] = (float(seat[0]), float(seat[1]), float(seat[2]), float(seat[3]))
        if placement in sigmas:
            x, y, z = sigmas[placement]
            tilt = 0.0 if is_posed else PUT_ON_RAD
            sigmas[placement] = (math.hypot(x, tilt), math.hypot(y, tilt), math.hypot(z, PUT_ON_RAD))
    return replace(known, q_sensor_segment=seats, mounting_sigma_rad=sigmas)


def _begun_at_rest(
    network: BodyNetwork, pose: ImuChunk, known: Calibration
) -> tuple[Calibration, tuple[OrientationEstimator, OrientationResult] | None]:
    """Let a filter begin with the pose, its bias given by it; with the calibration that knows that bias."""
    pose = network.corrected(pose)
    rest = static_bias(pose.gyroscope_radps, pose.accelerometer_mps2, pose.time_step_s, require_still=False)
    bias = {
        name: (float(x), float(y), float(z))
        for name, (x, y, z) in zip(network.setup.placements, rest.gyroscope_bias_radps, strict=True)
    }
    force_bias = network.force_bias_mps2
    anew = network.begin_anew(pose, rest.gyroscope_bias_radps, bias_sigma(rest), force_bias)
    return replace(known, gyroscope_bias_radps=bias), anew
