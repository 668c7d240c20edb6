"""Smoothing nearly live: each tick is reported a bounded time after it was measured, with what came until then."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError, ShapeError
from estimators.optical import _kernel as kernel
from estimators.optical import _layout as at
from estimators.optical._contract import OpticalChunk, OpticalResult, OpticalStart
from estimators.optical._fusion import OpticalInertialFilter, to_result


class FixedLagSmoother:
    """The filter, and a backward pass over the last ticks: what is reported has seen a lag of later samples at least.

    The same samples give the same result, bit for bit, one by one, in chunks, or across `state` and `restore`. Until
    two lags have passed there is nothing; `flush` tells the rest.

    Parameters
    ----------
    lag_s : float
        Longer than the longest gap by half a second, where gaps are to end with the cameras (page 2.4).
    parameters : mapping, optional
        Of `OpticalParameters`.

    Notes
    -----
    Method page 2.4 (Roetenberg 2006, 4.5, future work): the backward pass is run again over the last ticks. It is run
    once a lag for as many ticks at once, so that a tick costs two steps back and not one for each tick of the lag; what
    is reported is one to two lags old.
    """

    name: ClassVar[str] = "optical_fixed_lag"
    version: ClassVar[str] = "1"

    def __init__(self, time_step_s: float, lag_s: float, parameters: Mapping[str, Any] | None = None) -> None:
        if not 2.0 * time_step_s <= lag_s <= 30.0:
            raise SetupError(f"lag_s must be between two ticks and 30 s, not {lag_s}")
        self._live = OpticalInertialFilter(time_step_s, parameters)
        self._lag = round(lag_s / time_step_s)
        self._samples = np.empty((0, at.SAMPLE))
        self._states, self._out = np.empty((0, at.NOMINAL)), np.empty((0, at.OUTPUT))
        self._covariances = np.empty((0, at.ERRORS, at.ERRORS))

    def begin(self, start: OpticalStart) -> None:
        """Begin from a known state, valid at the next tick."""
        self._live.begin(start)

    def update(self, chunk: OpticalChunk) -> OpticalResult:
        """Take the next ticks; return those that are old enough, which may be none."""
        if chunk.first_tick != int(self._live.state()["counters"][0]):
            raise ShapeError(f"tick {chunk.first_tick} does not follow the last one")
        samples, stated = chunk.table(), []
        taken = 0
        while taken < len(samples):
            # Blocks end at the same ticks however the samples come.
            stop = min(len(samples), taken + 2 * self._lag - len(self._samples))
            part = samples[taken:stop]
            covariances = np.zeros((len(part), at.ERRORS, at.ERRORS))
            states, out = self._live.run(part, covariances)
            self._samples = np.concatenate([self._samples, part])
            self._states, self._out = (
                np.concatenate([self._states, states]),
                np.concatenate([self._out, out]),
            )
            self._covariances = np.concatenate([self._covariances, covariances])
            taken = stop
            if len(self._samples) == 2 * self._lag:
                stated.append(self._smoothed(self._lag))
        return _joined(stated)

    def flush(self) -> OpticalResult:
        """Return what is still held back, smoothed with all that came; the stream has ended."""
        return self._smoothed(len(self._samples)) if len(self._samples) else _joined([])

    def _smoothed(self, count: int) -> OpticalResult:
        """Go back over all that is held; tell the first `count` ticks and forget them."""
        states, out, covariances = self._states.copy(), self._out.copy(), self._covariances.copy()
        begun = np.flatnonzero(np.isfinite(states[:, 0]))
        if len(begun):
            part = slice(int(begun[0]), len(states))
            kernel.backward(
                self._samples[part],
                self._live.settings,
                states[part],
                covariances[part],
                out[part],
                np.empty(at.NOMINAL),
                np.empty((at.ERRORS, at.ERRORS)),
                True,
            )
        for name in ("_samples", "_states", "_out", "_covariances"):
            setattr(self, name, getattr(self, name)[count:].copy())
        return to_result(states[:count], out[:count])

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next update depends on."""
        held = {name: getattr(self, f"_{name}").copy() for name in _HELD}
        return {**self._live.state(), **held}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        for name in _HELD:
            if name not in state or state[name].shape[1:] != getattr(self, f"_{name}").shape[1:]:
                raise ShapeError(f"the stored state has no {name} of this smoother")
        self._live.restore(state)
        for name in _HELD:
            setattr(self, f"_{name}", np.array(state[name], dtype=np.float64))


_HELD = ("samples", "states", "out", "covariances")


def _joined(results: list[OpticalResult]) -> OpticalResult:
    if not results:
        return to_result(np.empty((0, at.NOMINAL)), np.empty((0, at.OUTPUT)))
    return OpticalResult(
        **{
            field.name: np.concatenate([getattr(result, field.name) for result in results])
            for field in fields(OpticalResult)
        }
    )


def smooth_with_lag(
    chunk: OpticalChunk,
    lag_s: float,
    parameters: Mapping[str, Any] | None = None,
    start: OpticalStart | None = None,
) -> OpticalResult:
    """Return what a fixed-lag smoother would have reported of a whole recording, one row a tick."""
    live = FixedLagSmoother(chunk.time_step_s, lag_s, parameters)
    if start is not None:
        live.begin(start)
    return _joined([live.update(chunk), live.flush()])
