"""A source that follows what the relative-pose filter asks for, and what can go wrong with it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.errors import SetupError
from estimators.kernels import bundle
from estimators.magnetic import RelativePoseFilter, RelativeResult
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.run import tick
from estimators.recording import Float
from estimators.simulation.coil.scene import RelativeScene

_COIL, _CURRENT, _FIELD, _EVENT = at.COIL, at.CURRENT, at.FIELD, at.EVENT
_O_COIL, _O_CURRENT, _O_TICKS = at.O_COIL, at.O_CURRENT, at.O_TICKS
_C_COIL, _C_LEFT, _C_CURRENT, _C_TICK, _C_FIELD, _CONTROL = 0, 1, 2, 3, 4, 7
"""Of the source: the coil that is on, for how many ticks yet, its current, ticks so far, and the held field."""


@dataclass(frozen=True)
class SourceFaults:
    """What is wrong with the source or the link; times in seconds from the start.

    `wired_as` gives for each coil the one that fires instead, from `wired_from_s` on. `dead_from_s`: the coils are
    said to be on but are not. `silent_from_s`: neither coil nor report. `lost_share`: share of the requests that
    are lost. `full_scale_t` clips the magnetometer. `swapped`: signals of source and sensor module exchanged.
    `lag_s`: time constant of the magnetometer. `missing_s`: span without any sample.
    """

    wired_as: tuple[int, int, int] = (0, 1, 2)
    wired_from_s: float = 0.0
    dead_from_s: float = np.inf
    silent_from_s: float = np.inf
    lost_share: float = 0.0
    full_scale_t: float = np.inf
    swapped: bool = False
    lag_s: float = 0.0
    missing_s: tuple[float, float] = (np.inf, np.inf)


class _Faults(NamedTuple):
    """What is wrong: the coil fired for each, (3,); requests that are lost, (K,); limits of the rest, (5,)."""

    wired_as: NDArray[np.int64]
    lost: Float
    limits: Float


_ROW, _TABLE, _WHOLE = types.float64[::1], types.float64[:, ::1], types.int64[::1]
_SAMPLES = (_TABLE, types.float64[:, :, ::1], bundle(_Faults, _WHOLE, _ROW, _ROW), _ROW)
_FILTER = (_TABLE, _ROW, _ROW, _TABLE, _ROW, _WHOLE, _TABLE)


@kernel(types.int64(*_SAMPLES, *_FILTER, _TABLE))
def _closed_loop(
    samples: Float,
    per_ampere: Float,
    faults: _Faults,
    control: Float,
    loops: Float,
    settings: Float,
    nominal: Float,
    p: Float,
    memory: Float,
    counters: NDArray[np.int64],
    ring: Float,
    out: Float,
) -> int:
    """Run ticks until a burst must be solved; `control` has shape (_CONTROL,)."""
    work = np.empty((3, p.shape[0], p.shape[0]))
    wired_from, dead_from, silent_from, full_scale, gain = faults.limits
    for k in range(samples.shape[0]):
        row, now = samples[k], control[_C_TICK]
        control[_C_TICK] += 1.0
        if control[_C_LEFT] > 0.0:
            coil = int(control[_C_COIL])
            row[_COIL], row[_CURRENT] = control[_C_COIL], control[_C_CURRENT]
            fired = faults.wired_as[coil - 1] if now >= wired_from else coil - 1
            if now < dead_from:
                for i in range(3):
                    row[_FIELD + i] += control[_C_CURRENT] * per_ampere[k, fired, i]
            control[_C_LEFT] -= 1.0
        for i in range(3):
            if gain < 1.0 and now > 0.0:
                row[_FIELD + i] = control[_C_FIELD + i] + gain * (row[_FIELD + i] - control[_C_FIELD + i])
            control[_C_FIELD + i] = row[_FIELD + i]
            row[_FIELD + i] = min(full_scale, max(-full_scale, row[_FIELD + i]))
        tick(row, loops, settings, nominal, p, memory, counters, ring, work, out[k])
        if out[k, _O_COIL] > 0.0 and now < silent_from and faults.lost[k] == 0.0:
            control[_C_COIL], control[_C_CURRENT] = out[k, _O_COIL], out[k, _O_CURRENT]
            control[_C_LEFT] = out[k, _O_TICKS]
        if counters[_EVENT] > 0:
            return k + 1
    return len(samples)


def run_closed_loop(
    scene: RelativeScene, relative: RelativePoseFilter, faults: SourceFaults | None = None, seed: int = 0
) -> tuple[RelativeResult, Float]:
    """Let a filter run a session in which its requests are followed a tick later.

    Returns
    -------
    result : RelativeResult
    samples : ndarray, shape (K, 17)
        What the filter was given, coil states included: the same again without the loop gives the same result.
    """
    f = faults or SourceFaults()
    if sorted(set(f.wired_as) | {0, 1, 2}) != [0, 1, 2]:
        raise SetupError("wired_as names coils 0 to 2")
    count, step = len(scene.time_s), scene.time_step_s
    samples = np.zeros((count, at.SAMPLE))
    own = (scene.gyroscope_radps, scene.accelerometer_mps2)
    worn = (scene.source_gyroscope_radps, scene.source_accelerometer_mps2)
    if f.swapped:
        own, worn = worn, own
    samples[:, at.GYROSCOPE : at.GYROSCOPE + 3], samples[:, at.ACCELEROMETER : at.ACCELEROMETER + 3] = own
    samples[:, at.SOURCE_GYROSCOPE : at.SOURCE_GYROSCOPE + 3] = worn[0]
    samples[:, at.SOURCE_ACCELEROMETER : at.SOURCE_ACCELEROMETER + 3] = worn[1]
    samples[:, at.FIELD : at.FIELD + 3] = scene.source_ambient_t if f.swapped else scene.ambient_t
    per_ampere = scene.per_ampere_t
    if f.swapped:
        # The magnetometer of the source module sits at the origin of the source, among its coils.
        per_ampere = np.broadcast_to(_at_source(relative), per_ampere.shape).copy()
    gone = (scene.time_s >= f.missing_s[0]) & (scene.time_s < f.missing_s[1])
    samples[gone, : at.COIL] = np.nan
    lost = (np.random.default_rng([seed, 71]).random(count) < f.lost_share).astype(np.float64)
    gain = 1.0 if f.lag_s <= 0.0 else 1.0 - float(np.exp(-step / f.lag_s))
    limits = np.array(
        [f.wired_from_s / step, f.dead_from_s / step, f.silent_from_s / step, f.full_scale_t, gain]
    )
    wired, control = np.array(f.wired_as, dtype=np.int64), np.zeros(_CONTROL)
    out = np.empty((count, at.OUTPUT))
    taken = 0
    *_, counters, _ = arrays = relative.arrays()
    while taken < count:
        taken += _closed_loop(
            samples[taken:],
            per_ampere[taken:],
            _Faults(wired, lost[taken:], limits),
            control,
            *arrays,
            out[taken:],
        )
        if counters[at.EVENT]:
            relative.handle_event()
    return RelativeResult.of_table(out), samples


def _at_source(relative: RelativePoseFilter) -> Float:
    source = relative.source
    return np.asarray(source.field(np.arange(len(source.coils)), 1.0, np.full(3, 1e-3)))
