"""Pelvis and trunk of a walker: how they turn, and how high the centre of mass goes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from estimators.conventions import GRAVITY_MPS2
from estimators.simulation.arm.kinematics import (
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Scalar,
    Turn,
    compose,
    turn_about,
)
from estimators.simulation.arm.timeline import minimum_jerk, quintic
from estimators.simulation.gait.course import Footing

Float = NDArray[np.float64]

PELVIS_SHARE = 0.45
"""Of what the feet leave: pelvis with the legs' share, then trunk with head and arms."""
TRUNK_GYRATION_M = (0.28, 0.27, 0.14)


@dataclass(frozen=True)
class BodyStyle:
    """What the body above the feet is and does.

    Attributes
    ----------
    mass_kg, foot_mass_kg : float
        With shoes; of each foot with its shoe.
    com_height_m, bob_m : float
        Mean height of the centre of mass and amplitude of its rise at every step.
    momentum_arm_m : float
        Swaying of the trunk: largest rate of angular momentum as weight times this, 0.02 m is lively.
    """

    mass_kg: float = 68.0
    foot_mass_kg: float = 1.2
    com_height_m: float = 0.95
    bob_m: float = 0.012
    momentum_arm_m: float = 0.005


def upper_turns(style: BodyStyle, footing: Footing, stride_s: float, time_s: Float) -> dict[str, Turn]:
    """Pelvis and trunk: along the path, with the small turns of walking."""
    lands = np.array([step[1] for step in footing.steps])
    headings = np.array([step[2] for step in footing.steps])
    half = 0.5 * stride_s
    heading = _held_spline(
        np.concatenate(([lands[0] - half], lands)), np.concatenate(([0.0], headings)), time_s
    )
    # A phase that gains half a turn with every landing: swaying keeps step with uneven steps.
    knots = np.concatenate(([lands[0] - half], lands, [lands[-1] + half]))
    is_left = np.array([step[0] == "left" for step in footing.steps])
    # The same leg twice (after a halt) is a whole turn: the sway always leads to the side that steps.
    gains = np.where(is_left[1:] == is_left[:-1], 2.0 * np.pi, np.pi)
    phases = np.pi * (0.0 if is_left[0] else 1.0) + np.concatenate(([0.0], np.cumsum(gains)))
    phases = np.concatenate(([phases[0] - np.pi], phases, [phases[-1] + np.pi]))
    curve = CubicSpline(knots, phases, bc_type="natural")
    at = np.clip(time_s, knots[0], knots[-1])
    inside = (time_s > knots[0]) & (time_s < knots[-1])
    phase = Scalar(curve(at), np.where(inside, curve(at, 1), 0.0), np.where(inside, curve(at, 2), 0.0))
    active = _activity(footing, time_s)
    inertia = (1.0 - PELVIS_SHARE) * style.mass_kg * np.square(TRUNK_GYRATION_M)
    moment = style.momentum_arm_m * style.mass_kg * GRAVITY_MPS2
    pulse = 2.0 * np.pi / stride_s
    nod = moment / (inertia[1] * (2.0 * pulse) ** 2)
    roll = moment / (inertia[0] * pulse**2)
    yaw = np.radians(4.0)
    trunk = compose(
        turn_about(Z_AXIS, heading),
        compose(
            turn_about(Y_AXIS, _wave(phase, active, nod, 2.0, 0.4)),
            compose(
                turn_about(X_AXIS, _wave(phase, active, roll, 1.0, 1.1)),
                turn_about(Z_AXIS, _wave(phase, active, -0.6 * yaw, 1.0, 0.0)),
            ),
        ),
    )
    pelvis = compose(
        turn_about(Z_AXIS, heading),
        compose(
            turn_about(X_AXIS, _wave(phase, active, np.radians(3.0), 1.0, 0.5 * np.pi)),
            turn_about(Z_AXIS, _wave(phase, active, yaw, 1.0, 0.0)),
        ),
    )
    return {"pelvis": pelvis, "trunk": trunk}


def _wave(phase: Scalar, active: Scalar, size: float, times: float, offset: float) -> Scalar:
    """Return `size * active * sin(times * phase + offset)` with derivatives."""
    sine, cosine = np.sin(times * phase.value + offset), np.cos(times * phase.value + offset)
    first = times * phase.rate
    second = times * phase.acceleration
    return Scalar(
        size * active.value * sine,
        size * (active.rate * sine + active.value * first * cosine),
        size
        * (
            active.acceleration * sine
            + 2.0 * active.rate * first * cosine
            + active.value * (second * cosine - first**2 * sine)
        ),
    )


def _activity(footing: Footing, time_s: Float) -> Scalar:
    """Return 1 while walking, 0 while standing, with smooth changes."""
    total = Scalar(*(np.zeros(time_s.size) for _ in range(3)))
    for start, end in footing.active_s:
        fade = min(0.6, 0.4 * (end - start))
        for at, sign in ((start, 1.0), (end - fade, -1.0)):
            step = minimum_jerk((time_s - at) / fade)
            total = Scalar(
                total.value + sign * step.value,
                total.rate + sign * step.rate / fade,
                total.acceleration + sign * step.acceleration / fade**2,
            )
    return total


def com_height(style: BodyStyle, footing: Footing, stride_s: float, time_s: Float) -> Scalar:
    """Return the height of the centre of mass: low as a foot is loaded, high over the standing leg."""
    knots: list[tuple[float, float, float, float]] = []
    half_double = 0.06 * stride_s
    pulse = 4.0 * np.pi / stride_s
    steps, bob = footing.steps, style.bob_m
    floor = 0.0
    for start, end in footing.active_s:
        inside = [step for step in steps if start < step[1] <= end]
        knots.append((start - 0.4, style.com_height_m + floor, 0.0, 0.0))
        previous_low = start
        for number, (_, land_s, _, new_floor) in enumerate(inside):
            low_s = land_s + half_double
            if number:
                high_s = 0.5 * (previous_low + low_s)
                high = style.com_height_m + bob + 0.5 * (floor + new_floor)
                local = 2.0 * np.pi / (low_s - previous_low) if low_s > previous_low else pulse
                slope = 0.9 * (new_floor - floor) / (low_s - previous_low)
                knots.append((high_s, high, slope, -bob * local**2))
            if number < len(inside) - 1:
                # On stairs the body rises between the landings as the next leg takes over.
                knots.append((low_s, style.com_height_m - bob + new_floor, 0.0, bob * pulse**2))
            else:
                knots.append((low_s + 0.6, style.com_height_m + new_floor, 0.0, 0.0))
            floor, previous_low = new_floor, low_s
    table = np.array(knots)
    return quintic(table[:, 0], table[:, 1:], time_s)


def _held_spline(times: Float, values: Float, time_s: Float) -> Scalar:
    """Return minimum-jerk moves between values at increasing times, held outside."""
    index = np.clip(np.searchsorted(times, time_s, side="right") - 1, 0, times.size - 2)
    duration = np.diff(times)[index]
    step = minimum_jerk((time_s - times[index]) / duration)
    change = np.diff(values)[index]
    return Scalar(
        values[index] + change * step.value,
        change * step.rate / duration,
        change * step.acceleration / duration**2,
    )
