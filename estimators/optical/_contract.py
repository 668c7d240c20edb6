"""Input and output of the fusion of markers with an inertial module."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from estimators.errors import ShapeError
from estimators.optical import _layout as at
from estimators.recording import Float
from estimators.samples import Samples


class Provenance(IntEnum):
    """Where the position of a tick comes from."""

    NONE = 0
    """Before the start."""
    FILLED = 1
    """No marker: inertial."""
    MEASURED = 2
    REJECTED = 3
    """A marker that does not fit: a ghost or a wrong label."""
    RECOVERED = 4
    """Markers had not fitted for so long that the filter, not they, must have been wrong."""


@dataclass(frozen=True)
class OpticalParameters:
    """Figures of the method page (4.2); noise is per sample.

    `lever_arm_m` leads from the accelerometer to the marker in sensor axes; with a sigma it is learnt. `heading_rad`
    turns the sensor's level start into the laboratory: the heading that the sensor's x axis has there. `gate` is
    chi-square with 3 degrees of freedom; after `recover_s` of markers that all miss it the filter gives in. `start_s`
    of standstill with the marker in sight begin the filter, unless it is begun from a known state.
    """

    force_sigma_mps2: float = 0.05
    rate_sigma_radps: float = 0.01
    marker_sigma_m: float = 0.0005
    force_walk: float = 1e-4
    rate_walk: float = 1e-5
    gate: float = 16.27
    recover_s: float = 2.0
    lever_arm_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    lever_arm_sigma_m: float = 0.0
    heading_rad: float = 0.0
    heading_sigma_deg: float = 2.0
    start_s: float = 1.5
    force_bias_sigma_mps2: float = 0.05
    rate_bias_sigma_radps: float = 0.003


@dataclass(frozen=True)
class OpticalChunk(Samples):
    """Consecutive ticks: gyroscope and accelerometer, shape (K, 3), markers (K, 3) with NaN where none was seen.

    `marker_delay_s`, shape (K,), tells by how much a marker's frame is later than its tick; none by default. `noise`,
    shape (K, 2), tells how many times noisier than assumed rate and force are; samples that were interpolated are.
    """

    first_tick: int
    time_step_s: float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    marker_m: Float
    marker_delay_s: Float | None = None
    noise: Float | None = None

    def table(self) -> Float:
        """Return the samples as the compiled loop takes them, shape (K, 12)."""
        parts = (self.gyroscope_radps, self.accelerometer_mps2, self.marker_m)
        count = len(self.gyroscope_radps)
        if any(part.shape != (count, 3) for part in parts):
            raise ShapeError(f"gyroscope, accelerometer and markers all need shape ({count}, 3)")
        delay = np.zeros(count) if self.marker_delay_s is None else self.marker_delay_s
        if delay.shape != (count,):
            raise ShapeError(f"marker_delay_s needs shape ({count},), not {delay.shape}")
        noise = np.ones((count, 2)) if self.noise is None else self.noise
        if noise.shape != (count, 2) or not (noise >= 1.0).all():
            raise ShapeError(f"noise needs shape ({count}, 2) with values of one or more")
        table = np.ascontiguousarray(np.column_stack((*parts, delay, noise)), dtype=np.float64)
        if not np.isfinite(table[:, : at.MARKER]).all():
            raise ShapeError("inertial samples are missing; bridge short gaps first, split at long ones")
        return table


@dataclass(frozen=True)
class OpticalStart:
    """A known state to begin from, at the tick that is given next; laboratory frame with z up."""

    position_m: Float
    velocity_mps: Float
    q_room_sensor: Float
    rate_bias_radps: Float
    position_sigma_m: float = 0.003
    velocity_sigma_mps: float = 0.1
    tilt_sigma_rad: float = 0.03
    heading_sigma_rad: float = 0.1


@dataclass(frozen=True)
class OpticalResult:
    """Motion of the accelerometer over K ticks, laboratory frame with z up.

    Attributes
    ----------
    position_m, velocity_mps, acceleration_mps2 : ndarray, shape (K, 3)
        NaN before the start.
    q_room_sensor : ndarray, shape (K, 4)
        Identity before the start.
    marker_m : ndarray, shape (K, 3)
        Where the marker is: the position with the lever arm.
    lever_arm_m, force_bias_mps2, rate_bias_radps : ndarray, shape (K, 3)
        Sensor axes.
    position_sigma_m, velocity_sigma_mps, attitude_sigma_rad, lever_arm_sigma_m : ndarray, shape (K, 3)
    innovation_m : ndarray, shape (K, 3)
        Marker minus what the filter expected, before it was taken; NaN without one.
    nis : ndarray, shape (K,)
        Innovation of the marker squared, in units of its covariance; NaN without one.
    provenance : ndarray of uint8, shape (K,)
    """

    position_m: Float
    velocity_mps: Float
    acceleration_mps2: Float
    q_room_sensor: Float
    marker_m: Float
    lever_arm_m: Float
    force_bias_mps2: Float
    rate_bias_radps: Float
    position_sigma_m: Float
    velocity_sigma_mps: Float
    attitude_sigma_rad: Float
    lever_arm_sigma_m: Float
    innovation_m: Float
    nis: Float
    provenance: NDArray[np.uint8]
