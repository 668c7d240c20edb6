"""The scalar measurements of Roetenberg's filter: direction of gravity and field, compiled.

Rows act on xi, the orientation error in the earth frame, and delta, the disturbance error there. The noises are
independent, so that one row after the other is the joint update.
"""

import math

from estimators._kernels import kernel
from estimators.orientation import _roetenberg_layout as at
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._strapdown_kernel import Row, lessen
from estimators.orientation._strapdown_steps import force_without_acceleration
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_INNOVATION, _ACCELERATION = steps.INNOVATION, steps.ACCELERATION
_ACCELERATION_GAIN, _GRAVITY = steps.ACCELERATION_GAIN, steps.GRAVITY
_HELD_ACCELERATION, _CHANGE_VARIANCE = at.HELD_ACCELERATION, at.CHANGE_VARIANCE
_FORCE_VARIANCE, _FIELD_VARIANCE, _FLOOR_VARIANCE = at.FORCE_VARIANCE, at.FIELD_VARIANCE, at.FLOOR_VARIANCE
_REFERENCE_FIELD, _DISTURBANCE, _SPREAD = at.REFERENCE_FIELD, at.DISTURBANCE, at.SPREAD


@kernel("UniTuple(float64, 9)(float64[:, ::1], int64)", inlined=True)
def column(p: Float, i: int) -> Row:
    """Return a column of the covariance from its upper triangle; the number is a constant to the compiler."""
    return (
        p[0, i],
        p[1, i] if i >= 1 else p[i, 1],
        p[2, i] if i >= 2 else p[i, 2],
        p[3, i] if i >= 3 else p[i, 3],
        p[4, i] if i >= 4 else p[i, 4],
        p[5, i] if i >= 5 else p[i, 5],
        p[6, i] if i >= 6 else p[i, 6],
        p[7, i] if i >= 7 else p[i, 7],
        p[8, i] if i >= 8 else p[i, 8],
    )


@kernel(
    "void(float64[:, ::1], float64[::1], float64[::1], int64, int64, UniTuple(float64, 9), float64, float64)",
    inlined=True,
)
def take(
    p: Float,
    error: Float,
    sample: Float,
    number: int,
    states: int,
    h: Row,
    variance: float,
    residual: float,
) -> None:
    """Take a scalar measurement with h = P H', its innovation and the variance of that, H P H' + R.

    `error` gathers what is found, `sample` the innovation. With six `states` the disturbance is left out.
    """
    h0, h1, h2, h3, h4, h5, h6, h7, h8 = h
    inverse = 1.0 / variance
    gain = inverse * residual
    sample[_INNOVATION + 2 * number], sample[_INNOVATION + 2 * number + 1] = residual, inverse
    error[0] += gain * h0
    error[1] += gain * h1
    error[2] += gain * h2
    error[3] += gain * h3
    error[4] += gain * h4
    error[5] += gain * h5
    lessen(p, inverse, h0, h1, h2, h3, h4, h5)
    if states == 6:
        return
    error[6] += gain * h6
    error[7] += gain * h7
    error[8] += gain * h8
    g6, g7, g8 = inverse * h6, inverse * h7, inverse * h8
    for j, other in enumerate((h0, h1, h2, h3, h4, h5)):
        p[j, 6] -= other * g6
        p[j, 7] -= other * g7
        p[j, 8] -= other * g8
    p[6, 6] -= g6 * h6
    p[6, 7] -= g6 * h7
    p[6, 8] -= g6 * h8
    p[7, 7] -= g7 * h7
    p[7, 8] -= g7 * h8
    p[8, 8] -= g8 * h8


@kernel(
    "void(float64[:, ::1], float64[::1], float64[::1], int64, int64, float64, float64, float64, float64, float64)"
)
def take_tilt(
    p: Float,
    error: Float,
    sample: Float,
    number: int,
    states: int,
    c0: float,
    c1: float,
    c2: float,
    innovation: float,
    variance: float,
) -> None:
    """Take a scalar measurement of any combination of the orientation errors."""
    a, b, c = column(p, 0), column(p, 1), column(p, 2)
    h = (
        c0 * a[0] + c1 * b[0] + c2 * c[0],
        c0 * a[1] + c1 * b[1] + c2 * c[1],
        c0 * a[2] + c1 * b[2] + c2 * c[2],
        c0 * a[3] + c1 * b[3] + c2 * c[3],
        c0 * a[4] + c1 * b[4] + c2 * c[4],
        c0 * a[5] + c1 * b[5] + c2 * c[5],
        c0 * a[6] + c1 * b[6] + c2 * c[6],
        c0 * a[7] + c1 * b[7] + c2 * c[7],
        c0 * a[8] + c1 * b[8] + c2 * c[8],
    )
    residual = innovation - (c0 * error[0] + c1 * error[1] + c2 * error[2])
    take(p, error, sample, number, states, h, c0 * h[0] + c1 * h[1] + c2 * h[2] + variance, residual)


@kernel(
    "void(float64[:, ::1], int64, float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64[::1],"
    "int64)",
    inlined=True,
)
def measure_gravity(
    q: Float, s: int, p: Float, memory: Float, sample: Float, settings: Float, error: Float, states: int
) -> None:
    """Measure the direction of force less predicted acceleration, its two horizontal parts.

    The published row holds the predicted acceleration fixed: -[(e_z + a/g) x] with (c_a^2 Q_a + sigma_w^2 +
    sigma_A^2)/g^2. But that acceleration came from the same orientation; substituting it leaves
    -(1 - c_a) [e_z x] with (sigma_w^2 + (1 + c_a^2) sigma_A^2)/g^2 (Luinge page, E-7), the default here.
    """
    ux, uy, uz = force_without_acceleration(s, q, memory, sample, settings)
    square = ux * ux + uy * uy + uz * uz
    if not square > 0.0:
        return
    scale = 1.0 / math.sqrt(square)
    share, gravity = settings[_ACCELERATION_GAIN], settings[_GRAVITY]
    if settings[_HELD_ACCELERATION] > 0.0:
        vx, vy = share * memory[s, _ACCELERATION] / gravity, share * memory[s, _ACCELERATION + 1] / gravity
        vz = 1.0 + share * memory[s, _ACCELERATION + 2] / gravity
        white = settings[_CHANGE_VARIANCE] + settings[_FORCE_VARIANCE]
        rxx = (share * share * memory[s, _SPREAD] + white) / gravity**2
        rxy = share * share * memory[s, _SPREAD + 1] / gravity**2
        ryy = (share * share * memory[s, _SPREAD + 2] + white) / gravity**2
        # The second row less its share of the first has noise of its own.
        part = rxy / rxx
        take_tilt(p, error, sample, 0, states, 0.0, vz, -vy, ux * scale, rxx)
        take_tilt(
            p,
            error,
            sample,
            1,
            states,
            -vz,
            -part * vz,
            vx + part * vy,
            (uy - part * ux) * scale,
            ryy - part * rxy,
        )
        return
    lever = 1.0 / (1.0 - share)
    variance = settings[_CHANGE_VARIANCE] + (1.0 + share * share) * settings[_FORCE_VARIANCE]
    variance *= (lever / gravity) ** 2
    h = column(p, 1)
    take(p, error, sample, 0, states, h, h[1] + variance, ux * scale * lever - error[1])
    h = column(p, 0)
    take(p, error, sample, 1, states, h, h[0] + variance, -uy * scale * lever - error[0])


@kernel("UniTuple(float64, 9)(float64, UniTuple(float64, 9), float64, UniTuple(float64, 9))", inlined=True)
def mixed(a: float, first: Row, b: float, second: Row) -> Row:
    """Return a * first + b * second."""
    return (
        a * first[0] + b * second[0],
        a * first[1] + b * second[1],
        a * first[2] + b * second[2],
        a * first[3] + b * second[3],
        a * first[4] + b * second[4],
        a * first[5] + b * second[5],
        a * first[6] + b * second[6],
        a * first[7] + b * second[7],
        a * first[8] + b * second[8],
    )


@kernel("UniTuple(float64, 9)(UniTuple(float64, 9), UniTuple(float64, 9))", inlined=True)
def less(first: Row, second: Row) -> Row:
    """Return first - second."""
    return (
        first[0] - second[0],
        first[1] - second[1],
        first[2] - second[2],
        first[3] - second[3],
        first[4] - second[4],
        first[5] - second[5],
        first[6] - second[6],
        first[7] - second[7],
        first[8] - second[8],
    )


@kernel(
    "void(int64, float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64[::1], int64, float64,"
    "float64, float64)",
    inlined=True,
)
def measure_field(
    s: int,
    p: Float,
    memory: Float,
    sample: Float,
    settings: Float,
    error: Float,
    states: int,
    fx: float,
    fy: float,
    fz: float,
) -> None:
    """Measure the field, in the earth frame over the norm of the reference: -[(H + d) x] xi - delta.

    Held to nothing the disturbance only adds its floor to the noise.
    """
    mx = memory[s, _REFERENCE_FIELD] + memory[s, _DISTURBANCE]
    my = memory[s, _REFERENCE_FIELD + 1] + memory[s, _DISTURBANCE + 1]
    mz = memory[s, _REFERENCE_FIELD + 2] + memory[s, _DISTURBANCE + 2]
    variance = settings[_FIELD_VARIANCE]
    if states == 6:
        variance += settings[_FLOOR_VARIANCE]
        h = mixed(mz, column(p, 1), -my, column(p, 2))
        residual = fx - mx - (mz * error[1] - my * error[2])
        take(p, error, sample, 2, 6, h, mz * h[1] - my * h[2] + variance, residual)
        h = mixed(mx, column(p, 2), -mz, column(p, 0))
        residual = fy - my - (mx * error[2] - mz * error[0])
        take(p, error, sample, 3, 6, h, mx * h[2] - mz * h[0] + variance, residual)
        h = mixed(my, column(p, 0), -mx, column(p, 1))
        residual = fz - mz - (my * error[0] - mx * error[1])
        take(p, error, sample, 4, 6, h, my * h[0] - mx * h[1] + variance, residual)
        return
    h = less(mixed(mz, column(p, 1), -my, column(p, 2)), column(p, 6))
    residual = fx - mx - (mz * error[1] - my * error[2] - error[6])
    take(p, error, sample, 2, 9, h, mz * h[1] - my * h[2] - h[6] + variance, residual)
    h = less(mixed(mx, column(p, 2), -mz, column(p, 0)), column(p, 7))
    residual = fy - my - (mx * error[2] - mz * error[0] - error[7])
    take(p, error, sample, 3, 9, h, mx * h[2] - mz * h[0] - h[7] + variance, residual)
    h = less(mixed(my, column(p, 0), -mx, column(p, 1)), column(p, 8))
    residual = fz - mz - (my * error[0] - mx * error[1] - error[8])
    take(p, error, sample, 4, 9, h, my * h[0] - mx * h[1] - h[8] + variance, residual)


@kernel("void(int64, float64[:, ::1], float64[:, ::1], float64[::1])")
def keep_spread(s: int, p: Float, memory: Float, settings: Float) -> None:
    """Keep Q_a = g^2 [e_z x] P_xi [e_z x]' + sigma_A^2 I of the acceleration just measured (page 2.3)."""
    square = settings[_GRAVITY] ** 2
    memory[s, _SPREAD] = square * p[1, 1] + settings[_FORCE_VARIANCE]
    memory[s, _SPREAD + 1] = -square * p[0, 1]
    memory[s, _SPREAD + 2] = square * p[0, 0] + settings[_FORCE_VARIANCE]


__all__ = ["keep_spread", "measure_field", "measure_gravity"]
