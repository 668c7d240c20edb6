"""The body above the feet: its centre of mass solves Newton and Euler for the given feet and pressure path."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, SIDES, Side
from estimators.simulation.arm.kinematics import (
    Path,
    Turn,
    carried,
    cross,
    rotate,
)
from estimators.simulation.arm.timeline import minimum_jerk
from estimators.simulation.gait.course import Footing
from estimators.simulation.gait.foot import FootMotion
from estimators.simulation.gait.upper import (
    PELVIS_SHARE,
    TRUNK_GYRATION_M,
    BodyStyle,
    com_height,
    upper_turns,
)

Float = NDArray[np.float64]

UPWARD_MPS2 = np.array([0.0, 0.0, GRAVITY_MPS2])
"""What an accelerometer feels of gravity, room frame."""
_PELVIS_GYRATION_M = (0.12, 0.10, 0.12)
_HEEL_SHARE, _HEEL_CENTRE_M, _HEEL_GYRATION_M = 0.7, (0.04, 0.0, 0.02), (0.03, 0.06, 0.06)
_FOREFOOT_CENTRE_M, _FOREFOOT_GYRATION_M = (0.02, 0.0, 0.01), (0.02, 0.03, 0.03)
_PELVIS_OFFSET_M, _TRUNK_OFFSET_M = (0.0, 0.0, -0.08), (0.0, 0.0, 0.24)


@dataclass(frozen=True)
class RigidBody:
    """A rigid part with mass: how it moves and what it takes to move it so.

    Attributes
    ----------
    centre : Path
        Of its mass, room frame.
    momentum_rate_nm : ndarray, shape (N, 3)
        Rate of its angular momentum about its own centre, `R (I w' + w x I w)`, room frame.
    """

    mass_kg: float
    centre: Path
    turn: Turn
    momentum_rate_nm: Float


@dataclass(frozen=True)
class BodyMotion:
    """Everything that follows from the feet.

    Attributes
    ----------
    parts : dict of str to RigidBody
        `pelvis`, `trunk`, `heel_left`, `forefoot_left`, `heel_right`, `forefoot_right`.
    com : Path
        Of all parts together.
    lumbar : Path
        The joint between pelvis and trunk.
    force_n : dict of Side to ndarray, shape (N, 3)
        Of the ground on the foot.
    cop_m : dict of Side to ndarray, shape (N, 3)
        Where it acts, on the floor under that foot; meaningless without load.
    free_moment_nm : dict of Side to ndarray, shape (N,)
    """

    parts: dict[str, RigidBody]
    com: Path
    lumbar: Path
    force_n: dict[Side, Float]
    cop_m: dict[Side, Float]
    free_moment_nm: dict[Side, Float]


def move_body(
    style: BodyStyle,
    footing: Footing,
    feet: dict[Side, FootMotion],
    sole_cop_m: dict[Side, Float],
    stride_s: float,
    time_s: Float,
) -> BodyMotion:
    """Find the motion of the body for which the ground can only push as planned.

    Parameters
    ----------
    sole_cop_m : dict of Side to ndarray, shape (N, 3)
        Where each foot is pressed.
    time_s : ndarray, shape (N,)
        Even.

    Notes
    -----
    Unknown is the horizontal path of the lumbar joint. The moments of all forces about the horizontal axes
    give for each of its coordinates `X'' = (beta X - kappa) / alpha`, a boundary value problem (rest at both
    ends) solved with Numerov's fourth-order scheme. Forces are then those that the accelerations need, so
    that Newton and Euler hold to rounding; each foot is pushed along the line to the centre of mass as far
    as the sum allows, and the free moments take what is left about the vertical.
    """
    step_s = float(time_s[1] - time_s[0])
    parts = _foot_parts(style, feet)
    turns = upper_turns(style, footing, stride_s, time_s)
    upper_mass = style.mass_kg - 2.0 * style.foot_mass_kg
    carried_parts = _upper_parts(upper_mass, turns, time_s.size)
    height = com_height(style, footing, stride_s, time_s)
    lumbar_z = []
    for order in range(3):
        known = total_of(part.mass_kg * part.centre[order][:, 2] for part in parts.values())
        known = known + total_of(part.mass_kg * part.centre[order][:, 2] for part in carried_parts.values())
        lumbar_z.append((style.mass_kg * height[order] - known) / upper_mass)

    share = _left_share(footing, time_s)
    shares: dict[Side, Float] = {"left": share, "right": 1.0 - share}
    floor = {side: sole_cop_m[side][:, 2] for side in SIDES}
    plane_z = total_of(shares[side] * floor[side] for side in SIDES)
    pressed = total_of(shares[side][:, None] * sole_cop_m[side] for side in SIDES)
    weight = style.mass_kg * (GRAVITY_MPS2 + height.acceleration)
    wanted = np.zeros((time_s.size, 2))
    # A second pass only matters on stairs: the push of the feet against each other then has a moment.
    for _ in range(2):
        between = wanted
        columns = []
        for axis in range(2):
            kappa = pressed[:, axis] * weight - between[:, axis] * (floor["left"] - floor["right"])
            columns.append(_lumbar_coordinate(axis, kappa, parts, carried_parts, lumbar_z, plane_z, step_s))
        lumbar = Path(
            *(np.column_stack((columns[0][order], columns[1][order], lumbar_z[order])) for order in range(3))
        )
        everything = dict(parts)
        for name, part in carried_parts.items():
            centre = Path(*(a + b for a, b in zip(lumbar, part.centre, strict=True)))
            everything[name] = replace(part, centre=centre)
        com = _mean_path(everything)
        total = style.mass_kg * (com.acceleration + UPWARD_MPS2)
        wanted = _between(com, total, shares, sole_cop_m)
    push = np.column_stack((between, np.zeros(time_s.size)))
    force: dict[Side, Float] = {
        "left": shares["left"][:, None] * total + push,
        "right": shares["right"][:, None] * total - push,
    }
    twist = total_of(
        cross(part.centre.position, part.mass_kg * (part.centre.acceleration + UPWARD_MPS2))[:, 2]
        + part.momentum_rate_nm[:, 2]
        for part in everything.values()
    )
    twist = twist - total_of(cross(sole_cop_m[side], force[side])[:, 2] for side in SIDES)
    moments = {side: shares[side] * twist for side in SIDES}
    return BodyMotion(everything, com, lumbar, force, dict(sole_cop_m), moments)


def _upper_parts(mass_kg: float, turns: Mapping[str, Turn], count: int) -> dict[str, RigidBody]:
    """Return pelvis and trunk with their centres relative to the lumbar joint, which carries both."""
    still = Path(*(np.zeros((count, 3)) for _ in range(3)))
    found = {}
    for name, share, offset, gyration in (
        ("pelvis", PELVIS_SHARE, _PELVIS_OFFSET_M, _PELVIS_GYRATION_M),
        ("trunk", 1.0 - PELVIS_SHARE, _TRUNK_OFFSET_M, TRUNK_GYRATION_M),
    ):
        mass, turn = share * mass_kg, turns[name]
        centre = carried(still, turn, offset)
        found[name] = RigidBody(mass, centre, turn, _momentum_rate(mass, gyration, turn))
    return found


def _lumbar_coordinate(
    axis: int,
    kappa: Float,
    feet: Mapping[str, RigidBody],
    upper: Mapping[str, RigidBody],
    lumbar_z: Sequence[Float],
    plane_z: Float,
    step_s: float,
) -> tuple[Float, Float, Float]:
    """Return a horizontal coordinate of the lumbar joint from the moments about the other horizontal axis.

    `kappa` starts as the moment of the ground; those of the parts are added here.
    """
    alpha, beta = np.zeros(plane_z.size), np.zeros(plane_z.size)
    rolling = (0, 1)[axis == 0]
    sign = 1.0 if axis == 0 else -1.0
    for part in upper.values():
        lift = part.mass_kg * (lumbar_z[2] + part.centre.acceleration[:, 2] + GRAVITY_MPS2)
        arm = part.mass_kg * (lumbar_z[0] + part.centre.position[:, 2] - plane_z)
        alpha += arm
        beta += lift
        kappa += arm * part.centre.acceleration[:, axis] - lift * part.centre.position[:, axis]
        kappa += sign * part.momentum_rate_nm[:, rolling]
    for part in feet.values():
        lift = part.mass_kg * (part.centre.acceleration[:, 2] + GRAVITY_MPS2)
        arm = part.mass_kg * (part.centre.position[:, 2] - plane_z)
        kappa += arm * part.centre.acceleration[:, axis] - lift * part.centre.position[:, axis]
        kappa += sign * part.momentum_rate_nm[:, rolling]
    return _boundary_value(beta / alpha, -kappa / alpha, step_s)


def _foot_parts(style: BodyStyle, feet: dict[Side, FootMotion]) -> dict[str, RigidBody]:
    parts = {}
    for side, foot in feet.items():
        heel_mass = _HEEL_SHARE * style.foot_mass_kg
        forefoot_mass = style.foot_mass_kg - heel_mass
        parts[f"heel_{side}"] = RigidBody(
            heel_mass,
            carried(foot.heel_sensor, foot.heel, _HEEL_CENTRE_M),
            foot.heel,
            _momentum_rate(heel_mass, _HEEL_GYRATION_M, foot.heel),
        )
        parts[f"forefoot_{side}"] = RigidBody(
            forefoot_mass,
            carried(foot.hinge, foot.forefoot, _FOREFOOT_CENTRE_M),
            foot.forefoot,
            _momentum_rate(forefoot_mass, _FOREFOOT_GYRATION_M, foot.forefoot),
        )
    return parts


def _momentum_rate(mass_kg: float, gyration_m: tuple[float, float, float], turn: Turn) -> Float:
    """Return `R (I w' + w x I w)` in the room; the gyroscopic term is part of it."""
    inertia = mass_kg * np.square(gyration_m)
    back = rotation.conjugate(turn.q)
    rate = rotate(back, turn.rate)
    return rotate(turn.q, inertia * rotate(back, turn.acceleration) + cross(rate, inertia * rate))


def _left_share(footing: Footing, time_s: Float) -> Float:
    share = np.full(time_s.size, footing.standing_left_share)
    for start, end, change in footing.shifts:
        share = share + change * minimum_jerk((time_s - start) / (end - start)).value
    # Sums of fractions leave 1e-17 where nothing is.
    return np.where(np.abs(share) < 1e-12, 0.0, np.where(np.abs(share - 1.0) < 1e-12, 1.0, share))


def _boundary_value(stiffness: Float, forcing: Float, step_s: float) -> tuple[Float, Float, Float]:
    """Solve `x'' = f x + s` with rest at both ends (x = -s / f there); value, rate and acceleration."""
    twelfth = step_s**2 / 12.0
    count = stiffness.size
    bands = np.zeros((3, count))
    right = np.empty(count)
    right[1:-1] = twelfth * (forcing[2:] + 10.0 * forcing[1:-1] + forcing[:-2])
    bands[1, 1:-1] = -2.0 * (1.0 + 5.0 * twelfth * stiffness[1:-1])
    bands[0, 2:] = 1.0 - twelfth * stiffness[2:]
    bands[2, :-2] = 1.0 - twelfth * stiffness[:-2]
    bands[1, 0] = bands[1, -1] = 1.0
    right[0], right[-1] = -forcing[0] / stiffness[0], -forcing[-1] / stiffness[-1]
    value = solve_banded((1, 1), bands, right)
    acceleration = stiffness * value + forcing
    rate = np.zeros(count)
    # Hermite's rule: central difference with the known accelerations takes the error to fourth order.
    rate[1:-1] = (value[2:] - value[:-2]) / (2.0 * step_s)
    rate[1:-1] -= step_s / 12.0 * (acceleration[2:] - acceleration[:-2])
    return value, rate, acceleration


def _mean_path(parts: dict[str, RigidBody]) -> Path:
    mass = sum(part.mass_kg for part in parts.values())
    return Path(
        *(total_of(part.mass_kg * part.centre[order] for part in parts.values()) / mass for order in range(3))
    )


def _between(com: Path, total: Float, shares: dict[Side, Float], cop: dict[Side, Float]) -> Float:
    """Return the horizontal push of the left foot beyond its share: each force points to the centre of mass."""
    lines = {}
    for side in SIDES:
        arm = com.position - cop[side]
        lines[side] = (shares[side] * total[:, 2] / arm[:, 2])[:, None] * arm[:, :2]
    rest = total[:, :2] - lines["left"] - lines["right"]
    return np.asarray(lines["left"] + shares["left"][:, None] * rest - shares["left"][:, None] * total[:, :2])


def total_of(parts: Iterable[Float]) -> Float:
    """Return the sum of arrays of one shape."""
    return np.asarray(sum(parts))
