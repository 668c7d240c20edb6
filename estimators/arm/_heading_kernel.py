"""The compiled filter behind `_heading_constraint`: one small Kalman filter a joint, at an even lower rate.

States of one joint::

    0  offset      heading that the child's frame lacks against the parent's, rad
    1  drift       its rate, rad/s, a first-order Gauss-Markov process
    2  constant    carrying angle and its calibration error, rad
    3, 4           tilt of the parent's axis toward its two other axes, rad
    5, 6           tilt of the child's axis, rad
    7  posture     what else the joint does, rad: forgotten with the way that the joint travels

Measured is that this is nought, with M = R_parent' Rz(offset) R_child and unit axes u, v and w (the others)::

    u'Mv + x3 w1'Mv + x4 w2'Mv + x5 u'Mw1 + x6 u'Mw2 + x2 + x7
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply
from estimators.arm._angle_kernel import matrix_of
from estimators.kernels import VOID, bundle, step

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Flags = NDArray[np.uint8]

OFFSET_STATE, DRIFT_STATE, CONSTANT_STATE = 0, 1, 2
PARENT_TILT_STATES, CHILD_TILT_STATES, POSTURE_STATE, STATES = 3, 5, 7, 8
(
    INITIAL, DRIFT, DRIFT_TIME, WALK, TRAVEL_WALK, GAP_WALK, CONSTANT, PARENT_TILT, CHILD_TILT,
    POSTURE, POSTURE_TRAVEL, POSTURE_TIME, NOISE, LEAST_SENSITIVITY, REFERENCE, REFERENCE_TIME,
    FLOOR, SLEW_RATE, SLEW_TIME,
) = range(19)  # fmt: skip
"""Places in a joint's row of parameters; see `HeadingConstraintParameters`."""
PARAMETERS = 19

APPLIED, INFORMED, RESIDUAL = range(3)
MEMORY = 3
"""Per joint between ticks: the correction applied so far, and the last interval's report."""

_GATE = 3.0
_UNKNOWN_VARIANCE = math.pi**2 / 3.0
"""Variance of a heading about which nothing is known."""


@step("UniTuple(f8, 2)(f8[:, ::1], f8[:, ::1], f8, i8, i8)")
def _between(parent: Float, child: Float, offset: float, u: int, v: int) -> tuple[float, float]:
    """Return cosine between an axis of each after the heading turn, and its derivative by the offset."""
    cosine, sine = math.cos(offset), math.sin(offset)
    x = cosine * child[0, v] - sine * child[1, v]
    y = sine * child[0, v] + cosine * child[1, v]
    return parent[0, u] * x + parent[1, u] * y + parent[2, u] * child[2, v], parent[1, u] * x - parent[
        0, u
    ] * y


@step("f8(f8[:, ::1], f8[:, ::1], f8, i8, i8, f8[::1], f8[::1])")
def predict_constraint(
    parent: Float, child: Float, offset: float, u: int, v: int, x: Float, row: Float
) -> float:
    """Return the constraint's value at the states `x` and fill its derivatives `row` (8,)."""
    u1, u2, v1, v2 = (u + 1) % 3, (u + 2) % 3, (v + 1) % 3, (v + 2) % 3
    value, slope = _between(parent, child, offset, u, v)
    first, second = PARENT_TILT_STATES, PARENT_TILT_STATES + 1
    third, fourth = CHILD_TILT_STATES, CHILD_TILT_STATES + 1
    row[OFFSET_STATE] = slope
    row[DRIFT_STATE] = 0.0
    row[CONSTANT_STATE] = row[POSTURE_STATE] = 1.0
    row[first], slope = _between(parent, child, offset, u1, v)
    row[OFFSET_STATE] += x[first] * slope
    row[second], slope = _between(parent, child, offset, u2, v)
    row[OFFSET_STATE] += x[second] * slope
    row[third], slope = _between(parent, child, offset, u, v1)
    row[OFFSET_STATE] += x[third] * slope
    row[fourth], slope = _between(parent, child, offset, u, v2)
    row[OFFSET_STATE] += x[fourth] * slope
    tilts = x[first] * row[first] + x[second] * row[second] + x[third] * row[third] + x[fourth] * row[fourth]
    return float(value + tilts + x[CONSTANT_STATE] + x[POSTURE_STATE])


@step("f8(f8[::1], f8[::1])")
def _travelled(relative: Float, last: Float) -> float:
    """Angle between two relative orientations, and the newer one retained; nought for the first."""
    if last[0] != last[0]:
        angle = 0.0
    else:
        dot = abs(
            relative[0] * last[0] + relative[1] * last[1] + relative[2] * last[2] + relative[3] * last[3]
        )
        angle = 2.0 * math.acos(min(dot, 1.0))
    for i in range(4):
        last[i] = relative[i]
    return angle


@step("void(f8[:, ::1], f8[::1], f8[::1], f8)")
def _predict(p: Float, x: Float, par: Float, interval: float) -> None:
    """Let the offset drift for one interval."""
    keep = math.exp(-interval / par[DRIFT_TIME])
    x[OFFSET_STATE] += interval * x[DRIFT_STATE]
    x[DRIFT_STATE] *= keep
    for i in range(STATES):
        p[OFFSET_STATE, i] += interval * p[DRIFT_STATE, i]
        p[DRIFT_STATE, i] *= keep
    for i in range(STATES):
        p[i, OFFSET_STATE] += interval * p[i, DRIFT_STATE]
        p[i, DRIFT_STATE] *= keep
    p[DRIFT_STATE, DRIFT_STATE] += par[DRIFT] ** 2 * (1.0 - keep * keep)
    p[OFFSET_STATE, OFFSET_STATE] += par[WALK] ** 2 * interval


@step("f8(f8[:, ::1], f8[::1], f8[::1], f8, f8, b1)")
def _correct(p: Float, x: Float, row: Float, value: float, noise: float, is_sensitive: bool) -> float:
    """Measure nought and return the normalised innovation; without sensitivity offset and drift stay as they are.

    Joseph's form, which holds for any gain.
    """
    spread = np.empty(STATES)
    total = noise
    for i in range(STATES):
        spread[i] = 0.0
        for m in range(STATES):
            spread[i] += p[i, m] * row[m]
        total += row[i] * spread[i]
    normalised = abs(value) / math.sqrt(total)
    if normalised > _GATE:
        # Taken for less, down to the pull of a deviation at the gate.
        grown = total * (normalised / _GATE) ** 2
        noise += grown - total
        total = grown
    gain = spread / total
    if not is_sensitive:
        gain[OFFSET_STATE] = 0.0
        gain[DRIFT_STATE] = 0.0
    for i in range(STATES):
        x[i] -= gain[i] * value
    # P - K s' - s K' + K S K'
    for i in range(STATES):
        for m in range(i + 1):
            p[i, m] += gain[i] * gain[m] * total - gain[i] * spread[m] - spread[i] * gain[m]
            p[m, i] = p[i, m]
    return normalised


@step()
def _forget_posture(p: Float, x: Float, keep: float) -> None:
    """Let the posture go by the factor `keep`."""
    x[POSTURE_STATE] *= keep
    for i in range(STATES):
        p[POSTURE_STATE, i] *= keep
    for i in range(STATES):
        p[i, POSTURE_STATE] *= keep


@step()
def _bound(p: Float) -> None:
    """Let the heading be known no worse than one about which nothing is known."""
    if p[OFFSET_STATE, OFFSET_STATE] > _UNKNOWN_VARIANCE:
        shrink = math.sqrt(_UNKNOWN_VARIANCE / p[OFFSET_STATE, OFFSET_STATE])
        for i in range(STATES):
            p[OFFSET_STATE, i] *= shrink
        for i in range(STATES):
            p[i, OFFSET_STATE] *= shrink


@step()
def _measure(
    a: Float,
    b: Float,
    axes: Integer,
    par: Float,
    interval: float,
    x: Float,
    p: Float,
    last: Float,
    memory: Float,
) -> None:
    """Take one pair of orientations that can be used."""
    relative, parent, child = np.empty(4), np.empty((3, 3)), np.empty((3, 3))
    turned = multiply(a[0], -a[1], -a[2], -a[3], b[0], b[1], b[2], b[3])
    for i in range(4):
        relative[i] = turned[i]
    travel = _travelled(relative, last)
    keep = math.exp(-travel / par[POSTURE_TRAVEL] - interval / par[POSTURE_TIME])
    _forget_posture(p, x, keep)
    p[POSTURE_STATE, POSTURE_STATE] += par[POSTURE] ** 2 * (1.0 - keep * keep)
    p[OFFSET_STATE, OFFSET_STATE] += par[TRAVEL_WALK] ** 2 * travel
    matrix_of(a, parent)
    matrix_of(b, child)
    row = np.empty(STATES)
    value = predict_constraint(parent, child, x[OFFSET_STATE], axes[0], axes[1], x, row)
    is_sensitive = abs(row[OFFSET_STATE]) >= par[LEAST_SENSITIVITY]
    _correct(p, x, row, value, par[NOISE] ** 2, is_sensitive)
    memory[INFORMED] = 1.0 if is_sensitive else 0.0
    memory[RESIDUAL] = value


@step()
def _draw_to_zero(par: Float, interval: float, x: Float, p: Float) -> None:
    """Measure that both magnetometers, which are trusted, share one heading."""
    alone = np.zeros(STATES)
    alone[OFFSET_STATE] = 1.0
    _correct(p, x, alone, x[OFFSET_STATE], par[REFERENCE] ** 2 * par[REFERENCE_TIME] / interval, True)


class Carried(NamedTuple):
    """What J joints carry from tick to tick: state (J, 8), covariance (J, 8, 8), relative (J, 4), memory (J, 3)."""

    state: Float
    covariance: Float
    last_relative: Float
    memory: Float


class Corrections(NamedTuple):
    """What `constrain` fills, each (K, J)."""

    offset_rad: Float
    sigma_rad: Float
    correction_rad: Float
    is_informed: Flags
    residual_rad: Float


_TABLE, _CUBE = types.float64[:, ::1], types.float64[:, :, ::1]
_CARRIED = bundle(Carried, _TABLE, _CUBE, _TABLE, _TABLE)
_FILLED = bundle(Corrections, _TABLE, _TABLE, _TABLE, types.uint8[:, ::1], _TABLE)
_MASK, _WHOLE = types.boolean[:, ::1], types.int64


@kernel(
    VOID(_CUBE, _CUBE, _MASK, _MASK, _WHOLE, _WHOLE, types.float64, _WHOLE[:, ::1], _TABLE, _CARRIED, _FILLED)
)
def constrain(
    q_parent: Float,
    q_child: Float,
    usable: NDArray[np.bool_],
    referenced: NDArray[np.bool_],
    first_tick: int,
    stride: int,
    step_s: float,
    axes: Integer,
    parameters: Float,
    carried: Carried,
    out: Corrections,
) -> None:
    """Fill the corrections of K ticks and carry the joints on.

    `axes` (J, 2): number of the parent's and of the child's axis that stay at right angles.
    """
    interval = stride * step_s
    for j in range(q_parent.shape[1]):
        par, x, p = parameters[j], carried.state[j], carried.covariance[j]
        memory = carried.memory[j]
        slew_keep = math.exp(-step_s / par[SLEW_TIME])
        for k in range(q_parent.shape[0]):
            if (first_tick + k) % stride == 0:
                _predict(p, x, par, interval)
                memory[INFORMED] = 0.0
                memory[RESIDUAL] = math.nan
                if usable[k, j]:
                    last = carried.last_relative[j]
                    _measure(q_parent[k, j], q_child[k, j], axes[j], par, interval, x, p, last, memory)
                    if referenced[k, j]:
                        _draw_to_zero(par, interval, x, p)
                else:
                    p[OFFSET_STATE, OFFSET_STATE] += par[GAP_WALK] ** 2 * interval
                _bound(p)
            lag = (1.0 - slew_keep) * (x[OFFSET_STATE] - memory[APPLIED])
            most = par[SLEW_RATE] * step_s
            memory[APPLIED] += min(max(lag, -most), most)
            behind = x[OFFSET_STATE] - memory[APPLIED]
            out.offset_rad[k, j] = x[OFFSET_STATE]
            out.correction_rad[k, j] = memory[APPLIED]
            out.sigma_rad[k, j] = math.sqrt(p[OFFSET_STATE, OFFSET_STATE] + behind * behind + par[FLOOR] ** 2)
            out.is_informed[k, j] = np.uint8(memory[INFORMED])
            out.residual_rad[k, j] = memory[RESIDUAL]
