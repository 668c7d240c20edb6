"""The scalar measurements of Roetenberg's filter: direction of gravity and field, compiled.

Rows act on xi, the orientation error in the earth frame, and delta, the disturbance error there. The noises are
independent, so that one row after the other is the joint update.
"""

import math

from estimators._kernels import kernel
from estimators.orientation import _roetenberg_layout as at
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._marzouk_covariance import ROW, UPPER, Row, Upper, lessened
from estimators.orientation._roetenberg_covariance import (
    DISTURBED,
    Disturbed,
    first_column,
    less,
    lessened_disturbance,
    mixed,
    second_column,
    third_column,
)
from estimators.orientation._strapdown_steps import force_without_acceleration
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_INNOVATION, _ACCELERATION = steps.INNOVATION, steps.ACCELERATION
_ACCELERATION_GAIN, _GRAVITY = steps.ACCELERATION_GAIN, steps.GRAVITY
_HELD_ACCELERATION, _CHANGE_VARIANCE = at.HELD_ACCELERATION, at.CHANGE_VARIANCE
_FORCE_VARIANCE, _FIELD_VARIANCE = at.FORCE_VARIANCE, at.FIELD_VARIANCE
_TILT_LEVER, _TILT_VARIANCE = at.TILT_LEVER, at.TILT_VARIANCE
_REFERENCE_FIELD, _DISTURBANCE, _SPREAD = at.REFERENCE_FIELD, at.DISTURBANCE, at.SPREAD

STATE = f"Tuple(({UPPER}, {DISTURBED}, {ROW}))"
State = tuple[Upper, Disturbed, Row]
"""Covariance of orientation and offset; that of the disturbance; the errors found so far."""


@kernel(f"{STATE}({STATE}, float64[::1], int64, boolean, {ROW}, float64, float64)", inlined=True)
def taken(
    state: State, sample: Float, number: int, pinned: bool, h: Row, variance: float, residual: float
) -> State:
    """Take a scalar measurement with h = P H', its innovation and the variance of that, H P H' + R.

    The errors gather what is found, `sample` the innovation. A `pinned` disturbance is left out.
    """
    p, d, e = state
    inverse = 1.0 / variance
    gain = inverse * residual
    sample[_INNOVATION + 2 * number], sample[_INNOVATION + 2 * number + 1] = residual, inverse
    p = lessened(p, inverse, h[:6])
    e6, e7, e8 = e[6], e[7], e[8]
    if not pinned:
        d = lessened_disturbance(d, inverse, h)
        e6, e7, e8 = e6 + gain * h[6], e7 + gain * h[7], e8 + gain * h[8]
    return (
        p,
        d,
        (
            e[0] + gain * h[0],
            e[1] + gain * h[1],
            e[2] + gain * h[2],
            e[3] + gain * h[3],
            e[4] + gain * h[4],
            e[5] + gain * h[5],
            e6,
            e7,
            e8,
        ),
    )


@kernel(
    f"{STATE}({STATE}, float64[::1], int64, boolean, float64, float64, float64, float64, float64)",
    inlined=True,
)
def tilt_taken(
    state: State,
    sample: Float,
    number: int,
    pinned: bool,
    c0: float,
    c1: float,
    c2: float,
    innovation: float,
    variance: float,
) -> State:
    """Take a scalar measurement of any combination of the orientation errors."""
    p, d, e = state
    h = mixed(1.0, mixed(c0, first_column(p, d), c1, second_column(p, d)), c2, third_column(p, d))
    residual = innovation - (c0 * e[0] + c1 * e[1] + c2 * e[2])
    return taken(state, sample, number, pinned, h, c0 * h[0] + c1 * h[1] + c2 * h[2] + variance, residual)


@kernel(
    f"{STATE}({STATE}, int64, float64[:, ::1], float64[::1], float64[::1], boolean, float64, float64, float64)"
)
def held_gravity_taken(
    state: State,
    s: int,
    memory: Float,
    sample: Float,
    settings: Float,
    pinned: bool,
    ux: float,
    uy: float,
    scale: float,
) -> State:
    """Measure the two horizontal parts with the predicted acceleration held fixed, as published."""
    share, gravity = settings[_ACCELERATION_GAIN], settings[_GRAVITY]
    vx, vy = share * memory[s, _ACCELERATION] / gravity, share * memory[s, _ACCELERATION + 1] / gravity
    vz = 1.0 + share * memory[s, _ACCELERATION + 2] / gravity
    white = settings[_CHANGE_VARIANCE] + settings[_FORCE_VARIANCE]
    rxx = (share * share * memory[s, _SPREAD] + white) / gravity**2
    rxy = share * share * memory[s, _SPREAD + 1] / gravity**2
    ryy = (share * share * memory[s, _SPREAD + 2] + white) / gravity**2
    # The second row less its share of the first has noise of its own.
    part = rxy / rxx
    state = tilt_taken(state, sample, 0, pinned, 0.0, vz, -vy, ux * scale, rxx)
    return tilt_taken(
        state,
        sample,
        1,
        pinned,
        -vz,
        -part * vz,
        vx + part * vy,
        (uy - part * ux) * scale,
        ryy - part * rxy,
    )


@kernel(
    f"{STATE}({STATE}, float64[:, ::1], int64, float64[:, ::1], float64[::1], float64[::1], boolean)",
    inlined=True,
)
def gravity_taken(
    state: State, q: Float, s: int, memory: Float, sample: Float, settings: Float, pinned: bool
) -> State:
    """Measure the direction of force less predicted acceleration, its two horizontal parts.

    The published row holds the predicted acceleration fixed: -[(e_z + a/g) x] with (c_a^2 Q_a + sigma_w^2 +
    sigma_A^2)/g^2. But that acceleration came from the same orientation; substituting it leaves
    -(1 - c_a) [e_z x] with (sigma_w^2 + (1 + c_a^2) sigma_A^2)/g^2 (Luinge page, E-7), the default here.
    """
    ux, uy, uz = force_without_acceleration(s, q, memory, sample, settings)
    square = ux * ux + uy * uy + uz * uz
    if not square > 0.0:
        return state
    scale = 1.0 / math.sqrt(square)
    if settings[_HELD_ACCELERATION] > 0.0:
        return held_gravity_taken(state, s, memory, sample, settings, pinned, ux, uy, scale)
    variance = settings[_TILT_VARIANCE]
    scale *= settings[_TILT_LEVER]
    p, d, e = state
    h = second_column(p, d)
    p, d, e = taken((p, d, e), sample, 0, pinned, h, h[1] + variance, ux * scale - e[1])
    h = first_column(p, d)
    return taken((p, d, e), sample, 1, pinned, h, h[0] + variance, -uy * scale - e[0])


@kernel(
    f"{STATE}({STATE}, int64, float64[:, ::1], float64[::1], float64[::1], boolean, float64, float64, float64)",
    inlined=True,
)
def field_taken(
    state: State,
    s: int,
    memory: Float,
    sample: Float,
    settings: Float,
    pinned: bool,
    fx: float,
    fy: float,
    fz: float,
) -> State:
    """Measure the field, in the earth frame over the norm of the reference: -[(H + d) x] xi - delta.

    Held to nothing the disturbance only adds its floor to the noise.
    """
    mx = memory[s, _REFERENCE_FIELD] + memory[s, _DISTURBANCE]
    my = memory[s, _REFERENCE_FIELD + 1] + memory[s, _DISTURBANCE + 1]
    mz = memory[s, _REFERENCE_FIELD + 2] + memory[s, _DISTURBANCE + 2]
    noise = settings[_FIELD_VARIANCE]
    p, d, e = state
    h = mixed(mz, second_column(p, d), -my, third_column(p, d))
    h = less(h, d[0], d[3], d[6], d[9], d[12], d[15], d[18], d[19], d[20])
    variance = (mz * h[1] - my * h[2]) + (noise - h[6])
    residual = ((fx - mx) + e[6]) - (mz * e[1] - my * e[2])
    p, d, e = taken((p, d, e), sample, 2, pinned, h, variance, residual)
    h = mixed(mx, third_column(p, d), -mz, first_column(p, d))
    h = less(h, d[1], d[4], d[7], d[10], d[13], d[16], d[19], d[21], d[22])
    variance = (mx * h[2] - mz * h[0]) + (noise - h[7])
    residual = ((fy - my) + e[7]) - (mx * e[2] - mz * e[0])
    p, d, e = taken((p, d, e), sample, 3, pinned, h, variance, residual)
    h = mixed(my, first_column(p, d), -mx, second_column(p, d))
    h = less(h, d[2], d[5], d[8], d[11], d[14], d[17], d[20], d[22], d[23])
    variance = (my * h[0] - mx * h[1]) + (noise - h[8])
    residual = ((fz - mz) + e[8]) - (my * e[0] - mx * e[1])
    return taken((p, d, e), sample, 4, pinned, h, variance, residual)


@kernel("void(int64, float64, float64, float64, float64[:, ::1], float64[::1])")
def keep_spread(s: int, xx: float, xy: float, yy: float, memory: Float, settings: Float) -> None:
    """Keep Q_a = g^2 [e_z x] P_xi [e_z x]' + sigma_A^2 I of the acceleration just measured (page 2.3)."""
    square = settings[_GRAVITY] ** 2
    memory[s, _SPREAD] = square * yy + settings[_FORCE_VARIANCE]
    memory[s, _SPREAD + 1] = -square * xy
    memory[s, _SPREAD + 2] = square * xx + settings[_FORCE_VARIANCE]


__all__ = ["field_taken", "gravity_taken", "keep_spread"]
