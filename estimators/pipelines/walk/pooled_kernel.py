"""The step of many walks at once: what `GaitPipeline.step` does where nothing is unusual, compiled, the same bits."""

from typing import Final

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.compiling import compiled
from estimators.gait.foot import layout as at
from estimators.gait.foot.live.ordinary_kernel import release, take
from estimators.gait.foot.live.rows import FOOT_ROWS, PIECE_TICKS, SIZES, FootRows
from estimators.gait.foot.live.widened_kernel import can_widen, widen
from estimators.kernels import Record, bundle, rows, step
from estimators.kernels.by_address import caller
from estimators.kinetics import _live_shoes_kernel as shoe
from estimators.orientation._screen import _judge
from estimators.pipelines.pooled import COLUMNS, STRETCH, Columns
from estimators.pipelines.walk.released_kernel import Feet, Shoes, write_feet, write_shoes
from estimators.pipelines.walk.rows import COUNT, FIRST, SESSION, WalkRows, WalkTables, WalkWork
from estimators.recording import Float

_COLUMNS, _LOADS, _CELL = at.COLUMNS, shoe.LOADS, shoe.FOREFOOT_FORCE
_F1, _F2, _F3, _F4 = (types.Array(types.float64, n, "C") for n in (1, 2, 3, 4))
_U1, _U2 = (types.Array(types.uint8, n, "C") for n in (1, 2))
_I1, _I2 = (types.Array(types.int64, n, "C") for n in (1, 2))
_WHOLE, _REAL = types.int64, types.float64
ROWS: Final = bundle(
    WalkRows,
    *(rows(SESSION), _F2, _F2, _F2, _F4, _I2, _F4, _I2, _F2, _F2, _F2, _F2, _F3, _F3),
)
TABLES: Final = bundle(
    WalkTables,
    *(_WHOLE, _WHOLE, _I1, _REAL, SIZES, _REAL, _REAL, _F1, _F1, _F1, _F1, _I1, _U2, _F2),
    *(_WHOLE, _WHOLE, _WHOLE, _WHOLE, _WHOLE, _WHOLE, _WHOLE),
)
WORK: Final = bundle(WalkWork, _F1, _F1, _F1, _U1, _U1, _F2)
_take, _release = caller(take), caller(release)
_write_feet, _write_shoes = caller(write_feet), caller(write_shoes)


@step()
def _followed(
    signals: Float, first: int, ticks: int, sensors: int, order: NDArray[np.int64], room: Float
) -> Float:
    """Return one signal of the sensors that are followed, shape (S, K, 3), copied into `room`."""
    found = room[: 3 * len(order) * ticks].reshape((len(order), ticks, 3))
    given = signals[first : first + 3 * sensors * ticks].reshape((sensors, ticks, 3))
    for s in range(len(order)):
        for k in range(ticks):
            for a in range(3):
                found[s, k, a] = given[order[s], k, a]
    return found


@step()
def _append(room: Float, place: NDArray[np.int64], ticks: int) -> int:
    """Make room for further ticks and return where they begin; as `Queue.append`."""
    if place[FIRST] + place[COUNT] + ticks > room.shape[1]:
        for r in range(room.shape[0]):
            for k in range(place[COUNT]):
                for i in range(room.shape[2]):
                    room[r, k, i] = room[r, place[FIRST] + k, i]
        place[FIRST] = 0
    place[COUNT] += ticks
    return int(place[FIRST] + place[COUNT] - ticks)


@step()
def _take_loads(
    carried: Float, first: int, ticks: int, tables: WalkTables, room: Float, place: NDArray[np.int64]
) -> None:
    """Let the loads of two shoes wait; as `LiveShoes.take`."""
    begin, width = _append(room, place, ticks), tables.width
    for cell in range(4):
        column = _CELL * (cell % 2)
        for k in range(ticks):
            sample = width * (first + tables.order[cell] * ticks + k)
            for a in range(3):
                force = moment = np.nan
                if tables.force_at >= 0 and tables.moment_at >= 0:
                    force = carried[sample + tables.force_at + a]
                    moment = carried[sample + tables.moment_at + a]
                room[cell // 2, begin + k, column + a] = force
                room[cell // 2, begin + k, column + 3 + a] = moment


@step()
def _write(slot: int, values: Float, flags: NDArray[np.uint8], r: WalkRows, tables: WalkTables) -> None:
    """Let the rows of what was released wait; as `GaitPipeline._write`."""
    ticks, feet = flags.shape[1], len(tables.heels)
    begin = _append(r.waiting[slot], r.waiting_place[slot], ticks)
    written = r.waiting[slot, 0, begin : begin + ticks]
    known = Feet(
        tables.heels,
        tables.right,
        r.steps_settings[slot],
        r.steps[feet * slot : feet * (slot + 1)],
        tables.offset_m,
    )
    if not tables.has_shoes:
        _write_feet(tables.write, (values, flags, known, written))
        return
    place = r.loads_place[slot]
    loads = np.empty((2, place[COUNT], _LOADS))
    for f in range(2):
        for k in range(loads.shape[1]):
            for i in range(_LOADS):
                loads[f, k, i] = r.loads[slot, f, place[FIRST] + k, i]
    shoes = Shoes(
        r.shoe_settings[slot],
        r.shoes[2 * slot : 2 * slot + 2],
        r.balance_settings[slot],
        r.balance_memory[slot],
        r.x[slot],
        r.p[slot],
    )
    _write_shoes(tables.write, (values, flags, known, loads, shoes, written))
    place[FIRST] += ticks
    place[COUNT] -= ticks


@step()
def _show(
    waiting: Float,
    place: NDArray[np.int64],
    ticks: int,
    start: int,
    out: Columns,
    point_sigma_m: Float,
) -> None:
    """Write the ticks that waited longest into the columns."""
    feet, points, scalars = out.q_room_segment.shape[1], out.point_room_m.shape[1], out.scalar.shape[1]
    for k in range(ticks):
        row, n = waiting[place[FIRST] + k], start + k
        i = 0
        for f in range(feet):
            for a in range(4):
                out.q_room_segment[n, f, a] = row[i]
                i += 1
        for p in range(points):
            for a in range(3):
                out.point_room_m[n, p, a] = row[i]
                i += 1
        for c in range(scalars):
            out.scalar[n, c] = row[i]
            i += 1
        for f in range(feet):
            out.segment_flags[n, f] = np.uint8(row[i])
            i += 1
        for f in range(feet):
            for a in range(3):
                out.segment_sigma_rad[n, f, a] = row[i]
                i += 1
        for p in range(points):
            for a in range(3):
                point_sigma_m[n, p, a] = row[i]
                i += 1
    place[FIRST] += ticks
    place[COUNT] -= ticks


@step()
def _taken(
    one: Record,
    signals: Float,
    quality: NDArray[np.uint8],
    all_feet: FootRows,
    all_screens: Float,
    tables: WalkTables,
    work: WalkWork,
) -> bool:
    """Take a stretch's samples into a session's rows; False, and nothing changed, where they are not as usual."""
    ticks, sensors, order = one.ticks, tables.sensors, tables.order
    at_first = len(order) * one.slot
    screen = all_screens[at_first : at_first + len(order)]
    count, first, size = len(order), one.signals_at, 3 * tables.sensors * ticks
    rate = _followed(signals, first, ticks, sensors, order, work.rate)
    force = _followed(signals, first + size, ticks, sensors, order, work.force)
    field = np.empty((0, 0, 3))
    if tables.channels == 3:
        field = _followed(signals, first + 2 * size, ticks, sensors, order, work.field)
    grade = work.quality[: count * ticks].reshape((count, ticks))
    for s in range(count):
        for k in range(ticks):
            grade[s, k] = quality[one.quality_at + order[s] * ticks + k]
    wild = work.wild[: count * ticks].reshape((count, ticks))
    for s in range(count):
        for i in range(screen.shape[1]):
            work.screen[s, i] = screen[s, i]
    found = _judge(rate, force, field, grade, tables.screen_step_s, False, screen, wild)
    if found == 0 and _take(tables.take, (all_feet, at_first, rate, force, field, grade)):
        return True
    for s in range(count):
        for i in range(screen.shape[1]):
            screen[s, i] = work.screen[s, i]
    return False


@compiled(_WHOLE(rows(STRETCH), _WHOLE, _U1, _F1, _U1, _F1, FOOT_ROWS, ROWS, TABLES, WORK, COLUMNS, _F3))
def step_walks(
    stretches: NDArray[np.void],
    count: int,
    is_taken: NDArray[np.uint8],
    signals: Float,
    quality: NDArray[np.uint8],
    carried: Float,
    all_feet: FootRows,
    r: WalkRows,
    tables: WalkTables,
    work: WalkWork,
    out: Columns,
    point_sigma_m: Float,
) -> int:
    """Take the next ticks of some sessions as far as nothing about them is unusual; the rest is left as it is.

    Parameters
    ----------
    stretches, count, signals, quality, carried
        As of `Pool.step`.
    is_taken : ndarray of uint8, shape (count,)
        Stretches that are done; set where one is taken here.
    r, tables, work
    point_sigma_m : ndarray, shape (T, P, 3)
        Output, beside the columns.

    Returns
    -------
    int
        Number of stretches that are left: the first of a session that is unusual, and all of that session after it.
    """
    sensors, block, left = len(tables.order), tables.sizes.block, 0
    for n in range(count):
        r.session[stretches[n].slot].waits = 0
    for n in range(count):
        one = stretches[n]
        if is_taken[n] or one.ticks == 0:
            is_taken[n] = 1
            continue
        slot, ticks = one.slot, one.ticks
        x, a = r.session[slot], sensors * slot
        if (
            x.waits
            or x.is_general
            or x.next_tick != one.first_tick
            or ticks > PIECE_TICKS
            or not can_widen(all_feet.lost, a, sensors)
            or not _taken(one, signals, quality, all_feet, r.screen, tables, work)
        ):
            x.waits = 1
            left += 1
            continue
        x.next_tick += ticks
        foot = all_feet.foot[a]
        blocks = (foot.stop - tables.sizes.ahead - foot.released - tables.sizes.lag) // block
        if tables.has_shoes:
            _take_loads(carried, one.quality_at, ticks, tables, r.loads[slot], r.loads_place[slot])
        if blocks > 0:
            values = np.empty((sensors, blocks * block, _COLUMNS))
            flags = np.empty((sensors, blocks * block), dtype=np.uint8)
            constants = tables.scales, tables.decision, tables.noise, tables.settings
            given = (all_feet, a, tables.sizes, tables.step_s, tables.coast)
            _release(tables.release, (*given, *constants, values, flags))
            widen(all_feet.lost, a, values, flags)
            _write(slot, values, flags, r, tables)
        _show(r.waiting[slot, 0], r.waiting_place[slot], ticks, one.tick_at, out, point_sigma_m)
        is_taken[n] = 1
    return left
