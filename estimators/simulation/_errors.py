"""Errors of a real sensor: error models as plain dataclasses, with named and sourced presets."""

from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError

Float = NDArray[np.float64]
Vector = tuple[float, float, float]

_ZERO: Final[Vector] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class TriadErrors:
    """Errors of one three-axis sensor, in its SI unit.

    `measured = clip(round((I + scale and cross-axis) true + bias + random walk + noise))`

    Attributes
    ----------
    noise_sd : tuple of 3 floats
        White, per sample, whatever the rate.
    bias : tuple of 3 floats
        The same for every sensor.
    bias_sd, scale_sd, cross_axis_sd : float
        Drawn once a sensor, normal; scale and cross-axis are relative.
    random_walk_per_root_s, drift_limit_per_s : float
        Wander of the bias, and a constant drift drawn within plus and minus the limit (temperature).
    resolution : float
        One count; 0 for none.
    limit : float
        Clip level.
    """

    noise_sd: Vector = _ZERO
    bias: Vector = _ZERO
    bias_sd: float = 0.0
    scale_sd: float = 0.0
    cross_axis_sd: float = 0.0
    random_walk_per_root_s: float = 0.0
    drift_limit_per_s: float = 0.0
    resolution: float = 0.0
    limit: float = np.inf

    def bias_over(self, time_s: Float, rng: np.random.Generator) -> Float:
        """Draw the bias of one sensor over time, shape (N, 3)."""
        constant = np.array(self.bias) + self.bias_sd * rng.normal(size=3)
        drift = self.drift_limit_per_s * rng.uniform(-1.0, 1.0, 3)
        steps = (
            rng.normal(size=(time_s.shape[0], 3))
            * np.sqrt(np.maximum(np.diff(time_s, prepend=0.0), 0.0))[:, None]
        )
        walk = self.random_walk_per_root_s * np.cumsum(steps, axis=0)
        return np.asarray(constant + drift * time_s[:, None] + walk)

    def apply(self, true: Float, bias: Float, rng: np.random.Generator) -> Float:
        """Measure true values, shape (N, 3), with a bias from `bias_over`."""
        gain = np.eye(3) + np.diag(self.scale_sd * rng.normal(size=3))
        cross = self.cross_axis_sd * rng.normal(size=(3, 3))
        np.fill_diagonal(cross, 0.0)
        measured = true @ (gain + cross).T + bias + rng.normal(size=true.shape) * np.array(self.noise_sd)
        if self.resolution > 0.0:
            measured = self.resolution * np.round(measured / self.resolution)
        return np.asarray(np.clip(measured, -self.limit, self.limit))


@dataclass(frozen=True)
class SensorErrors:
    """Errors of one nine-axis device.

    Attributes
    ----------
    gyroscope, accelerometer, magnetometer : TriadErrors
        rad/s, m/s^2, T.
    gyroscope_sampling : str
        `mean`: each sample is the mean rate since the last one, as devices that integrate inside give, so
        that summing up samples gives the turn exactly; `instant`: the rate at the sample time.
    source : str
        Where the figures come from.
    """

    gyroscope: TriadErrors = TriadErrors()
    accelerometer: TriadErrors = TriadErrors()
    magnetometer: TriadErrors = TriadErrors()
    gyroscope_sampling: Literal["mean", "instant"] = "mean"
    source: str = ""


def _degrees(*values: float) -> Vector:
    x, y, z = np.radians(values)
    return float(x), float(y), float(z)


def _times(factor: float, *values: float) -> Vector:
    x, y, z = (factor * value for value in values)
    return x, y, z


_THESIS_FIELD_T = 49e-6

_MARZOUK: Final = SensorErrors(
    gyroscope=TriadErrors(
        noise_sd=_degrees(0.4960, 0.6001, 0.5181),
        bias=_degrees(-0.8229, 0.7879, 0.5597),
        resolution=float(np.radians(0.07326)),
        limit=float(np.radians(300.0)),
    ),
    accelerometer=TriadErrors(
        noise_sd=_times(GRAVITY_MPS2, 0.0169, 0.0134, 0.01469),
        # Printed for the gravity-positive sign; specific force has the other one.
        bias=_times(-GRAVITY_MPS2, -0.0158, 0.0068, 0.0176),
        resolution=2.522e-3 * GRAVITY_MPS2,
        limit=10.0 * GRAVITY_MPS2,
    ),
    magnetometer=TriadErrors(
        noise_sd=_times(_THESIS_FIELD_T, 0.0031, 0.0131, 0.0302), resolution=1.5e-8, limit=1.1e-3
    ),
    gyroscope_sampling="instant",
    source="Marzouk (2009) tables 2.1, 2.2, 2.4 and appendices A, B, with errata: ADIS16355, MicroMag-3; "
    "per-sample figures of 17 Hz; normalised magnetometer figures times a field of 49 uT",
)

# What is left after the static calibration A2 over 150 samples: the standard error of the gyroscope bias,
# and an accelerometer whose bias was taken out in a known pose.
_MARZOUK_CALIBRATED: Final = replace(
    _MARZOUK,
    gyroscope=replace(_MARZOUK.gyroscope, bias=_ZERO, bias_sd=float(np.radians(0.045))),
    accelerometer=replace(_MARZOUK.accelerometer, bias=_ZERO),
    source=_MARZOUK.source + "; biases removed as by its static calibration",
)

SENSOR_PRESETS: Final[dict[str, SensorErrors]] = {
    "ideal": SensorErrors(source="no error at all"),
    "nominal": SensorErrors(
        gyroscope=TriadErrors(
            noise_sd=(0.01, 0.01, 0.01),
            bias_sd=float(np.radians(0.3)),
            scale_sd=0.003,
            cross_axis_sd=0.003,
            random_walk_per_root_s=float(np.radians(0.3e-3) * 10.0),
            drift_limit_per_s=float(np.radians(0.1) / 60.0),
            resolution=float(np.radians(2000.0 / 32768.0)),
            limit=float(np.radians(2000.0)),
        ),
        accelerometer=TriadErrors(
            noise_sd=(0.1, 0.1, 0.1),
            bias_sd=0.05,
            scale_sd=0.002,
            cross_axis_sd=0.003,
            resolution=16.0 * GRAVITY_MPS2 / 32768.0,
            limit=16.0 * GRAVITY_MPS2,
        ),
        magnetometer=TriadErrors(
            noise_sd=(0.5e-7, 0.5e-7, 0.5e-7),
            bias_sd=0.003 * _THESIS_FIELD_T,
            scale_sd=0.003,
            cross_axis_sd=0.003,
            resolution=1.5e-7,
            limit=4.9e-3,
        ),
        source="noise, offset walk and ramp, calibration residuals: Luinge and Veltink (2005) section 4.2, "
        "Roetenberg (2006) section 5.2.1 as gathered for 100 Hz simulations; resolution and range of common "
        "16-bit devices",
    ),
    "marzouk_2009": _MARZOUK,
    "marzouk_2009_calibrated": _MARZOUK_CALIBRATED,
}
"""Named error models; `source` says where the figures come from."""


def sensor_errors(errors: SensorErrors | str) -> SensorErrors:
    """Return a preset by name, or the given model.

    Raises
    ------
    SetupError
        If no preset has that name.
    """
    if isinstance(errors, SensorErrors):
        return errors
    if errors not in SENSOR_PRESETS:
        raise SetupError(f"no sensor error model is named {errors!r}; known: {', '.join(SENSOR_PRESETS)}")
    return SENSOR_PRESETS[errors]
