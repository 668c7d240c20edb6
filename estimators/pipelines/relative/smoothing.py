"""A whole magnetic session, smoothed: the filter forward, then backward over its states, block by block."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import SetupError
from estimators.magnetic import RelativeFlag, RelativePoseFilter, RelativeResult
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.smoother import backward
from estimators.pipelines._contract import SessionSetup
from estimators.pipelines.relative.pipeline import ModulesChunk, RelativePosePipeline
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

_BLOCK: Final = 2000
"""Ticks whose covariances are held at a time: 7 MB, however long the session."""


def smooth_modules(pieces: Sequence[ImuChunk], setup: SessionSetup) -> tuple[RelativeResult, ...]:
    """Find the pose of every sensor against the source from a whole session.

    Parameters
    ----------
    pieces : sequence of ImuChunk
        Consecutive ticks from tick 0, sensors in the order of the setup.
    setup : SessionSetup
        Of the pipeline `relative_pose`.

    Returns
    -------
    tuple of RelativeResult
        One a sensor, of all ticks. Pulses, requests and flags are those of the filter, but for `UNCERTAIN`.

    Raises
    ------
    SetupError
        For another pipeline.
    """
    if setup.pipeline != RelativePosePipeline.name:
        raise SetupError(say("setup.only_magnetic"))
    pipeline = RelativePosePipeline(setup)
    return tuple(
        _smooth(one, np.concatenate([pipeline.table(name, piece) for piece in pieces]))
        for name, one in pipeline.filters.items()
    )


def with_modules(chunk: ImuChunk, modules: Sequence[RelativeResult], start: int) -> ModulesChunk:
    """Put a chunk and the poses of its sensors together, which begin at row `start` of the results."""
    measured = {field.name: getattr(chunk, field.name) for field in fields(ImuChunk)}
    return ModulesChunk(
        **measured, modules=tuple(one.ticks(start, start + chunk.tick_count) for one in modules)
    )


@dataclass(frozen=True)
class _Next:
    """The first tick of the block behind: its smoothed state, and whether it began again there."""

    nominal: Float
    covariance: Float
    is_restart: bool
    is_valid: bool


def _smooth(one: RelativePoseFilter, samples: Float) -> RelativeResult:
    """Smooth one sensor from its samples, shape (K, 17).

    The same recursion as `smooth_relative_pose` (method page 3.12, C4 2.4), which keeps the covariances of the
    whole session; here the filter's states are retained at the beginning of each block, and a block is run again for
    its covariances when the way back comes to it.
    """
    starts = range(0, len(samples), _BLOCK)
    states, parts = [], []
    for start in starts:
        states.append(one.state())
        parts.append(one.run(samples[start : start + _BLOCK]))
    filtered = RelativeResult.of_table(np.concatenate([np.empty((0, at.OUTPUT)), *parts]))
    held = _held(samples)
    poses = np.empty((len(samples), at.NOMINAL))
    spread = np.empty((len(samples), 6, 6))
    behind: _Next | None = None
    for start, state in zip(reversed(starts), reversed(states), strict=True):
        one.restore(state)
        behind = _block_back(one, samples, held, start, behind, poses, spread)
    attitude = slice(at.ATTITUDE, at.ATTITUDE + 4)
    result = replace(
        filtered,
        position_m=poses[:, at.POSITION : at.POSITION + 3].copy(),
        q_source_sensor=rotation.positive(poses[:, attitude]),
        velocity_mps=poses[:, at.VELOCITY : at.VELOCITY + 3].copy(),
        covariance=spread,
    )
    return replace(result, flags=_flags(one, result))


def _block_back(
    one: RelativePoseFilter,
    samples: Float,
    held: Float,
    start: int,
    behind: _Next | None,
    poses: Float,
    spread: Float,
) -> _Next:
    """Run one block again from its start and smooth it backward; fill its rows of `poses` and `spread`."""
    count = min(_BLOCK, len(samples) - start)
    rows = count if behind is None else count + 1
    nominal, covariance = np.empty((rows, at.NOMINAL)), np.empty((rows, at.ERRORS, at.ERRORS))
    restarted, valid = np.zeros(rows, dtype=np.bool_), np.zeros(rows, dtype=np.bool_)
    for k in range(count):
        _, settings, state, variance, _, counters, _ = one.arrays()
        before = int(counters[at.RESTARTED])
        one.run(samples[start + k : start + k + 1])
        nominal[k], covariance[k], valid[k] = state, variance, counters[at.STARTED] > 0
        restarted[k] = counters[at.RESTARTED] > before
    if behind is not None:
        nominal[count], covariance[count] = behind.nominal, behind.covariance
        restarted[count], valid[count] = behind.is_restart, behind.is_valid
    smoothed, smoothed_covariance = np.empty_like(nominal), np.empty_like(covariance)
    part = np.ascontiguousarray(held[start : start + rows])
    backward(
        part, restarted, valid, nominal, covariance, settings, smoothed, smoothed_covariance, nominal.copy()
    )
    poses[start : start + count] = smoothed[:count]
    spread[start : start + count] = smoothed_covariance[:count, at.POSE[:, None], at.POSE[None, :]]
    return _Next(smoothed[0], smoothed_covariance[0], bool(restarted[0]), bool(valid[0]))


def _held(samples: Float) -> Float:
    """Put the last whole sample where one is missing, as the filter does."""
    held = samples.copy()
    whole = np.isfinite(samples[:, at.INERTIAL]).all(axis=1)
    last = np.maximum.accumulate(np.where(whole, np.arange(len(samples)), -1))
    missing = np.flatnonzero(~whole)
    filled = np.where((last[missing] >= 0)[:, None], samples[last[missing]][:, at.INERTIAL], 0.0)
    held[missing[:, None], at.INERTIAL[None, :]] = filled
    return held


def _flags(one: RelativePoseFilter, result: RelativeResult) -> NDArray[np.uint16]:
    """Say again where the pose is less certain than wanted: the smoother knows more than the filter did."""
    limits = np.repeat([one.parameters["uncertain_m"], np.radians(one.parameters["uncertain_deg"])], 3)
    variance = np.diagonal(result.covariance, axis1=1, axis2=2)
    started = (result.flags & np.uint16(int(RelativeFlag.INVALID))) == 0
    wide = started & (variance > limits**2).any(axis=1)
    bit = np.uint16(int(RelativeFlag.UNCERTAIN))
    return np.where(wide, result.flags | bit, result.flags & ~bit).astype(np.uint16)
