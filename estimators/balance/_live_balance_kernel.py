"""Centre of mass over both feet while somebody walks: the loop, and the distance to the edge of the support.

State of one axis: position, velocity, error of the acceleration, and by how much the right foot is elsewhere than
its own way puts it. Both axes have the same noise and so share one covariance.
"""

import math

import numpy as np

from estimators._kernels import step
from estimators.recording import Float

APART, STATES = 3, 4
_COP = 3
"""Of a shoe's sample the force is first, then this."""
# What goes on from sample to sample.
KNOWN, COASTED_S, LAST_X, LAST_Y, OFFSET, CLIMB, EXCESS, LEVEL, RUN, RAW_SUM, RAW_COUNT = range(11)
BLOCK_SUM, BLOCK_COUNT, HAS_LEVEL, MEMORY = 11, 12, 13, 14
(
    S_STEP,
    S_GRAVITY,
    S_HEIGHT,
    S_FORCE2,
    S_BIAS2,
    S_ANCHOR2,
    S_STANDING2,
    S_APART2,
    S_WANDER2,
    S_PULL,
    S_AHEAD,
    SETTINGS,
) = range(12)
FORCE, COP, MASS, GOING, VELOCITY, SIGMA, MARGIN, SHIFT, WEIGHT, APART_SIGMA, OUT = (
    0,
    3,
    6,
    9,
    12,
    15,
    16,
    17,
    19,
    20,
    21,
)

_START2 = (0.05**2, 1.0**2, 0.1**2)
_SHOWN_S, _FORGOTTEN_S = 0.3, 1.0
"""Without forces of both feet the centre of mass goes on for so long; later it begins again."""
_WIDEST_M = 0.05
_REJOINED2 = 0.15**2
"""Of the shift of the right foot after one was put beside the other, m^2: half a step more or less."""
_BLOCK_S, _LEAST_WEIGHT_N, _CHANGE = 2.0, 150.0, 1.15
_LEAST_N, _ON_N = 100.0, 20.0
_STOOD_S = 0.75
_LEVEL_S = 1.0


@step("void(float64[::1], float64[:, ::1], float64[:, ::1], float64, float64, boolean)", inlined=True)
def _predict(settings: Float, x: Float, p: Float, now_x: float, now_y: float, moves: bool) -> None:
    """Go one step on: `c'' = a - b`, the acceleration linear between samples."""
    h = settings[S_STEP]
    g = -0.5 * h * h
    for r in range(STATES):
        # Rows of F P, then columns of (F P) F'.
        p[0, r] += h * p[1, r] + g * p[2, r]
        p[1, r] -= h * p[2, r]
    for r in range(STATES):
        p[r, 0] += h * p[r, 1] + g * p[r, 2]
        p[r, 1] -= h * p[r, 2]
    p[0, 0] += settings[S_FORCE2] * h * h * h / 3.0
    p[0, 1] += settings[S_FORCE2] * h * h / 2.0
    p[1, 0] = p[0, 1]
    p[1, 1] += settings[S_FORCE2] * h
    p[2, 2] += settings[S_BIAS2] * h
    if moves:
        p[APART, APART] += settings[S_WANDER2] * h


@step("void(float64[:, ::1], float64[:, ::1], float64[::1], float64, float64, float64)", inlined=True)
def _measure(x: Float, p: Float, row: Float, value_x: float, value_y: float, variance: float) -> None:
    """Update both axes with `row` times the state."""
    spread = np.empty(STATES)
    total = variance
    for r in range(STATES):
        spread[r] = 0.0
        for c in range(STATES):
            spread[r] += p[r, c] * row[c]
    for r in range(STATES):
        total += row[r] * spread[r]
    for axis in range(2):
        rest = value_x if axis == 0 else value_y
        for r in range(STATES):
            rest -= row[r] * x[axis, r]
        for r in range(STATES):
            x[axis, r] += spread[r] / total * rest
    for r in range(STATES):
        for c in range(r, STATES):
            p[r, c] -= spread[r] * spread[c] / total
            p[c, r] = p[r, c]


@step("float64(float64[:, :, :, ::1], int64, float64, float64, float64, float64, float64[:, ::1])")
def _margin(corners: Float, k: int, shift_x: float, shift_y: float, x: float, y: float, hull: Float) -> float:
    """Return how far inside the hull of the corners a point lies; NaN with fewer than three corners."""
    count = 0
    points = np.empty((16, 2))
    for s in range(2):
        for i in range(8):
            if not math.isnan(corners[s, k, i, 0]):
                points[count, 0] = corners[s, k, i, 0] + (shift_x if s == 1 else 0.0)
                points[count, 1] = corners[s, k, i, 1] + (shift_y if s == 1 else 0.0)
                count += 1
    if count < 3:
        return np.nan
    # Wrapped round from the lowest point: so few points need no sorting.
    first = 0
    for i in range(1, count):
        if points[i, 1] < points[first, 1] or (
            points[i, 1] == points[first, 1] and points[i, 0] < points[first, 0]
        ):
            first = i
    size, at = 0, first
    while size <= count:
        hull[size, 0], hull[size, 1] = points[at, 0], points[at, 1]
        size += 1
        best = 0 if at != 0 else 1
        for i in range(count):
            ax, ay = points[best, 0] - points[at, 0], points[best, 1] - points[at, 1]
            bx, by = points[i, 0] - points[at, 0], points[i, 1] - points[at, 1]
            cross = ax * by - ay * bx
            if cross < 0.0 or (cross == 0.0 and bx * bx + by * by > ax * ax + ay * ay):
                best = i
        at = best
        if points[at, 0] == points[first, 0] and points[at, 1] == points[first, 1]:
            break
    inside, nearest = np.inf, np.inf
    for i in range(size):
        j = (i + 1) % size
        ex, ey = hull[j, 0] - hull[i, 0], hull[j, 1] - hull[i, 1]
        wx, wy = x - hull[i, 0], y - hull[i, 1]
        square = ex * ex + ey * ey
        if square == 0.0:
            continue
        inside = min(inside, (ex * wy - ey * wx) / math.sqrt(square))
        part = min(max((wx * ex + wy * ey) / square, 0.0), 1.0)
        nearest = min(nearest, math.hypot(wx - part * ex, wy - part * ey))
    return inside if inside >= 0.0 else -nearest


@step("void(float64[::1], float64[::1], float64, boolean)")
def _weigh(settings: Float, memory: Float, raw_n: float, both: bool) -> None:
    """Take the mean load over blocks of two seconds for the weight; who sat before has stood up by the next."""
    if not both:
        memory[BLOCK_SUM], memory[BLOCK_COUNT] = 0.0, 0.0
        return
    memory[BLOCK_SUM] += raw_n
    memory[BLOCK_COUNT] += 1.0
    if memory[BLOCK_COUNT] * settings[S_STEP] >= _BLOCK_S:
        block = memory[BLOCK_SUM] / memory[BLOCK_COUNT]
        known = memory[RAW_SUM] / max(memory[RAW_COUNT], 1.0)
        if block > _LEAST_WEIGHT_N and (memory[RAW_COUNT] == 0.0 or block > _CHANGE * known):
            memory[RAW_SUM], memory[RAW_COUNT] = block, 1.0
        elif block > known / _CHANGE:
            memory[RAW_SUM] += block
            memory[RAW_COUNT] += 1.0
        memory[BLOCK_SUM], memory[BLOCK_COUNT] = 0.0, 0.0


@step("void(float64[::1], float64[::1], float64, float64)")
def _climb(settings: Float, memory: Float, up_mps2: float, level_m: float) -> None:
    """Integrate the vertical twice with a pull back to its mean, and follow the level of the floor."""
    h, pull = settings[S_STEP], settings[S_PULL]
    memory[EXCESS] += h * 0.1 * (up_mps2 - memory[EXCESS])
    memory[CLIMB] += h * (
        up_mps2 - memory[EXCESS] - 1.4 * pull * memory[CLIMB] - pull * pull * memory[OFFSET]
    )
    memory[OFFSET] += h * memory[CLIMB]
    if memory[HAS_LEVEL] == 0.0:
        memory[LEVEL], memory[HAS_LEVEL] = level_m, 1.0
    memory[LEVEL] += h / _LEVEL_S * (level_m - memory[LEVEL])


@step(
    "void(float64[::1], float64[:, :, ::1], float64[:, :, :, ::1], uint8[:, ::1], float64[:, ::1], float64[:, ::1],"
    " float64[::1], float64[:, ::1], float64[:, ::1], float64[:, ::1])"
)
def balance_live(
    settings: Float,
    shoes: Float,
    corners: Float,
    usable: "np.ndarray[tuple[int, int], np.dtype[np.uint8]]",
    up_n: Float,
    zero_n: Float,
    memory: Float,
    x: Float,
    p: Float,
    out: Float,
) -> None:
    """Take the next samples of both shoes.

    Parameters
    ----------
    settings : ndarray, shape (SETTINGS,)
    shoes : ndarray, shape (2, K, 6 or more)
        Force and pressure centre of each foot in the room, the feet as their own ways put them.
    corners : ndarray, shape (2, K, 8, 2)
        Of the soles on the floor.
    usable : ndarray of uint8, shape (2, K)
        2: measured, tared and placed; 1: measured, good enough to weigh; 0: nothing to go on. With 4 added: a foot
        that was lost was put beside the other just now, where feet usually are.
    up_n : ndarray, shape (2, K + ahead)
        Raw vertical load of each shoe, for the samples after these too; NaN where nothing was measured.
    zero_n : ndarray, shape (2, K)
        Zero of it by now.
    memory : ndarray, shape (MEMORY,)
    x : ndarray, shape (2, STATES)
    p : ndarray, shape (STATES, STATES)
        Memory, changed.
    out : ndarray, shape (K, OUT)
        Force (3), pressure centre (3), centre of mass (3), extrapolated centre (3), velocity (3), sigma of the centre
        of mass, margin of stability, shift of the right foot (2), weight, sigma of the shift; NaN where not known.
    """
    h, ahead = settings[S_STEP], int(settings[S_AHEAD])
    row, hull = np.zeros(STATES), np.empty((18, 2))
    for k in range(out.shape[0]):
        if (usable[0, k] | usable[1, k]) & 4:
            for axis in range(2):
                x[axis, APART] = 0.0
            p[APART, :] = 0.0
            p[:, APART] = 0.0
            p[APART, APART] = _REJOINED2
            memory[COASTED_S] = np.inf
        first, second = usable[0, k] & 3, usable[1, k] & 3
        result = out[k]
        result[:] = np.nan
        left, right = up_n[0, k + ahead] - zero_n[0, k], up_n[1, k + ahead] - zero_n[1, k]
        memory[RUN] = memory[RUN] + 1.0 if left > _ON_N and right > _ON_N else 0.0
        stands = memory[RUN] * h > _STOOD_S + ahead * h
        _weigh(settings, memory, up_n[0, k] + up_n[1, k], min(first, second) > 0)
        raw = memory[RAW_SUM] / max(memory[RAW_COUNT], 1.0)
        weight = raw - zero_n[0, k] - zero_n[1, k] if memory[RAW_COUNT] > 0.0 else 0.0
        result[WEIGHT] = weight if weight > 0.0 else np.nan
        fx, fy, fz = 0.0, 0.0, 0.0
        px, py, level, share = 0.0, 0.0, 0.0, 0.0
        both = first == 2 and second == 2
        if both:
            for s in range(2):
                fx += shoes[s, k, 0]
                fy += shoes[s, k, 1]
                fz += shoes[s, k, 2]
            # A foot without a pressure centre carries nothing that counts.
            carried = 0.0
            for s in range(2):
                if not math.isnan(shoes[s, k, _COP]):
                    carried += shoes[s, k, 2]
            if carried > _LEAST_N:
                for s in range(2):
                    if not math.isnan(shoes[s, k, _COP]):
                        part = shoes[s, k, 2] / carried
                        px += part * shoes[s, k, _COP]
                        py += part * shoes[s, k, _COP + 1]
                        level += part * shoes[s, k, _COP + 2]
                        share = part if s == 1 else share
            else:
                both = False
        is_felt = both and weight > 0.0
        now_x = settings[S_GRAVITY] * fx / weight if is_felt else 0.0
        now_y = settings[S_GRAVITY] * fy / weight if is_felt else 0.0
        if is_felt:
            _climb(settings, memory, settings[S_GRAVITY] * (fz / weight - 1.0), level)
            height = settings[S_HEIGHT] + memory[OFFSET]
            anchor_x, anchor_y = px + height * fx / fz, py + height * fy / fz
            if memory[KNOWN] == 0.0 or memory[COASTED_S] > _FORGOTTEN_S:
                shift_x, shift_y, shift2 = x[0, APART], x[1, APART], p[APART, APART]
                x[:] = 0.0
                p[:] = 0.0
                for i in range(3):
                    p[i, i] = _START2[i]
                if memory[KNOWN] == 0.0:
                    shift2 = settings[S_APART2]
                x[0, APART], x[1, APART], p[APART, APART] = shift_x, shift_y, shift2
                x[0, 0], x[1, 0] = anchor_x + share * shift_x, anchor_y + share * shift_y
                memory[KNOWN] = 1.0
            else:
                for axis in range(2):
                    before, now = memory[LAST_X + axis], now_x if axis == 0 else now_y
                    error = x[axis, 2]
                    x[axis, 0] += h * x[axis, 1] + h * h * (before / 3.0 + now / 6.0 - 0.5 * error)
                    x[axis, 1] += h * (0.5 * (before + now) - error)
                _predict(settings, x, p, now_x, now_y, not stands)
            memory[COASTED_S] = 0.0
            row[0], row[1], row[APART] = 1.0, 0.0, -share
            _measure(x, p, row, anchor_x, anchor_y, settings[S_ANCHOR2] / h)
            if stands:
                row[0], row[1], row[APART] = 0.0, 1.0, 0.0
                _measure(x, p, row, 0.0, 0.0, settings[S_STANDING2] / h)
        elif memory[KNOWN] > 0.0:
            memory[COASTED_S] += h
            if memory[COASTED_S] <= _FORGOTTEN_S:
                for axis in range(2):
                    x[axis, 0] += h * x[axis, 1]
                _predict(settings, x, p, 0.0, 0.0, True)
        memory[LAST_X], memory[LAST_Y] = now_x, now_y
        if both:
            result[FORCE], result[FORCE + 1], result[FORCE + 2] = fx, fy, fz
            result[COP], result[COP + 1] = px + share * x[0, APART], py + share * x[1, APART]
            result[COP + 2] = level
        if memory[KNOWN] > 0.0:
            result[SHIFT], result[SHIFT + 1] = x[0, APART], x[1, APART]
            result[APART_SIGMA] = math.sqrt(max(p[APART, APART], 0.0))
        sigma = math.sqrt(max(p[0, 0], 0.0))
        if memory[KNOWN] > 0.0 and memory[COASTED_S] <= _SHOWN_S and sigma < _WIDEST_M:
            high = settings[S_HEIGHT] + memory[OFFSET]
            slow = math.sqrt(high / settings[S_GRAVITY])
            result[SIGMA] = sigma
            for axis in range(2):
                result[MASS + axis], result[VELOCITY + axis] = x[axis, 0], x[axis, 1]
                result[GOING + axis] = x[axis, 0] + slow * x[axis, 1]
            result[MASS + 2], result[VELOCITY + 2] = memory[LEVEL] + high, memory[CLIMB]
            result[GOING + 2] = memory[LEVEL]
            if both:
                result[MARGIN] = _margin(
                    corners, k, x[0, APART], x[1, APART], result[GOING], result[GOING + 1], hull
                )
