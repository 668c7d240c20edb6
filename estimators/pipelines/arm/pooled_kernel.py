"""The step of many arm sessions at once: what `ArmPipeline.step` does, compiled whole, with the same bits."""

from typing import Final

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.arm._kernel import Columns as ModelColumns
from estimators.arm._kernel import Filled, Segments, evaluate_kernel
from estimators.balance.mass_centre._worn_kernel import mass_centre
from estimators.compiling import compiled
from estimators.kernels import VOID, Record, bundle, rows, step
from estimators.kernels.by_address import caller
from estimators.leg._kernel import LEG_TABLE, leg_kernel
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._screen import _FIELD, _SAMPLE, _judge
from estimators.orientation._strapdown_steps import Estimates, Ticks
from estimators.orientation.telemotion._kernel import run
from estimators.orientation.telemotion._records import SETTINGS, STATE
from estimators.pipelines.arm.kernel import Worn, compose
from estimators.pipelines.arm.rows import SESSION, ArmRows, ArmTables, ArmWork
from estimators.pipelines.pooled import COLUMNS, STRETCH, Columns
from estimators.recording import Float, SampleQuality

_MISSING: Final = int(SampleQuality.MISSING)
_DISTURBANCE: Final = int(OrientationFlag.MAGNETIC_DISTURBANCE)

_filter, _evaluate, _move_legs, _mass_centre = (
    caller(one) for one in (run, evaluate_kernel, leg_kernel, mass_centre)
)
_F1, _F2, _F3, _F4 = (types.Array(types.float64, n, "C") for n in (1, 2, 3, 4))
_F5 = types.Array(types.float64, 5, "C")
_U1, _U2, _U3 = (types.Array(types.uint8, n, "C") for n in (1, 2, 3))
_I1, _I2 = (types.Array(types.int64, n, "C") for n in (1, 2))
ROWS: Final = bundle(
    ArmRows,
    rows(SESSION),
    rows(STATE),
    _F3,
    _F2,
    _F2,
    _F2,
    _F2,
    _F2,
    _U1,
    _F2,
    _I2,
    _F4,
    _U3,
    _F4,
    _F5,
    _U2,
    _F3,
    _F2,
    _F2,
    _F2,
)
TABLES: Final = bundle(
    ArmTables,
    *(types.int64, rows(SETTINGS), _I1, _I1, _I1, _I1, _I1, LEG_TABLE),
    *(types.int64, types.int64, types.int64, types.int64),
)
WORK: Final = bundle(ArmWork, _F1, _F1, _F1, _F1, _F1, _F1, _F1, _U1, _U1, _U1)


@step()
def _samples(signals: Float, at: int, sensors: int, ticks: int, channels: int) -> tuple[Float, Float, Float]:
    size = 3 * sensors * ticks
    rate = signals[at : at + size].reshape((sensors, ticks, 3))
    force = signals[at + size : at + 2 * size].reshape((sensors, ticks, 3))
    if channels == 2:
        return rate, force, np.empty((0, 0, 3))
    return rate, force, signals[at + 2 * size : at + 3 * size].reshape((sensors, ticks, 3))


@step()
def _without_bias(force: Float, bias: Float, out: Float) -> None:
    for s in range(force.shape[0]):
        for k in range(force.shape[1]):
            for a in range(3):
                out[s, k, a] = force[s, k, a] - bias[s, a]


@step()
def _screened(given: Ticks, wild: NDArray[np.uint8], work: ArmWork) -> Ticks:
    """Return copies of samples without those that cannot be true; as `SampleScreen.screened`."""
    sensors, ticks = wild.shape
    samples = sensors * ticks
    size = 3 * samples
    rate = work.rate[:size].reshape((sensors, ticks, 3))
    force = work.force[:size].reshape((sensors, ticks, 3))
    field = given.magnetometer_t
    if field.shape[0] > 0:
        field = work.field[:size].reshape((sensors, ticks, 3))
    quality = work.quality[:samples].reshape((sensors, ticks))
    for s in range(sensors):
        for k in range(ticks):
            lost = (wild[s, k] & _SAMPLE) != 0
            quality[s, k] = given.quality[s, k] | _MISSING if lost else given.quality[s, k]
            for a in range(3):
                rate[s, k, a] = np.nan if lost else given.gyroscope_radps[s, k, a]
                force[s, k, a] = np.nan if lost else given.accelerometer_mps2[s, k, a]
                if field.shape[0] > 0:
                    field[s, k, a] = np.nan if wild[s, k] else given.magnetometer_t[s, k, a]
    return Ticks(rate, force, field, quality)


@step()
def _flag_lost_field(wild: NDArray[np.uint8], flags: NDArray[np.uint8]) -> None:
    for s in range(wild.shape[0]):
        for k in range(wild.shape[1]):
            if wild[s, k] == _FIELD:
                flags[s, k] |= _DISTURBANCE


@step()
def _number(state: NDArray[np.void], first_tick: int) -> None:
    for s in range(state.shape[0]):
        state[s].tick = first_tick


@step()
def _remember(
    x: Record,
    first_tick: int,
    q: Float,
    flags: NDArray[np.uint8],
    at: NDArray[np.int64],
    retained: Float,
    retained_flags: Float,
) -> None:
    """Retain every n-th orientation for a calibration pose; as `BodyNetwork`."""
    stride = x.memory_stride
    k = (-first_tick) % stride
    while k < flags.shape[1]:
        slot = ((first_tick + k) // stride) % at.shape[0]
        at[slot] = first_tick + k
        for s in range(flags.shape[0]):
            retained_flags[slot, s] = flags[s, k]
            for a in range(4):
                retained[slot, s, a] = q[s, k, a]
        k += stride


@step()
def _move_arms(
    slot: int, step_s: float, r: ArmRows, tables: ArmTables, omega: Float, start: int, stop: int, out: Columns
) -> None:
    """Write points, angles, scalars, those of the legs and the centre of mass of the rows from `start` to `stop`."""
    worn = Segments(
        out.q_room_segment[start:stop],
        omega,
        out.segment_sigma_rad[start:stop],
        out.segment_flags[start:stop],
    )
    model = ModelColumns(
        tables.source, r.lengths[slot], tables.point_column, tables.angle_column, tables.scalar_column
    )
    filled = Filled(
        out.point_room_m[start:stop],
        out.angle_rad[start:stop],
        out.angle_sigma_rad[start:stop],
        out.scalar[start:stop],
        out.angle_flags[start:stop],
    )
    _evaluate(tables.model_at, (worn, model, step_s, r.previous_angle[slot], filled))
    if tables.legs.segment.shape[0] > 0:
        _move_legs(
            tables.legs_at,
            (
                out.q_room_segment[start:stop],
                out.segment_sigma_rad[start:stop],
                out.segment_flags[start:stop],
                tables.legs,
                out.angle_rad[start:stop],
                out.angle_sigma_rad[start:stop],
                out.angle_flags[start:stop],
            ),
        )
    if tables.mass_source.shape[0] > 0:
        _mass_centre(
            tables.mass_at,
            (
                out.q_room_segment[start:stop],
                out.segment_sigma_rad[start:stop],
                out.segment_flags[start:stop],
                r.lever[slot],
                r.doubt[slot],
                r.has_doubt[slot],
                r.mass_middle[slot],
                r.feet[slot],
                tables.mass_source,
                r.mass_settings[slot],
                out.point_room_m[start:stop],
                out.scalar[start:stop],
            ),
        )


@compiled(VOID(rows(STRETCH), types.int64, _F1, _U1, ROWS, TABLES, WORK, COLUMNS))
def step_arms(
    stretches: NDArray[np.void],
    count: int,
    signals: Float,
    quality: NDArray[np.uint8],
    r: ArmRows,
    tables: ArmTables,
    work: ArmWork,
    out: Columns,
) -> None:
    """Take the next ticks of some sessions; see `Pool.step`."""
    sensors = r.lever.shape[2]
    no_details = np.empty((0, 0, 0))
    for n in range(count):
        ticks = stretches[n].ticks
        if ticks == 0:
            continue
        slot, first_tick = stretches[n].slot, stretches[n].first_tick
        x, samples = r.session[slot], sensors * ticks
        a, b = slot * sensors, (slot + 1) * sensors
        size = 3 * samples
        rate, force, field = _samples(signals, stretches[n].signals_at, sensors, ticks, tables.channels)
        at = stretches[n].quality_at
        grade = quality[at : at + samples].reshape((sensors, ticks))
        if x.has_force_bias:
            own = work.force[:size].reshape((sensors, ticks, 3))
            _without_bias(force, r.force_bias[a:b], own)
            force = own
        wild = work.wild[:samples].reshape((sensors, ticks))
        found = _judge(rate, force, field, grade, x.step_s, False, r.screen[a:b], wild)
        given = Ticks(rate, force, field, grade)
        if found > 0:
            given = _screened(given, wild, work)
        state = r.state[a:b]
        _number(state, first_tick)
        q = work.q[: 4 * samples].reshape((sensors, ticks, 4))
        bias = work.bias[:size].reshape((sensors, ticks, 3))
        sigma = work.sigma[:size].reshape((sensors, ticks, 3))
        flags = work.flags[:samples].reshape((sensors, ticks))
        estimates = Estimates(q, bias, sigma, flags, no_details)
        _filter(tables.filter_at, (given, tables.settings, state, r.covariance[a:b], estimates))
        if found > 0:
            _flag_lost_field(wild, flags)
        start, stop = stretches[n].tick_at, stretches[n].tick_at + ticks
        omega = work.omega[:size].reshape((ticks, sensors, 3))
        variance = r.mounting_variance[a:b] if x.has_mounting else r.mounting_variance[a:a]
        compose(
            q,
            sigma,
            rate,
            bias,
            flags,
            Worn(r.q_room_earth[a:b], r.q_sensor_segment[a:b], variance, r.more_flags[a:b]),
            out.q_room_segment[start:stop],
            omega,
            out.segment_sigma_rad[start:stop],
            out.segment_flags[start:stop],
        )
        _remember(x, first_tick, q, flags, r.memory_tick[slot], r.memory_q[slot], r.memory_flags[slot])
        _move_arms(slot, x.step_s, r, tables, omega, start, stop, out)
