"""The scalar measurements of Roetenberg's filter: direction of gravity and field, compiled.

Rows act on xi, the orientation error in the earth frame, and delta, the disturbance error there. The noises are
independent, so that one row after the other is the joint update.
"""

import math

from numba import types

from estimators._kernels import Scalars3
from estimators._lanes import (
    LANES_TYPE,
    MASK_TYPE,
    VECTOR_TYPE,
    anywhere,
    chosen,
    in_lanes,
    put_column,
    spread,
)
from estimators.orientation import _roetenberg_layout as at
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._marzouk_covariance import Row, Upper
from estimators.orientation._roetenberg_choice import STATE, State, either_state
from estimators.orientation._roetenberg_covariance import (
    ROW,
    UPPER,
    first_column,
    less,
    lessened,
    lessened_disturbance,
    mixed,
    second_column,
    third_column,
)
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_INNOVATION = steps.INNOVATION
_ACCELERATION_GAIN, _GRAVITY = steps.ACCELERATION_GAIN, steps.GRAVITY
_HELD_ACCELERATION, _CHANGE_VARIANCE = at.HELD_ACCELERATION, at.CHANGE_VARIANCE
_FORCE_VARIANCE, _FIELD_VARIANCE = at.FORCE_VARIANCE, at.FIELD_VARIANCE
_TILT_LEVER, _TILT_VARIANCE = at.TILT_LEVER, at.TILT_VARIANCE

_L, _M, _B, _I = LANES_TYPE, MASK_TYPE, types.boolean, types.intp
_SAMPLES, _SETTINGS = types.float64[:, ::1], types.float64[::1]
_TOLD = types.Tuple((_SAMPLES, _I, _B))
Told = tuple[Float, int, bool]
"""The samples side by side, the last of them, and whether the innovations are to be written there."""


@in_lanes(STATE(STATE, _TOLD, _I, _M, ROW, _L, _L))
def taken(
    state: State, told: Told, number: int, pinned: bool, h: Row, variance: float, residual: float
) -> State:
    """Take a scalar measurement with h = P H', its innovation and the variance of that, H P H' + R.

    The errors gather what is found. A `pinned` disturbance is left out.
    """
    p, d, e = state
    inverse = 1.0 / variance
    samples, last, tell = told
    if tell:
        put_column(samples, (0, last, _INNOVATION + 2 * number), residual)
        put_column(samples, (0, last, _INNOVATION + 2 * number + 1), inverse)
    free = chosen(pinned, 0.0, inverse)
    gain, free_gain = inverse * residual, free * residual
    return (
        lessened(p, inverse, h[:6]),
        lessened_disturbance(d, free, h),
        (
            e[0] + gain * h[0],
            e[1] + gain * h[1],
            e[2] + gain * h[2],
            e[3] + gain * h[3],
            e[4] + gain * h[4],
            e[5] + gain * h[5],
            e[6] + free_gain * h[6],
            e[7] + free_gain * h[7],
            e[8] + free_gain * h[8],
        ),
    )


@in_lanes(STATE(STATE, _TOLD, _I, _M, _L, _L, _L, _L, _L))
def tilt_taken(
    state: State,
    told: Told,
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
    h = mixed(spread(1.0), mixed(c0, first_column(p, d), c1, second_column(p, d)), c2, third_column(p, d))
    residual = innovation - (c0 * e[0] + c1 * e[1] + c2 * e[2])
    return taken(state, told, number, pinned, h, c0 * h[0] + c1 * h[1] + c2 * h[2] + variance, residual)


@in_lanes(STATE(STATE, VECTOR_TYPE, VECTOR_TYPE, _TOLD, _SETTINGS, _M, _L, _L, _L), inlined=False)
def held_gravity_taken(
    state: State,
    acceleration: Scalars3,
    spread_before: Scalars3,
    told: Told,
    settings: Float,
    pinned: bool,
    ux: float,
    uy: float,
    scale: float,
) -> State:
    """Measure the two horizontal parts with the predicted acceleration held fixed, as published."""
    share, gravity = settings[_ACCELERATION_GAIN], settings[_GRAVITY]
    vx, vy = share * acceleration[0] / gravity, share * acceleration[1] / gravity
    vz = 1.0 + share * acceleration[2] / gravity
    white = settings[_CHANGE_VARIANCE] + settings[_FORCE_VARIANCE]
    rxx = (share * share * spread_before[0] + white) / gravity**2
    rxy = share * share * spread_before[1] / gravity**2
    ryy = (share * share * spread_before[2] + white) / gravity**2
    # The second row less its share of the first has noise of its own.
    part = rxy / rxx
    state = tilt_taken(state, told, 0, pinned, spread(0.0), vz, -vy, ux * scale, rxx)
    return tilt_taken(
        state,
        told,
        1,
        pinned,
        -vz,
        -part * vz,
        vx + part * vy,
        (uy - part * ux) * scale,
        ryy - part * rxy,
    )


@in_lanes(STATE(STATE, VECTOR_TYPE, VECTOR_TYPE, VECTOR_TYPE, _TOLD, _SETTINGS, _M))
def gravity_taken(
    state: State,
    force: Scalars3,
    acceleration: Scalars3,
    spread_before: Scalars3,
    told: Told,
    settings: Float,
    pinned: bool,
) -> State:
    """Measure the direction of force less predicted acceleration, its two horizontal parts.

    The published row holds the predicted acceleration fixed: -[(e_z + a/g) x] with (c_a^2 Q_a + sigma_w^2 +
    sigma_A^2)/g^2. But that acceleration came from the same orientation; substituting it leaves
    -(1 - c_a) [e_z x] with (sigma_w^2 + (1 + c_a^2) sigma_A^2)/g^2 (Luinge page, E-7), the default here.
    """
    share = settings[_ACCELERATION_GAIN]
    ux, uy = force[0] - share * acceleration[0], force[1] - share * acceleration[1]
    uz = force[2] - share * acceleration[2]
    square = ux * ux + uy * uy + uz * uz
    scale = 1.0 / math.sqrt(square)
    if settings[_HELD_ACCELERATION] > 0.0:
        found = held_gravity_taken(state, acceleration, spread_before, told, settings, pinned, ux, uy, scale)
    else:
        variance = settings[_TILT_VARIANCE]
        scale *= settings[_TILT_LEVER]
        p, d, e = state
        h = second_column(p, d)
        p, d, e = taken((p, d, e), told, 0, pinned, h, h[1] + variance, ux * scale - e[1])
        h = first_column(p, d)
        found = taken((p, d, e), told, 1, pinned, h, h[0] + variance, -uy * scale - e[0])
    free_fall = square <= 0.0
    return either_state(free_fall, state, found) if anywhere(free_fall) else found


@in_lanes(STATE(STATE, VECTOR_TYPE, VECTOR_TYPE, _TOLD, _SETTINGS, _M))
def field_taken(
    state: State, expected: Scalars3, field: Scalars3, told: Told, settings: Float, pinned: bool
) -> State:
    """Measure the field, in the earth frame over the norm of the reference: -[(H + d) x] xi - delta.

    Held to nothing the disturbance only adds its floor to the noise.
    """
    (mx, my, mz), (fx, fy, fz) = expected, field
    noise = settings[_FIELD_VARIANCE]
    p, d, e = state
    h = mixed(mz, second_column(p, d), -my, third_column(p, d))
    h = less(h, d[0], d[3], d[6], d[9], d[12], d[15], d[18], d[19], d[20])
    variance = (mz * h[1] - my * h[2]) + (noise - h[6])
    residual = ((fx - mx) + e[6]) - (mz * e[1] - my * e[2])
    p, d, e = taken((p, d, e), told, 2, pinned, h, variance, residual)
    h = mixed(mx, third_column(p, d), -mz, first_column(p, d))
    h = less(h, d[1], d[4], d[7], d[10], d[13], d[16], d[19], d[21], d[22])
    variance = (mx * h[2] - mz * h[0]) + (noise - h[7])
    residual = ((fy - my) + e[7]) - (mx * e[2] - mz * e[0])
    p, d, e = taken((p, d, e), told, 3, pinned, h, variance, residual)
    h = mixed(my, first_column(p, d), -mx, second_column(p, d))
    h = less(h, d[2], d[5], d[8], d[11], d[14], d[17], d[20], d[22], d[23])
    variance = (my * h[0] - mx * h[1]) + (noise - h[8])
    residual = ((fz - mz) + e[8]) - (my * e[0] - mx * e[1])
    return taken((p, d, e), told, 4, pinned, h, variance, residual)


@in_lanes(VECTOR_TYPE(UPPER, _SETTINGS))
def spread_after(p: Upper, settings: Float) -> Scalars3:
    """Return Q_a = g^2 [e_z x] P_xi [e_z x]' + sigma_A^2 I of the acceleration just measured: xx xy yy (page 2.3)."""
    square, noise = settings[_GRAVITY] ** 2, settings[_FORCE_VARIANCE]
    return square * p[3] + noise, -square * p[1], square * p[0] + noise


__all__ = ["field_taken", "gravity_taken", "spread_after"]
