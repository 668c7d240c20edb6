"""The step of many relative-pose sessions at once: what `RelativePosePipeline.step` does, with the same bits.

All of it is compiled but the solution of a burst, at a start and after a place was lost: there the step is left, and
goes on behind it when it is called again.
"""

from typing import Final

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.compiling import compiled
from estimators.kernels import bundle, rows, step
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.run import run as run_filter
from estimators.orientation._screen import _SAMPLE, _judge
from estimators.orientation._strapdown_steps import Estimates, Ticks
from estimators.orientation.vqf._kernel import run as run_level
from estimators.orientation.vqf._steps import SETTINGS, STATE
from estimators.pipelines.pooled import COLUMNS, STRETCH, Columns
from estimators.pipelines.relative.kernel import Running, Written, take, write_frames
from estimators.pipelines.relative.rows import BEGIN, PROGRESS, RelativeRows, RelativeTables, RelativeWork
from estimators.recording import Float, SampleQuality

_MISSING: Final = int(SampleQuality.MISSING)
_COLUMNS, _OUTPUT, _EVENT, _BEGIN = at.SAMPLE, at.OUTPUT, at.EVENT, BEGIN

_F1, _F2, _F3 = (types.Array(types.float64, n, "C") for n in (1, 2, 3))
_I2 = types.Array(types.int64, 2, "C")
_U1, _U2 = (types.Array(types.uint8, n, "C") for n in (1, 2))
_B1 = types.Array(types.boolean, 1, "C")
_INT, _REAL = types.int64, types.float64
ROWS: Final = bundle(
    RelativeRows, rows(STATE), _F3, _F2, _F3, _F2, _F2, _F3, _F2, _I2, _F3, _F2, _F2, _I2, _U1
)
TABLES: Final = bundle(RelativeTables, _INT, _INT, _INT, _INT, _INT, _INT, _REAL, _REAL, rows(SETTINGS))
WORK: Final = bundle(RelativeWork, _F1, _F1, _B1, _U1, _U1, _U1, _F1, _F1, _F1)


@step()
def _level(
    rate: Float,
    force: Float,
    grade: NDArray[np.uint8],
    slot: int,
    r: RelativeRows,
    t: RelativeTables,
    work: RelativeWork,
) -> None:
    """Find the orientation of the source, without a field: its magnetometer sees nothing but its own coils."""
    ticks = grade.shape[1]
    wild = work.wild[:ticks].reshape((1, ticks))
    none = np.empty((0, 0, 3))
    if _judge(rate, force, none, grade, t.step_s, False, r.screen[slot : slot + 1], wild) > 0:
        judged = work.quality[:ticks].reshape((1, ticks))
        for k in range(ticks):
            # The filter looks at nothing of a sample that is missing.
            judged[0, k] = grade[0, k] | _MISSING if wild[0, k] & _SAMPLE else grade[0, k]
        grade = judged
    out = Estimates(
        work.q[: 4 * ticks].reshape((1, ticks, 4)),
        work.bias[: 3 * ticks].reshape((1, ticks, 3)),
        work.sigma[: 3 * ticks].reshape((1, ticks, 3)),
        work.flags[:ticks].reshape((1, ticks)),
        none,
    )
    run_level(
        Ticks(rate, force, none, grade),
        t.level_settings,
        r.level[slot : slot + 1],
        r.level_covariance[slot : slot + 1],
        out,
    )


@step()
def _begin(
    slot: int,
    signals_at: int,
    quality_at: int,
    ticks: int,
    signals: Float,
    quality: NDArray[np.uint8],
    carried: Float,
    r: RelativeRows,
    t: RelativeTables,
    work: RelativeWork,
) -> None:
    """Take the samples of a stretch, and level them."""
    modules = t.sensors + 1
    count = modules * ticks
    size = 3 * count
    rate = signals[signals_at : signals_at + size].reshape((modules, ticks, 3))
    force = signals[signals_at + size : signals_at + 2 * size].reshape((modules, ticks, 3))
    field = np.empty((0, 0, 3))
    if t.channels == 3:
        field = signals[signals_at + 2 * size : signals_at + 3 * size].reshape((modules, ticks, 3))
    grade = quality[quality_at : quality_at + count].reshape((modules, ticks))
    coil_state = np.empty((0, 0, 1))[:, :, 0]
    if t.coil_column >= 0:
        beside = carried[t.width * quality_at : t.width * (quality_at + count)]
        coil_state = beside.reshape((modules, ticks, t.width))[:, :, t.coil_column]
    samples = work.samples[: t.sensors * ticks * _COLUMNS].reshape((t.sensors, ticks, _COLUMNS))
    take(rate, force, field, grade, coil_state, t.source, t.coils, samples, work.wrong[:ticks])
    source = slice(t.source, t.source + 1)
    _level(rate[source], force[source], grade[source], slot, r, t, work)


@step()
def _write(
    slot: int, start: int, ticks: int, r: RelativeRows, t: RelativeTables, work: RelativeWork, out: Columns
) -> None:
    """Write what the filters have put out."""
    stop = start + ticks
    write_frames(
        work.q[: 4 * ticks].reshape((ticks, 4)),
        work.flags[:ticks],
        work.samples[: t.sensors * ticks * _COLUMNS].reshape((t.sensors, ticks, _COLUMNS)),
        work.outs[: t.sensors * ticks * _OUTPUT].reshape((t.sensors, ticks, _OUTPUT)),
        work.wrong[:ticks],
        t.height_m,
        t.step_s,
        Running(r.account[slot], r.last_angle[slot], r.turns[slot]),
        Written(
            out.q_room_segment[start:stop],
            out.point_room_m[start:stop],
            out.segment_sigma_rad[start:stop],
            out.segment_flags[start:stop],
            out.angle_rad[start:stop],
            out.angle_sigma_rad[start:stop],
            out.angle_flags[start:stop],
            out.scalar[start:stop],
        ),
    )


@compiled(types.boolean(rows(STRETCH), _INT, _F1, _U1, _F1, ROWS, TABLES, WORK, COLUMNS, rows(PROGRESS)))
def step_relative(
    stretches: NDArray[np.void],
    count: int,
    signals: Float,
    quality: NDArray[np.uint8],
    carried: Float,
    r: RelativeRows,
    tables: RelativeTables,
    work: RelativeWork,
    out: Columns,
    progress: NDArray[np.void],
) -> bool:
    """Take the next ticks of some sessions, see `Pool.step`, from where `progress` says.

    Returns
    -------
    bool
        Whether a burst is to be solved, of the filter in `progress`, before it is called again.
    """
    at_work = progress[0]
    sensors = tables.sensors
    while at_work.stretch < count:
        one = stretches[at_work.stretch]
        slot, ticks = one.slot, one.ticks
        if ticks == 0 or r.is_stopped[slot]:
            at_work.stretch += 1
            continue
        if at_work.filter == _BEGIN:
            _begin(slot, one.signals_at, one.quality_at, ticks, signals, quality, carried, r, tables, work)
            at_work.filter, at_work.ticks = 0, 0
        samples = work.samples[: sensors * ticks * _COLUMNS].reshape((sensors, ticks, _COLUMNS))
        outs = work.outs[: sensors * ticks * _OUTPUT].reshape((sensors, ticks, _OUTPUT))
        while at_work.filter < sensors:
            i = at_work.filter
            f = slot * sensors + i
            while at_work.ticks < ticks:
                taken = at_work.ticks
                at_work.ticks += run_filter(
                    samples[i, taken:],
                    r.loops[slot],
                    r.settings[f],
                    r.nominal[f],
                    r.covariance[f],
                    r.memory[f],
                    r.counters[f],
                    r.ring[f],
                    outs[i, taken:],
                )
                if r.counters[f, _EVENT]:
                    return True
            at_work.filter, at_work.ticks = i + 1, 0
        _write(slot, one.tick_at, ticks, r, tables, work, out)
        at_work.stretch, at_work.filter = at_work.stretch + 1, _BEGIN
    return False
