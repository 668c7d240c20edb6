"""Errors of an instrumented shoe's sensors: load cells and inertial errors as published."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError
from estimators.simulation._errors import SENSOR_PRESETS, SensorErrors, TriadErrors

Float = NDArray[np.float64]


@dataclass(frozen=True)
class LoadCellErrors:
    """Errors of one six-axis force and moment sensor.

    `measured = (I + gain + cross-talk) true + offset + noise`, force and moment; force also leaks into the moment.

    Attributes
    ----------
    gain_sd : float
        Relative, one for all six channels of a sensor.
    cross_talk_sd : float
        Relative, force to force and moment to moment.
    force_offset_sd_n, moment_offset_sd_nm : float
        Drawn once a sensor: what taring takes out.
    force_drift_n_per_s : float
        Limit of a constant drift of the offset.
    force_noise_sd_n, moment_noise_sd_nm : float
        White, per sample.
    """

    gain_sd: float = 0.0
    cross_talk_sd: float = 0.0
    force_to_moment_sd_m: float = 0.0
    force_offset_sd_n: float = 0.0
    moment_offset_sd_nm: float = 0.0
    force_drift_n_per_s: float = 0.0
    force_noise_sd_n: float = 0.0
    moment_noise_sd_nm: float = 0.0

    def apply(self, time_s: Float, load: Float, rng: np.random.Generator) -> Float:
        """Measure true loads, shape (N, 6): force in N, then moment in Nm."""
        gain = np.eye(6) * (1.0 + self.gain_sd * rng.normal())
        for block in (slice(0, 3), slice(3, 6)):
            cross = self.cross_talk_sd * rng.normal(size=(3, 3))
            np.fill_diagonal(cross, 0.0)
            gain[block, block] += cross
        gain[3:, :3] += self.force_to_moment_sd_m * rng.normal(size=(3, 3))
        offset = np.concatenate(
            (self.force_offset_sd_n * rng.normal(size=3), self.moment_offset_sd_nm * rng.normal(size=3))
        )
        drift = np.concatenate((self.force_drift_n_per_s * rng.uniform(-1.0, 1.0, 3), np.zeros(3)))
        noise = rng.normal(size=load.shape) * np.repeat((self.force_noise_sd_n, self.moment_noise_sd_nm), 3)
        return np.asarray(load @ gain.T + offset + drift * time_s[:, None] + noise)


@dataclass(frozen=True)
class ShoeErrors:
    """Errors of the sensors of a shoe."""

    inertial: SensorErrors
    load: LoadCellErrors
    source: str = ""


_NOMINAL_LOAD: Final = LoadCellErrors(
    gain_sd=0.01,
    cross_talk_sd=0.005,
    force_to_moment_sd_m=0.0005,
    force_offset_sd_n=1.0,
    moment_offset_sd_nm=0.05,
    force_noise_sd_n=0.25,
    moment_noise_sd_nm=0.005,
)


def _triad(noise: float, bias: float, scale: float, axes_rad: float, walk: float = 0.0) -> TriadErrors:
    return TriadErrors(
        noise_sd=(noise, noise, noise),
        bias_sd=bias,
        scale_sd=scale,
        cross_axis_sd=axes_rad,
        random_walk_per_root_s=walk,
    )


def shoe_errors(errors: ShoeErrors | SensorErrors | str, rate_hz: float) -> ShoeErrors:
    """Return an error model by name, or the given one.

    Parameters
    ----------
    errors : ShoeErrors, SensorErrors or str
        `ideal`, `shoe_nominal`, `shoe_stress`, any inertial preset (with the nominal load cells), or a model.
    rate_hz : float
        Noise densities are turned into noise a sample, `density * sqrt(rate)`.

    Raises
    ------
    SetupError
        If no preset has that name.

    Notes
    -----
    NOMINAL and STRESS gather what the instrumented-shoe thesis (Schepers 2009, chapters 2 to 4) leaves open:
    NOMINAL has gyroscope noise 0.1 deg/s/sqrt(Hz), bias 0.3 deg/s walking 0.01 deg/s/sqrt(s), scale 0.3 %,
    axes 0.2 deg; accelerometer noise 0.002 m/s^2/sqrt(Hz), bias 0.03 m/s^2, scale 0.2 %, axes 0.1 deg. STRESS
    has the static noise of Luinge and Veltink (2005), 0.01 rad/s and 0.1 m/s^2 a sample at 50 Hz, bias
    1 deg/s and 0.1 m/s^2, scale 0.5 %.
    """
    if isinstance(errors, ShoeErrors):
        return errors
    if isinstance(errors, SensorErrors):
        return ShoeErrors(errors, _NOMINAL_LOAD, errors.source)
    if errors == "ideal":
        # The exact rate at the instants, because that is the truth the tests compare with.
        return ShoeErrors(
            replace(SENSOR_PRESETS["ideal"], gyroscope_sampling="instant"), LoadCellErrors(), "no error"
        )
    magnetometer = SENSOR_PRESETS["nominal"].magnetometer
    root_rate = float(np.sqrt(rate_hz))
    at_50_hz = root_rate / float(np.sqrt(50.0))
    degree = float(np.radians(1.0))
    triads = {
        "shoe_nominal": (
            _triad(0.1 * degree * root_rate, 0.3 * degree, 0.003, 0.2 * degree, 0.01 * degree),
            _triad(0.002 * root_rate, 0.03, 0.002, 0.1 * degree),
        ),
        "shoe_stress": (
            _triad(0.01 * at_50_hz, degree, 0.005, 0.2 * degree, 0.01 * degree),
            _triad(0.1 * at_50_hz, 0.1, 0.005, 0.1 * degree),
        ),
    }
    if errors in triads:
        source = f"{errors.removeprefix('shoe_').upper()} of the instrumented-shoe protocols"
        inertial = SensorErrors(
            *triads[errors], magnetometer=magnetometer, gyroscope_sampling="instant", source=source
        )
        return ShoeErrors(inertial, _NOMINAL_LOAD, source)
    if errors in SENSOR_PRESETS:
        preset = SENSOR_PRESETS[errors]
        return ShoeErrors(preset, _NOMINAL_LOAD, preset.source)
    known = ("ideal", "shoe_nominal", "shoe_stress", *SENSOR_PRESETS)
    raise SetupError(f"no sensor error model is named {errors!r}; known: {', '.join(dict.fromkeys(known))}")
