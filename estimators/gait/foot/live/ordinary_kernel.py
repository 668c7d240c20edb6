"""The live foot filter where nothing is missing, bridged or cut off, compiled: the same bits as `FootStream`.

Nearly every moment of a walk is such. Whatever else comes changes nothing here and is left to `FootStream`, over the
same rows.
"""

import math
from typing import Final

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.compiling import compiled
from estimators.gait._stance import UNREST
from estimators.gait._stance_kernel import decide, noise_densities, stance_statistic
from estimators.gait.foot import layout as at
from estimators.gait.foot.kernel import FootState, FootTicks, Trace, backward, forward
from estimators.gait.foot.live.rows import FIELD, FOOT_ROWS, PIECE_TICKS, SIZES, FootRows, Sizes
from estimators.gait.foot.live.stream import TILT_KNOWN_RAD
from estimators.gait.foot.trajectory import FootFlag
from estimators.kernels import VOID, step
from estimators.recording import Float

_STATE: Final = at.STATE
_SIGMA, _TILT_X, _TILT_Y = at.POSITION_SIGMA, at.ATTITUDE_SIGMA, at.ATTITUDE_SIGMA + 1
_T, _STANDS = at.STATISTIC, at.STANDS
_STANCE, _HEADING, _STARTED = at.STANCE, at.HEADING, at.STARTED
_NO_STANCE: Final = int(FootFlag.NO_STANCE)
_F1, _F3 = types.float64[::1], types.float64[:, :, ::1]
_SAMPLES: Final = types.Array(types.float64, 3, "A", readonly=True)

TAKE: Final = types.boolean(
    FOOT_ROWS, types.int64, _SAMPLES, _SAMPLES, _SAMPLES, types.Array(types.uint8, 2, "A", readonly=True)
)
RELEASE: Final = VOID(
    FOOT_ROWS, types.int64, SIZES, types.float64, types.float64, _F1, _F1, _F1, _F1, _F3, types.uint8[:, ::1]
)


@step()
def _are_ordinary(
    rows: FootRows, first: int, gyroscope: Float, force: Float, quality: NDArray[np.uint8]
) -> bool:
    """Say whether every foot has begun, and nothing buffered or new is flawed."""
    feet, ticks = quality.shape
    if ticks > PIECE_TICKS:
        return False
    for n in range(feet):
        s = first + n
        x = rows.foot[s]
        if (
            x.first < 0
            or x.released < x.first
            or x.flawed_stop > x.origin
            or x.gap > 0
            or x.filtered < x.wary
            or rows.memory[s, _STARTED] == 0.0
        ):
            return False
        for k in range(ticks):
            total = 0.0
            for a in range(3):
                total += gyroscope[n, k, a] + force[n, k, a]
            if quality[n, k] != 0 or not math.isfinite(total):
                return False
    return True


@step()
def _to_front(s: int, rows: FootRows) -> None:
    """Move what is buffered to the start of its room."""
    x = rows.foot[s]
    first = x.place
    for k in range(x.stop - x.origin):
        for a in range(3):
            rows.gyroscope[s, k, a] = rows.gyroscope[s, first + k, a]
            rows.force[s, k, a] = rows.force[s, first + k, a]
            rows.field[s, k, a] = rows.field[s, first + k, a]
        rows.kind[s, k] = rows.kind[s, first + k]
        rows.statistic[s, k] = rows.statistic[s, first + k]
    x.place = 0


@compiled(TAKE)
def take(
    rows: FootRows,
    first: int,
    gyroscope: Float,
    force: Float,
    field: Float,
    quality: NDArray[np.uint8],
) -> bool:
    """Append the next samples of some feet; False, and nothing changed, where they or a foot are not as usual.

    Parameters
    ----------
    first : int
        Row of the first of S feet.
    gyroscope, force : ndarray, shape (S, K, 3)
    field : ndarray, shape (S, K, 3) or (0, 0, 3)
    quality : ndarray of uint8, shape (S, K)
        `SampleQuality` bits.
    """
    if not _are_ordinary(rows, first, gyroscope, force, quality):
        return False
    feet, ticks = quality.shape
    for n in range(feet):
        s = first + n
        x = rows.foot[s]
        end = x.place + x.stop - x.origin
        if end + ticks > rows.kind.shape[1]:
            _to_front(s, rows)
            end = x.stop - x.origin
        for k in range(ticks):
            has_field = field.shape[0] > 0
            if has_field:
                for a in range(3):
                    has_field &= math.isfinite(field[n, k, a])
            for a in range(3):
                rows.gyroscope[s, end + k, a] = gyroscope[n, k, a]
                rows.force[s, end + k, a] = force[n, k, a]
                rows.field[s, end + k, a] = field[n, k, a] if has_field else 0.0
                rows.largest[s, 0] = max(rows.largest[s, 0], abs(gyroscope[n, k, a]))
                rows.largest[s, 1] = max(rows.largest[s, 1], abs(force[n, k, a]))
                rows.last_good[s, a] = force[n, k, a]
            rows.kind[s, end + k] = FIELD if has_field else 0
        x.stop += ticks
    return True


@step()
def _judged_to_front(s: int, rows: FootRows) -> None:
    """Move what is judged to the start of its room."""
    x = rows.foot[s]
    for k in range(x.judged):
        for i in range(3):
            rows.inputs[s, i, k] = rows.inputs[s, i, x.judged_place + k]
            rows.rate_variance[s, k, i] = rows.rate_variance[s, x.judged_place + k, i]
        rows.bits[s, k] = rows.bits[s, x.judged_place + k]
    x.judged_place = 0


@step()
def _judge(
    s: int, end: int, rows: FootRows, sizes: Sizes, scales: Float, decision: Float, noise: Float
) -> None:
    """Bring T as far as the samples go, and judge the ticks before `end` that are not judged."""
    x = rows.foot[s]
    place, count = x.place, x.stop - x.origin
    gyroscope, force = rows.gyroscope[s, place : place + count], rows.force[s, place : place + count]
    stop = count - sizes.half
    if stop > x.known:
        stance_statistic(
            gyroscope,
            force,
            x.known,
            stop,
            sizes.half,
            scales[0],
            scales[1],
            rows.statistic[s, place : place + stop],
        )
        x.known = stop
    first = x.released + x.judged
    new = end - first
    if new <= 0:
        return
    if x.judged_place + x.judged + new > rows.bits.shape[1]:
        _judged_to_front(s, rows)
    a = x.judged_place + x.judged
    b = a + new
    x.judged += new
    # Nothing beyond the ticks that every chunking has seen may count.
    horizon = min(x.known, end - x.origin + sizes.ahead - sizes.half)
    decide(
        rows.statistic[s, place : place + horizon],
        x.origin,
        first,
        end,
        sizes.stride,
        sizes.before,
        sizes.after,
        sizes.alone,
        decision,
        np.empty(new),
        rows.inputs[s, 0, a:b],
        rows.bits[s, a:b],
    )
    at_first = first - x.origin
    noise_densities(
        gyroscope,
        force,
        np.empty(0),
        rows.kind[s, :0],
        at_first,
        at_first + new,
        noise,
        rows.inputs[s, 2, a:b],
        rows.rate_variance[s, a:b],
    )
    for k in range(new):
        rows.inputs[s, 1, a + k] = rows.statistic[s, place + at_first + k]
        if rows.kind[s, place + at_first + k] & FIELD and rows.bits[s, a + k] & _STANCE:
            rows.bits[s, a + k] |= _HEADING


@step()
def _filter(s: int, boundary: int, rows: FootRows, sizes: Sizes, step_s: float, settings: Float) -> None:
    """Run the filter up to a boundary, block by block, and note where it stands at the start of each."""
    x = rows.foot[s]
    start = x.filtered
    while start < boundary:
        stop = min(start + sizes.block - start % sizes.block, boundary)
        mark = rows.mark[s, x.marks]
        mark.start, mark.gap, mark.wary = start, 0, x.wary
        rows.mark_x[s, x.marks] = rows.x[s]
        rows.mark_p[s, x.marks] = rows.p[s]
        rows.mark_memory[s, x.marks] = rows.memory[s]
        x.marks += 1
        raw, last_raw = x.place + start - x.origin, x.place + stop - x.origin
        a, b = x.judged_place + start - x.released, x.judged_place + stop - x.released
        r, t = x.base + start - x.released, x.base + stop - x.released
        samples = FootTicks(
            np.full(stop - start, step_s),
            rows.gyroscope[s, raw:last_raw],
            rows.force[s, raw:last_raw],
            rows.inputs[s, 0, a:b],
            rows.bits[s, a:b],
            rows.inputs[s, 2, a:b],
            rows.rate_variance[s, a:b],
            rows.field[s, raw:last_raw],
        )
        trace = Trace(
            rows.prior[s, r:t],
            rows.prior_p[s, r:t],
            rows.steps[s, r:t],
            rows.row_count[s, r:t],
            rows.measured[s, r:t],
            rows.gains[s, r:t],
            rows.ratios[s, r:t],
            rows.posterior[s, r:t],
            rows.spread[s, r:t],
        )
        forward(samples, settings, FootState(rows.memory[s], rows.x[s], rows.p[s]), trace)
        x.filtered = stop
        start = stop


@step()
def _records_to_front(s: int, first: int, count: int, rows: FootRows) -> None:
    """Move the filter's records that are still needed to the start of their room."""
    for k in range(count):
        rows.prior[s, k] = rows.prior[s, first + k]
        rows.prior_p[s, k] = rows.prior_p[s, first + k]
        rows.steps[s, k] = rows.steps[s, first + k]
        rows.row_count[s, k] = rows.row_count[s, first + k]
        rows.measured[s, k] = rows.measured[s, first + k]
        rows.gains[s, k] = rows.gains[s, first + k]
        rows.ratios[s, k] = rows.ratios[s, first + k]
        rows.spread[s, k] = rows.spread[s, first + k]


@step()
def _write(
    s: int, rows: FootRows, sizes: Sizes, coast: float, values: Float, flags: NDArray[np.uint8]
) -> None:
    """Smooth back from the ticks filtered, and write the block that is released."""
    x = rows.foot[s]
    base, block = x.base, sizes.block
    smooth = np.empty((block, _STATE))
    trace = Trace(
        rows.prior[s],
        rows.prior_p[s],
        rows.steps[s],
        rows.row_count[s],
        rows.measured[s],
        rows.gains[s],
        rows.ratios[s],
        rows.posterior[s],
        rows.spread[s],
    )
    backward(base, base + block, base + block + sizes.lag, trace, np.zeros(at.ERRORS), smooth)
    is_known = x.last_stance >= 0
    for k in range(block):
        for i in range(_STATE):
            values[k, i] = smooth[k, i]
        for i in range(6):
            values[k, _SIGMA + i] = math.sqrt(max(rows.spread[s, base + k, i], 0.0))
        j = x.judged_place + k
        stands = rows.bits[s, j] & _STANCE != 0 and rows.inputs[s, 1, j] < UNREST
        if not is_known:
            is_known = stands and values[k, _TILT_X] < TILT_KNOWN_RAD and values[k, _TILT_Y] < TILT_KNOWN_RAD
            stands = is_known
        tick = x.released + k
        if stands:
            x.last_stance = tick
        values[k, _T] = rows.inputs[s, 1, j]
        values[k, _STANDS] = 1.0 if stands else 0.0
        flags[k] = _NO_STANCE if x.last_stance < 0 or tick - x.last_stance > coast else 0


@step()
def _leave(s: int, rows: FootRows, sizes: Sizes) -> None:
    """Count a block as released, and forget what nothing to come looks back at."""
    x = rows.foot[s]
    x.released += sizes.block
    x.base += sizes.block
    if x.base + sizes.lag + 2 * sizes.block > rows.spread.shape[1]:
        _records_to_front(s, x.base, sizes.lag, rows)
        x.base = 0
    x.judged_place += sizes.block
    x.judged -= sizes.block
    passed = 0
    while passed + 1 < x.marks and rows.mark[s, passed + 1].start <= x.released:
        passed += 1
    if passed:
        for k in range(x.marks - passed):
            mark, later = rows.mark[s, k], rows.mark[s, passed + k]
            mark.start, mark.gap, mark.wary = later.start, later.gap, later.wary
            rows.mark_x[s, k] = rows.mark_x[s, passed + k]
            rows.mark_p[s, k] = rows.mark_p[s, passed + k]
            rows.mark_memory[s, k] = rows.mark_memory[s, passed + k]
        x.marks -= passed


@compiled(RELEASE)
def release(
    rows: FootRows,
    first: int,
    sizes: Sizes,
    step_s: float,
    coast: float,
    scales: Float,
    decision: Float,
    noise: Float,
    settings: Float,
    values: Float,
    flags: NDArray[np.uint8],
) -> None:
    """Estimate some feet as far as the samples allow and write what is released, after `take` has taken the newest.

    Parameters
    ----------
    first : int
        Row of the first of S feet.
    coast : float
        Ticks after a stance from which on none is believed to be near.
    scales : ndarray, shape (2,)
        Of T: rad/s and m/s^2.
    decision, noise, settings : ndarray
        Constants of detector, noise and filter.
    values : ndarray, shape (S, B, COLUMNS)
        Output; B whole blocks.
    flags : ndarray of uint8, shape (S, B)
        Output.
    """
    feet, block = flags.shape[0], sizes.block
    for n in range(feet):
        s = first + n
        x = rows.foot[s]
        end = x.stop - sizes.ahead
        _judge(s, end, rows, sizes, scales, decision, noise)
        for a in range(0, flags.shape[1], block):
            _filter(s, x.released + sizes.lag + block, rows, sizes, step_s, settings)
            _write(s, rows, sizes, coast, values[n, a : a + block], flags[n, a : a + block])
            _leave(s, rows, sizes)
        needed = min(x.released, x.filtered, x.released + x.judged) - sizes.back - 1
        if x.marks:
            needed = min(needed, rows.mark[s, 0].start)
        drop = needed - x.origin
        if drop > 0:
            x.place += drop
            x.known = max(x.known - drop, 0)
            x.origin += drop
