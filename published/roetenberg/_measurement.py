"""The scalar measurements of Roetenberg's filter: direction of gravity and field, compiled.

Rows act on xi, the orientation error in the earth frame, and delta, the disturbance error there.
"""

import math
from typing import Final

from estimators._kernels import Scalars3
from estimators.kernels import Record, step
from estimators.recording import Float
from published._error_state import BASE, absorb, attitude_seen
from published.roetenberg._model import STATES

_NOTHING: Final = -1


@step(inlined=True)
def measure(
    x: Record,
    p: Float,
    sample: Record,
    errors: Float,
    h: Float,
    number: int,
    row: Scalars3,
    own: int,
    innovation: float,
    variance: float,
) -> None:
    """Take scalar measurement `number`: row . xi, less the disturbance's state `own` unless that is nothing.

    A disturbance that is held to nothing only adds its variance to the noise.
    """
    a, b, c = row
    attitude_seen(p, row, h)
    if own != _NOTHING:
        for k in range(own):
            h[k] -= p[k, own]
        for k in range(own, STATES):
            h[k] -= p[own, k]
        innovation, variance = innovation + errors[own], variance - h[own]
    residual = innovation - (a * errors[0] + b * errors[1] + c * errors[2])
    inverse = 1.0 / ((a * h[0] + b * h[1] + c * h[2]) + variance)
    sample.innovation[number], sample.inverse[number] = residual, inverse
    absorb(p, errors, h, residual, inverse, 0.0 if x.is_pinned else inverse)


@step()
def held_gravity(
    x: Record,
    p: Float,
    sample: Record,
    c: Record,
    errors: Float,
    h: Float,
    ux: float,
    uy: float,
    scale: float,
) -> None:
    """Measure the two horizontal parts with the predicted acceleration held fixed, as published.

    The row is -[(e_z + a/g) x] with noise (c_a^2 Q_a + sigma_w^2 + sigma_A^2)/g^2.
    """
    share, gravity = c.acceleration_gain, c.gravity
    vx, vy = share * x.acceleration[0] / gravity, share * x.acceleration[1] / gravity
    vz = 1.0 + share * x.acceleration[2] / gravity
    white = c.change_variance + c.force_variance
    rxx = (share * share * x.spread[0] + white) / gravity**2
    rxy = share * share * x.spread[1] / gravity**2
    ryy = (share * share * x.spread[2] + white) / gravity**2
    measure(x, p, sample, errors, h, 0, (0.0, vz, -vy), _NOTHING, ux * scale, rxx)
    # The second row less its share of the first has noise of its own.
    part = rxy / rxx
    row = -vz, -part * vz, vx + part * vy
    measure(x, p, sample, errors, h, 1, row, _NOTHING, (uy - part * ux) * scale, ryy - part * rxy)


@step(inlined=True)
def measure_gravity(
    x: Record, p: Float, sample: Record, c: Record, errors: Float, h: Float, force: Scalars3
) -> None:
    """Measure the direction of force less predicted acceleration, its two horizontal parts.

    The published row holds the predicted acceleration fixed. But that acceleration came from the same orientation;
    substituting it leaves -(1 - c_a) [e_z x] with (sigma_w^2 + (1 + c_a^2) sigma_A^2)/g^2 (Luinge page, E-7).
    """
    share = c.acceleration_gain
    ux, uy = force[0] - share * x.acceleration[0], force[1] - share * x.acceleration[1]
    uz = force[2] - share * x.acceleration[2]
    square = ux * ux + uy * uy + uz * uz
    if not square > 0.0:
        return
    scale = 1.0 / math.sqrt(square)
    if c.held_acceleration:
        held_gravity(x, p, sample, c, errors, h, ux, uy, scale)
        return
    scale *= c.tilt_lever
    measure(x, p, sample, errors, h, 0, (0.0, 1.0, 0.0), _NOTHING, ux * scale, c.tilt_variance)
    measure(x, p, sample, errors, h, 1, (1.0, 0.0, 0.0), _NOTHING, -uy * scale, c.tilt_variance)


@step(inlined=True)
def measure_field(
    x: Record, p: Float, sample: Record, c: Record, errors: Float, h: Float, field: Scalars3
) -> None:
    """Measure the field over the norm of the reference: -[(H + d) x] xi - delta (page 2.3)."""
    mx, my = x.reference_field[0] + x.disturbance[0], x.reference_field[1] + x.disturbance[1]
    mz = x.reference_field[2] + x.disturbance[2]
    noise = c.field_variance
    measure(x, p, sample, errors, h, 2, (0.0, mz, -my), BASE, field[0] - mx, noise)
    measure(x, p, sample, errors, h, 3, (-mz, 0.0, mx), BASE + 1, field[1] - my, noise)
    measure(x, p, sample, errors, h, 4, (my, -mx, 0.0), BASE + 2, field[2] - mz, noise)


@step(inlined=True)
def keep_spread(x: Record, p: Float, c: Record) -> None:
    """Keep Q_a = g^2 [e_z x] P_xi [e_z x]' + sigma_A^2 I of the acceleration just measured: xx xy yy (page 2.3)."""
    square = c.gravity**2
    x.spread[0] = square * p[1, 1] + c.force_variance
    x.spread[1] = -square * p[0, 1]
    x.spread[2] = square * p[0, 0] + c.force_variance
