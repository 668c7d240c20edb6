"""What the detector and the noise model say of samples that the live filter has not released yet."""

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
from estimators.gait.foot.parameters import FootParameters
from estimators.gait.foot.samples import BRIDGED, CLIPPED, FIELD, MISSING, FootSamples
from estimators.gait.foot.trajectory import LOST_SIGMA_MPS
from estimators.recording import Float


class JudgedSamples:
    """Judged ticks, each once, from the first that is not released.

    Attributes
    ----------
    inputs : ndarray, shape (3, N)
        Standard deviation of the contact point's velocity, T, and noise density squared of force.
    bits : ndarray of uint8, shape (N,)
        What is measured.
    rate_variance : ndarray, shape (N, 3)
        Noise density squared of turning.
    """

    def __init__(self, rate_hz: float, parameters: FootParameters, windows: Windows) -> None:
        self._rate_hz, self._parameters, self._windows = rate_hz, parameters, windows
        self.inputs = np.empty((3, 0))
        self.bits = np.empty(0, dtype=np.uint8)
        self.rate_variance = np.empty((0, 3))
        self._decision = decision_settings(rate_hz, parameters)
        self._noise = noise_settings(parameters)

    def judge(self, samples: FootSamples, first: int, end: int) -> None:
        """Judge the ticks `[first, end)`, which follow those judged before; `samples` know T around them."""
        count = end - first
        # Nothing beyond the ticks that every chunking has seen may count.
        horizon = min(len(samples.statistic), end - samples.origin + self._windows.ahead - self._windows.half)
        inputs, reference = np.empty((3, count)), np.empty(count)
        bits, rate_variance = np.empty(count, dtype=np.uint8), np.empty((count, 3))
        place = samples.place(first, end)
        sigma = inputs[0]
        decide(
            samples.statistic[:horizon],
            samples.origin,
            first,
            end,
            self._windows,
            self._decision,
            reference,
            sigma,
            bits,
        )
        inputs[1] = samples.statistic[place]
        self._find_noise(samples, place, inputs[2], rate_variance)
        kind = samples.kind[place]
        if kind.any():
            has_field = (kind & FIELD != 0) & (bits & at.STANCE != 0)
            missing = (kind & MISSING) != 0
            bits |= has_field * np.uint8(at.HEADING)
            # Where nothing is known the foot is taken to go nowhere, loosely.
            bits[missing] = at.STANCE
            sigma[missing] = LOST_SIGMA_MPS
        self.inputs = np.concatenate([self.inputs, inputs], axis=1)
        self.bits = np.concatenate([self.bits, bits])
        self.rate_variance = np.concatenate([self.rate_variance, rate_variance])

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
            self._noise,
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
        self.inputs, self.bits = self.inputs[:, count:], self.bits[count:]
        self.rate_variance = self.rate_variance[count:]

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that later samples depend on."""
        return {
            "inputs": self.inputs.copy(),
            "bits": self.bits.copy(),
            "rate_variance": self.rate_variance.copy(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state`."""
        self.inputs, self.bits = np.array(state["inputs"]), np.array(state["bits"])
        self.rate_variance = np.array(state["rate_variance"])


__all__ = ["JudgedSamples"]
