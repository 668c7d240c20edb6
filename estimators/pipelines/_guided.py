"""Calibration by movement and headings set anew, on a running body network."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from estimators import rotation
from estimators.calibration import Calibration, FunctionalResult, functional, static_bias
from estimators.calibration._mounting import N_POSE_TURN_RAD
from estimators.conventions import Placement
from estimators.errors import CalibrationError, SetupError
from estimators.orientation import OrientationFlag
from estimators.pipelines._biases import bias_along_gravity, bias_sigma
from estimators.pipelines._body import BodyNetwork
from estimators.recording import ImuChunk

_OFF_POSE_RAD: Final = math.radians(25.0)
"""More tilt than this between a segment and the N-pose: the limb does not hang."""


def by_movement(
    network: BodyNetwork, chunk: ImuChunk, movements: Mapping[str, tuple[int, int]], *, assisted: bool
) -> FunctionalResult:
    """Calibrate from movements; a filter that began with their rest, its bias known, takes over.

    Parameters
    ----------
    network : BodyNetwork
    chunk : ImuChunk
        As measured, from before the rest on; best up to the newest tick, so that the filter can take over.
    movements : mapping of str to (start, stop)
        Session ticks.
    assisted : bool
    """
    corrected = network.corrected(chunk)
    ticks = {name: (a - chunk.first_tick, b - chunk.first_tick) for name, (a, b) in movements.items()}
    if "rest" not in ticks:
        raise CalibrationError("the moment of rest is missing; keep still for 3 s before the movements")
    rest = corrected.ticks(*ticks["rest"])
    force_bias = bias_along_gravity(rest.accelerometer_mps2)
    corrected = replace(corrected, accelerometer_mps2=corrected.accelerometer_mps2 - force_bias[:, None])
    bias = static_bias(rest.gyroscope_radps, rest.accelerometer_mps2, chunk.time_step_s, require_still=False)
    fresh = network.new_filter()
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
            names = ", ".join(p.replace("_", " ") for p in lacking)
            raise CalibrationError(
                f"these movements tell nothing of {names}; take that sensor off, or calibrate both arms"
            )
        kept = {p: known.q_sensor_segment[p] for p in lacking}
        found = replace(
            found,
            calibration=replace(
                found.calibration, q_sensor_segment={**found.calibration.q_sensor_segment, **kept}
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
        Calibrated.
    pose : ImuChunk
        Among the last ticks.
    placements : sequence of Placement

    Raises
    ------
    CalibrationError
        If there is no calibration yet, or a limb does not hang as in the N-pose.
    """
    known = network.setup.calibration
    if known is None or not known.q_sensor_segment:
        raise CalibrationError("headings can be set anew only after a calibration; hold the standing pose")
    unknown = [p for p in placements if p not in network.setup.placements]
    if unknown:
        raise SetupError(f"no sensor {', '.join(unknown)} is worn")
    q_earth_sensor, _ = network.during(pose, None)
    offsets = dict(known.heading_offset_rad)
    for placement in placements:
        s = network.setup.placements.index(placement)
        turn = rotation.about_z(offsets.get(placement, 0.0) - known.facing_rad)
        segment = rotation.multiply(
            rotation.multiply(turn, rotation.mean(q_earth_sensor[s])), known.q_sensor_segment[placement]
        )
        expected = rotation.about_z(N_POSE_TURN_RAD.get(placement, 0.0))
        apart = rotation.multiply(expected, rotation.conjugate(segment))
        heading = 2.0 * math.atan2(float(apart[3]), float(apart[0]))
        tilt = 2.0 * math.acos(min(1.0, math.hypot(float(apart[0]), float(apart[3]))))
        if tilt > _OFF_POSE_RAD:
            raise CalibrationError(
                f"the {placement.replace('_', ' ')} is {math.degrees(tilt):.0f} degrees off the standing pose; let the "
                "arms hang, palms to the thighs, and repeat"
            )
        offsets[placement] = math.remainder(offsets.get(placement, 0.0) + heading, 2.0 * math.pi)
    found = replace(known, heading_offset_rad=offsets)
    network.adopt(found, None)
    return found


__all__ = ["by_movement", "reset_heading"]
