"""Centre of mass with an anchor that knows angular momentum: Kalman filter live, with a smoother off-line."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.balance.mass_centre import _kernel as kernel
from estimators.balance.mass_centre._kernel import STATES, forward
from estimators.balance.mass_centre._published import (
    MassCentre,
    acceleration,
    momentum_anchor,
    vertical_mass_centre,
)
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.kernels.array_filter import StoredArrays
from estimators.recording import Float


@dataclass(frozen=True)
class MassCentreParameters:
    """Noise of the improved centre of mass; densities, so that they hold at every rate.

    Attributes
    ----------
    anchor_density : float
        Error of the anchor, m/sqrt(Hz): 0.03 m a sample at 50 Hz.
    acceleration_density : float
        Error of the force, m/s^2/sqrt(Hz): 0.05 m/s^2 a sample at 50 Hz.
    acceleration_walk : float
        Random walk of the acceleration's constant error (tilt, gain), m/s^2/sqrt(s).
    standing_density : float
        Speed of somebody who stands, m/s/sqrt(Hz): 0.02 m/s a sample at 50 Hz.
    start_sigma : tuple of 3 floats
        Of position (m), velocity (m/s) and acceleration error (m/s^2) at the start.
    vertical_cutoff_hz : float
        Of the high-pass of the vertical, see `published_mass_centre`.
    """

    anchor_density: float = 0.03 / 50.0**0.5
    acceleration_density: float = 0.05 / 50.0**0.5
    acceleration_walk: float = 0.003
    standing_density: float = 0.02 / 50.0**0.5
    start_sigma: tuple[float, float, float] = (0.05, 0.02, 0.1)
    vertical_cutoff_hz: float = 0.5

    def __post_init__(self) -> None:
        values = (
            self.anchor_density,
            self.acceleration_density,
            self.acceleration_walk,
            self.standing_density,
            *self.start_sigma,
            self.vertical_cutoff_hz,
        )
        if not all(np.isfinite(values)) or min(values) <= 0.0:
            raise SetupError("noise of the centre of mass must be finite and above zero")


def smooth_mass_centre(
    force_n: Float,
    cop_m: Float,
    rate_hz: float,
    mass_kg: float,
    mean_height_m: float,
    is_standing: NDArray[np.bool_] | None = None,
    parameters: MassCentreParameters | None = None,
) -> MassCentre:
    """Estimate the centre of mass off-line: Kalman filter and Rauch-Tung-Striebel smoother.

    Parameters
    ----------
    force_n, cop_m : ndarray, shape (N, 3)
        Of both feet, finite.
    mean_height_m : float
        Of the centre of mass above the floor.
    is_standing : ndarray of bool, shape (N,), optional
        Where the person stands and so does not move on.

    Returns
    -------
    MassCentre
        With sigma in x and y; of the vertical it is not known (NaN).

    Raises
    ------
    ShapeError
        For values that are not finite.

    Notes
    -----
    Per axis `c'' = a - b` with a slowly changing error b; measured is `p + z F_xy / F_z` at all times, and
    rest while standing. The vertical stays the published high-pass.
    """
    chosen = parameters or MassCentreParameters()
    if not (np.isfinite(force_n).all() and np.isfinite(cop_m).all()):
        raise ShapeError("force and pressure centre must be finite; bridge gaps first (total_reaction does)")
    rate = acceleration(force_n, mass_kg)
    height = vertical_mass_centre(force_n, rate_hz, mass_kg, mean_height_m, chosen.vertical_cutoff_hz)
    anchor = momentum_anchor(force_n, cop_m, height - cop_m[:, 2])
    samples = force_n.shape[0]
    resting = np.zeros(samples, dtype=np.bool_) if is_standing is None else is_standing
    bits = np.asarray(1 + 2 * resting, dtype=np.uint8)
    records = _Records(samples)
    x, p = np.zeros((2, STATES)), np.diag(np.square(chosen.start_sigma))
    records.run(_settings(chosen, rate_hz), rate[:, :2], anchor[:, :2], bits, x, p)
    state, covariance = records.smoothed(1.0 / rate_hz)
    sigma = np.sqrt(covariance[:, 0, 0])
    return MassCentre(
        np.column_stack((state[:, 0, 0], state[:, 1, 0], height)),
        np.column_stack((state[:, 0, 1], state[:, 1, 1], np.gradient(height, 1.0 / rate_hz))),
        rate,
        np.column_stack((sigma, sigma, np.full(samples, np.nan))),
    )


class LiveMassCentre(StoredArrays):
    """Centre of mass while somebody walks; chunks give the same as one batch, bit for bit.

    It adds no delay of its own: an estimate belongs to the sample of force and pressure centre that it was
    made from. What delays a view is the pose of the feet (`input_delay_s`), which is known best after the
    stance that ends a stride.

    Parameters
    ----------
    input_delay_s : float
        How late force and pressure centre are given; only passed on.
    """

    version = "1"
    _ARRAYS: ClassVar[tuple[str, ...]] = ("settings", "x", "p", "vertical")

    def __init__(
        self,
        rate_hz: float,
        mass_kg: float,
        mean_height_m: float,
        parameters: MassCentreParameters | None = None,
        input_delay_s: float = 0.0,
    ) -> None:
        chosen = parameters or MassCentreParameters()
        if not rate_hz > 0.0 or not mass_kg > 0.0:
            raise SetupError(f"rate {rate_hz} Hz and mass {mass_kg} kg must be above zero")
        self._rate_hz, self._mass_kg, self._mean_height_m = rate_hz, mass_kg, mean_height_m
        self._settings = _settings(chosen, rate_hz)
        self._x, self._p = np.zeros((2, STATES)), np.diag(np.square(chosen.start_sigma))
        # Vertical: two damped integrators, the causal kin of the high-pass; height above its mean and speed.
        self._vertical = np.zeros(3)
        self._pull = 2.0 * np.pi * chosen.vertical_cutoff_hz
        self.delay_s = input_delay_s

    def update(self, force_n: Float, cop_m: Float, is_standing: NDArray[np.bool_]) -> MassCentre:
        """Take the next samples, shape (K, 3), (K, 3) and (K,).

        NaN in the pressure centre or force lets the estimate coast on what it knows; NaN comes out before
        the first usable sample.
        """
        samples = force_n.shape[0]
        usable = np.asarray(np.isfinite(force_n).all(axis=1) & np.isfinite(cop_m).all(axis=1))
        force = np.where(usable[:, None], force_n, [0.0, 0.0, self._mass_kg * GRAVITY_MPS2])
        rate = acceleration(force, self._mass_kg)
        height, climb = self._heights(rate[:, 2])
        floor = np.where(usable, cop_m[:, 2], 0.0)
        anchor = momentum_anchor(force, np.where(usable[:, None], cop_m, 0.0), height - floor)
        bits = np.asarray(usable + 2 * (is_standing & usable), dtype=np.uint8)
        known = np.full(samples, self._settings[kernel.STARTED] > 0.0) | np.maximum.accumulate(usable)
        records = _Records(samples)
        records.run(self._settings, rate[:, :2], anchor[:, :2], bits, self._x, self._p)
        state = np.where(known[:, None, None], records.filtered, np.nan)
        sigma = np.sqrt(records.filtered_covariance[:, 0, 0])
        return MassCentre(
            np.column_stack((state[:, 0, 0], state[:, 1, 0], height)),
            np.column_stack((state[:, 0, 1], state[:, 1, 1], climb)),
            rate,
            np.column_stack((sigma, sigma, np.full(samples, np.nan))),
        )

    def _heights(self, upward_mps2: Float) -> tuple[Float, Float]:
        """Integrate twice with a pull back to rest: `z'' = a - 1.4 w z' - w^2 z`, a high-pass of a."""
        step_s, pull = 1.0 / self._rate_hz, 0.25 * self._pull
        offset, speed, error = self._vertical
        result = np.empty((upward_mps2.size, 2))
        for i, value in enumerate(upward_mps2):
            error += step_s * 0.1 * (value - error)
            speed += step_s * (value - error - 1.4 * pull * speed - pull**2 * offset)
            offset += step_s * speed
            result[i] = self._mean_height_m + offset, speed
        self._vertical = np.array([offset, speed, error])
        return result[:, 0], result[:, 1]


class _Records:
    """What the filter said at every sample, for the way back."""

    def __init__(self, samples: int) -> None:
        self.predicted = np.empty((samples, 2, STATES))
        self.predicted_covariance = np.empty((samples, STATES, STATES))
        self.filtered = np.empty((samples, 2, STATES))
        self.filtered_covariance = np.empty((samples, STATES, STATES))

    def run(
        self, settings: Float, rate: Float, anchor: Float, bits: NDArray[np.uint8], x: Float, p: Float
    ) -> None:
        forward(
            settings,
            np.ascontiguousarray(rate),
            np.ascontiguousarray(anchor),
            bits,
            x,
            p,
            self.predicted,
            self.predicted_covariance,
            self.filtered,
            self.filtered_covariance,
        )

    def smoothed(self, step_s: float) -> tuple[Float, Float]:
        """Return states, shape (N, 2, 3), and covariances, shape (N, 3, 3), that know the whole record."""
        transition = np.array([[1.0, step_s, -0.5 * step_s**2], [0.0, 1.0, -step_s], [0.0, 0.0, 1.0]])
        state, covariance = self.filtered.copy(), self.filtered_covariance.copy()
        gains = np.linalg.solve(
            self.predicted_covariance[1:], transition @ self.filtered_covariance[:-1]
        ).swapaxes(-1, -2)
        for i in range(state.shape[0] - 2, -1, -1):
            gain = gains[i]
            state[i] += (state[i + 1] - self.predicted[i + 1]) @ gain.T
            covariance[i] += gain @ (covariance[i + 1] - self.predicted_covariance[i + 1]) @ gain.T
        return state, covariance


def _settings(parameters: MassCentreParameters, rate_hz: float) -> Float:
    settings = np.zeros(kernel.SETTINGS)
    settings[kernel.STEP] = 1.0 / rate_hz
    settings[kernel.FORCE2] = parameters.acceleration_density**2
    settings[kernel.BIAS2] = parameters.acceleration_walk**2
    settings[kernel.ANCHOR2] = parameters.anchor_density**2
    settings[kernel.STANDING2] = parameters.standing_density**2
    return settings
