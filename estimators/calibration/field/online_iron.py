"""Hard iron found again while the sensors are in use, from how the field turns against the gyroscope."""

from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.kernels.array_filter import StoredArrays
from estimators.recording import Float, ImuChunk

_WINDOW_S: Final = 0.3
_LEAST_TURN_RAD: Final = 0.12
_LARGEST_TURN_RAD: Final = 2.5
_GATE: Final = 3.0


class OnlineHardIron(StoredArrays):
    """Follows what is left of the hard iron of S sensors during a session.

    In a uniform field the reading turns with the sensor, all but the hard iron, which stays:
    `m2 - dR' m1 = (I - dR') o` for any two moments with the turn dR between them (from the gyroscope). That is
    linear in the offset o and needs neither full coverage nor the norm, so ordinary movement tells it. A
    Kalman filter of three states a sensor; where the field changes with place the gate and the noise hold it.

    Parameters
    ----------
    start_sigma_t : float
        How far the earlier calibration may be off, per axis.
    noise_t : float
        Of one comparison over 0.3 s: mostly how the field changes with place.
    drift_t_per_root_s : float
        How fast the hard iron may change.
    """

    _ARRAYS: ClassVar[tuple[str, ...]] = ("offset", "covariance", "turn", "start", "used")

    def __init__(
        self,
        sensor_count: int,
        time_step_s: float,
        *,
        start_sigma_t: float = 10e-6,
        noise_t: float = 1.0e-6,
        drift_t_per_root_s: float = 0.02e-6,
    ) -> None:
        if sensor_count < 1 or not 0.0 < time_step_s <= 0.1:
            raise SetupError(
                f"{sensor_count} sensors at steps of {time_step_s} s; at least one, at most 0.1 s"
            )
        self._count, self._step_s = sensor_count, time_step_s
        self._window = max(2, round(_WINDOW_S / time_step_s))
        self._noise, self._drift = noise_t, drift_t_per_root_s
        self._offset = np.zeros((sensor_count, 3))
        self._covariance = np.tile(np.eye(3) * start_sigma_t**2, (sensor_count, 1, 1))
        self._turn = rotation.identity((sensor_count,))
        self._start = np.full((sensor_count, 3), np.nan)
        self._used = np.zeros(sensor_count, dtype=np.int64)

    @property
    def offset_t(self) -> Float:
        """Hard iron left in the readings, shape (S, 3), sensor axes: subtract it."""
        return self._offset.copy()

    @property
    def sigma_t(self) -> Float:
        """Its one-sigma, shape (S, 3)."""
        return np.asarray(np.sqrt(np.einsum("sii->si", self._covariance)))

    @property
    def used(self) -> NDArray[np.int64]:
        """Comparisons that passed the gate, shape (S,)."""
        return self._used.copy()

    def is_known(self, sigma_t: float = 1.5e-6) -> NDArray[np.bool_]:
        """Return which sensors' offset is known on all axes to the given sigma, shape (S,)."""
        return np.asarray((self.sigma_t < sigma_t).all(axis=1))

    def update(self, chunk: ImuChunk, gyroscope_bias_radps: Float | None = None) -> Float:
        """Take the next ticks and return the offset, shape (S, 3).

        Parameters
        ----------
        chunk : ImuChunk
            Magnetometer after the device's own calibration. Missing samples break a comparison off.
        gyroscope_bias_radps : ndarray, shape (S, 3), optional
            As the orientation filter knows it.
        """
        if chunk.sensor_count != self._count:
            raise ShapeError(f"{chunk.sensor_count} sensors; this one follows {self._count}")
        if chunk.magnetometer_t is None:
            return self.offset_t
        rate = chunk.gyroscope_radps
        if gyroscope_bias_radps is not None:
            rate = rate - gyroscope_bias_radps[:, None]
        steps = rotation.exp(rate * chunk.time_step_s)
        for k in range(chunk.tick_count):
            self._turn = rotation.multiply(self._turn, steps[:, k])
            if (chunk.first_tick + k) % self._window == 0:
                self._compare(chunk.magnetometer_t[:, k])
        return self.offset_t

    def _compare(self, field: Float) -> None:
        """Close a window at this reading and open the next."""
        self._covariance += np.eye(3) * self._drift**2 * self._window * self._step_s
        turned_rad = 2.0 * np.arccos(np.clip(np.abs(self._turn[:, 0]), 0.0, 1.0))
        sound = np.isfinite(self._start).all(axis=1) & np.isfinite(field).all(axis=1)
        sound &= np.isfinite(self._turn).all(axis=1)
        sound &= (turned_rad > _LEAST_TURN_RAD) & (turned_rad < _LARGEST_TURN_RAD)
        for s in np.flatnonzero(sound):
            back = rotation.to_matrix(rotation.conjugate(self._turn[s]))
            model = np.eye(3) - back
            innovation = field[s] - back @ self._start[s] - model @ self._offset[s]
            # A gyroscope scale error of a percent turns the whole field by a percent of the angle.
            noise = self._noise**2 + (0.01 * turned_rad[s] * float(np.linalg.norm(field[s]))) ** 2
            spread = model @ self._covariance[s] @ model.T + noise * np.eye(3)
            if innovation @ np.linalg.solve(spread, innovation) > 3.0 * _GATE**2:
                continue
            gain = np.linalg.solve(spread, model @ self._covariance[s]).T
            self._offset[s] += gain @ innovation
            keep = np.eye(3) - gain @ model
            self._covariance[s] = keep @ self._covariance[s] @ keep.T + noise * gain @ gain.T
            self._used[s] += 1
        self._start = np.array(field, dtype=np.float64)
        self._turn = rotation.identity((self._count,))
