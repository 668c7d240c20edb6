"""The magnetic side of Roetenberg's filter: reference, heading and flags, compiled. Fields are in the earth frame."""

import math

from estimators._kernels import Scalars3, multiply, rotate
from estimators.kernels import Record, step
from estimators.orientation._contract import OrientationFlag
from estimators.recording import Float
from published.roetenberg._model import STATES, forget_disturbance

_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_DISTURBED = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_LEAST_HORIZONTAL = 0.1
"""Horizontal share of the field below which it says nothing of heading (the poles, page 2.2)."""


@step()
def take_reference(x: Record, field_t: Scalars3) -> bool:
    """Take a field for the reference; false where it says nothing of heading."""
    east, north, up = field_t
    horizontal = math.hypot(east, north)
    norm = math.hypot(horizontal, up)
    if not horizontal > _LEAST_HORIZONTAL * norm:
        return False
    x.reference_norm, x.reference_dip = norm, math.atan2(-up, horizontal)
    x.reference_field[0] = 0.0
    x.reference_field[1], x.reference_field[2] = horizontal / norm, up / norm
    return True


@step()
def is_reference(x: Record, c: Record, field_t: Scalars3) -> bool:
    """Say whether norm and dip are those of the reference, within the guard (page 2.2, step 6)."""
    east, north, up = field_t
    horizontal = math.hypot(east, north)
    norm, dip = math.hypot(horizontal, up) / x.reference_norm, math.atan2(-up, horizontal)
    return bool(abs(norm - 1.0) <= c.guard_norm and abs(dip - x.reference_dip) <= c.guard_dip)


@step()
def face(x: Record, field_t: Scalars3) -> None:
    """Turn the estimate about the vertical so that this field points north."""
    half = 0.5 * math.atan2(field_t[0], field_t[1])
    x.q[0], x.q[1], x.q[2], x.q[3] = multiply(
        math.cos(half), 0.0, 0.0, math.sin(half), x.q[0], x.q[1], x.q[2], x.q[3]
    )


@step()
def begin_heading(x: Record, p: Float, c: Record) -> None:
    """Take the heading at a start from the mean field, if there is one and it is that of the reference."""
    forget_disturbance(x, p, c)
    x.nominal = x.mismatch = x.facing = x.is_detecting = x.is_pinned = 0
    x.heading_sum[0] = x.heading_sum[1] = x.heading_sum[2] = 0.0
    x.is_heading_known = 0
    count = x.field_collected
    if count == 0 or not c.use_field:
        return
    mean_t = rotate(
        x.q[0], x.q[1], x.q[2], x.q[3], x.sum_field[0] / count, x.sum_field[1] / count, x.sum_field[2] / count
    )
    if is_reference(x, c, mean_t) if x.reference_norm > 0.0 else take_reference(x, mean_t):
        face(x, mean_t)
        p[2, 2] = p[1, 1]
        x.is_heading_known = 1


@step()
def look_for_heading(x: Record, p: Float, c: Record, field_t: Scalars3) -> None:
    """While the heading is unknown, wait for as many samples of a sound field as at a start.

    With the heading its cross covariances are forgotten.
    """
    if x.reference_norm > 0.0 and not is_reference(x, c, field_t):
        x.facing = 0
        x.heading_sum[0] = x.heading_sum[1] = x.heading_sum[2] = 0.0
        return
    x.facing += 1
    x.heading_sum[0] += field_t[0]
    x.heading_sum[1] += field_t[1]
    x.heading_sum[2] += field_t[2]
    if x.facing < c.start_samples:
        return
    mean_t = x.heading_sum[0] / x.facing, x.heading_sum[1] / x.facing, x.heading_sum[2] / x.facing
    x.facing = 0
    x.heading_sum[0] = x.heading_sum[1] = x.heading_sum[2] = 0.0
    if x.reference_norm == 0.0 and not take_reference(x, mean_t):
        return
    face(x, mean_t)
    level = max(p[0, 0], p[1, 1])
    for i in range(3):
        for j in range(STATES):
            p[i, j] = p[j, i] = 0.0
        p[i, i] = level
        x.acceleration[i] = 0.0
    p[2, 2] += c.attitude_sigma**2
    forget_disturbance(x, p, c)
    x.is_heading_known = 1


@step(inlined=True)
def field_flags(x: Record, c: Record, heading_variance: float) -> int:
    """Return what the field and the heading's variance say."""
    flag = _DISTURBED if x.mismatch > 0 else 0
    if x.is_heading_known == 0 or x.mismatch > c.trust_ticks or heading_variance > c.heading_lost_variance:
        flag |= _NO_HEADING
    return flag
