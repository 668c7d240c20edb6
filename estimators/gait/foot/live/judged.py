"""Detector and noise model of samples that the live filter has not released yet."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.gait._stance import (
    NOT_CUT_OFF,
    UNREST,
    Windows,
    decide,
    decision_settings,
    noise_settings,
)
from estimators.gait._stance_kernel import noise_densities
from estimators.gait.foot import layout as at
from estimators.gait.foot.bridge_kernel import BESIDE_S, add_bridge_noise
from estimators.gait.foot.live.rows import BRIDGED, CLIPPED, FIELD, MISSING, FootRows
from estimators.gait.foot.live.samples import FootSamples
from estimators.gait.foot.parameters import FootParameters
from estimators.gait.foot.trajectory import LOST_SIGMA_MPS
from estimators.recording import Float


class JudgedSamples:
    """Judged ticks, each once, from the first that is not released.

    Parameters
    ----------
    rows : FootRows
        Hold everything; compiled code may judge the next ticks as well.
    number : int
        Of the foot.
    """

    def __init__(
        self, rate_hz: float, parameters: FootParameters, windows: Windows, rows: FootRows, number: int
    ) -> None:
        self._rate_hz, self._parameters, self._windows = rate_hz, parameters, windows
        self._at: Any = rows.foot[number]
        self._inputs: Float = rows.inputs[number]
        self._bits: NDArray[np.uint8] = rows.bits[number]
        self._rate_variance: Float = rows.rate_variance[number]
        self.decision = decision_settings(rate_hz, parameters)
        self.noise = noise_settings(parameters)

    @property
    def count(self) -> int:
        """How many ticks are judged."""
        return int(self._at["judged"])

    @property
    def _judged(self) -> slice:
        start = int(self._at["judged_place"])
        return slice(start, start + self.count)

    @property
    def inputs(self) -> Float:
        """Standard deviation of the contact point's velocity, T, and noise density squared of force, shape (3, N)."""
        return self._inputs[:, self._judged]

    @property
    def bits(self) -> NDArray[np.uint8]:
        """What is measured, shape (N,)."""
        return self._bits[self._judged]

    @property
    def rate_variance(self) -> Float:
        """Noise density squared of turning, shape (N, 3)."""
        return self._rate_variance[self._judged]

    def _grow(self, count: int) -> slice:
        """Make room for further ticks; returns their place."""
        at, judged = self._at, self._judged
        if judged.stop + count > len(self._bits):
            front = slice(judged.stop - judged.start)
            self._inputs[:, front] = self._inputs[:, judged]
            self._bits[front], self._rate_variance[front] = self._bits[judged], self._rate_variance[judged]
            at["judged_place"], judged = 0, front
        at["judged"] += count
        return slice(judged.stop, judged.stop + count)

    def judge(self, samples: FootSamples, first: int, end: int) -> None:
        """Judge the ticks `[first, end)`, which follow those judged before; `samples` know T around them."""
        count = end - first
        # Nothing beyond the ticks that every chunking has seen may count.
        horizon = min(len(samples.statistic), end - samples.origin + self._windows.ahead - self._windows.half)
        new, reference = self._grow(count), np.empty(count)
        inputs, bits = self._inputs[:, new], self._bits[new]
        place = samples.place(first, end)
        sigma = inputs[0]
        decide(
            samples.statistic[:horizon],
            samples.origin,
            first,
            end,
            self._windows,
            self.decision,
            reference,
            sigma,
            bits,
        )
        inputs[1] = samples.statistic[place]
        self._find_noise(samples, place, inputs[2], self._rate_variance[new])
        kind = samples.kind[place]
        if kind.any():
            has_field = (kind & FIELD != 0) & (bits & at.STANCE != 0)
            missing = (kind & MISSING) != 0
            bits |= has_field * np.uint8(at.HEADING)
            # Where nothing is known the foot is taken to go nowhere, loosely.
            bits[missing] = at.STANCE
            sigma[missing] = LOST_SIGMA_MPS

    def _find_noise(
        self, samples: FootSamples, place: slice, force_variance: Float, rate_variance: Float
    ) -> None:
        """Write the noise densities squared of the samples at a place of the buffer."""
        kind = samples.kind
        noise_densities(
            samples.gyroscope,
            samples.force,
            samples.gap_root(),
            kind if ((kind & CLIPPED) != 0).any() else NOT_CUT_OFF,
            place.start,
            place.stop,
            self.noise,
            force_variance,
            rate_variance,
        )
        if kind[place].any():
            add_bridge_noise(
                samples.gyroscope,
                samples.force,
                (kind & (BRIDGED | MISSING)) == BRIDGED,
                (kind & (BRIDGED | MISSING)) != 0,
                place.start,
                place.stop,
                max(1, round(BESIDE_S * self._rate_hz)),
                1,
                1.0 / self._rate_hz,
                force_variance,
                rate_variance,
            )

    def be_wary(self, place: slice, is_measured: NDArray[np.bool_]) -> None:
        """Believe no stance that is one only against the moments around it: those before are missing."""
        limit = self._parameters.stance_ratio * self._parameters.reference_floor
        self.bits[place][is_measured & (self.inputs[1, place] >= limit)] = 0

    def stands(self, count: int) -> NDArray[np.bool_]:
        """Return for the first ticks whether a stance was measured and believed."""
        return np.asarray(((self.bits[:count] & at.STANCE) != 0) & (self.inputs[1, :count] < UNREST))

    def forget(self, count: int) -> None:
        """Drop the first ticks."""
        self._at["judged_place"] += count
        self._at["judged"] -= count

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that later samples depend on."""
        return {
            "inputs": self.inputs.copy(),
            "bits": self.bits.copy(),
            "rate_variance": self.rate_variance.copy(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state`."""
        self._at["judged_place"] = self._at["judged"] = 0
        self._grow(len(state["bits"]))
        self.inputs[:], self.bits[:] = state["inputs"], state["bits"]
        self.rate_variance[:] = state["rate_variance"]
