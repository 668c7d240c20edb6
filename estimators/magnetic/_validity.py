"""Where a coil can be used: linearisation error, curvature, range, size, and the distance that implants need."""

import math

import numpy as np
from numpy.typing import ArrayLike

from estimators.errors import SetupError
from estimators.magnetic._coil import Coil, Source
from estimators.magnetic._loop_kernel import MU0_TM_PER_A
from estimators.recording import Float

PACEMAKER_LIMIT_T = 5e-4
"""Static field from which pacemakers may change their mode (5 G)."""


def linearisation_error_percent(source: Source, coil: int, position_m: ArrayLike, step_m: ArrayLike) -> Float:
    """Return what the first-order prediction misses after a step, in percent of the field there, shape (...).

    Schepers and Veltink 2010, section 3.2 (Fig. 7); method page 4.7.
    """
    position, step = np.asarray(position_m, dtype=np.float64), np.asarray(step_m, dtype=np.float64)
    field, gradient = source.field_and_gradient(coil, 1.0, position)
    after = source.field(coil, 1.0, position + step)
    linear = field + np.einsum("...ij,...j->...i", gradient, np.broadcast_to(step, field.shape))
    return np.asarray(
        100.0 * np.linalg.norm(after - linear, axis=-1) / np.linalg.norm(field, axis=-1), dtype=np.float64
    )


def curvature_per_m2(source: Source, coil: int, position_m: ArrayLike, step_m: float = 1e-4) -> Float:
    """Return ``|d2B/dp_i^2| / |B|`` along the three axes, shape (..., 3): predicts the linearisation error.

    The error of a step a along axis i is about 50 a^2 times this, in percent (method page 4.7).
    """
    position = np.asarray(position_m, dtype=np.float64)
    size = np.linalg.norm(source.field(coil, 1.0, position), axis=-1)
    found = []
    for axis in range(3):
        step = step_m * np.eye(3)[axis]
        _, ahead = source.field_and_gradient(coil, 1.0, position + step)
        _, behind = source.field_and_gradient(coil, 1.0, position - step)
        second = (ahead[..., axis] - behind[..., axis]) / (2.0 * step_m)
        found.append(np.linalg.norm(second, axis=-1) / size)
    return np.stack(found, axis=-1)


def range_m(moment_am2: float, signal_to_noise: float, noise_t: float) -> float:
    """Return the distance at which the field in the plane of the coil is so many times the noise (4.8)."""
    _positive(moment_am2=moment_am2, signal_to_noise=signal_to_noise, noise_t=noise_t)
    return float((MU0_TM_PER_A * moment_am2 / (4.0 * math.pi * signal_to_noise * noise_t)) ** (1.0 / 3.0))


def required_moment_am2(range_limit_m: float, signal_to_noise: float, noise_t: float) -> float:
    """Return the moment that reaches a range with a signal-to-noise ratio (Roetenberg eq. 5.5)."""
    _positive(range_limit_m=range_limit_m, signal_to_noise=signal_to_noise, noise_t=noise_t)
    return 4.0 * math.pi * range_limit_m**3 * signal_to_noise * noise_t / MU0_TM_PER_A


def axial_dipole_error(radius_m: ArrayLike, distance_m: ArrayLike) -> Float:
    """Return by which part a dipole overstates the field of a loop on its axis (Roetenberg eq. 5.4)."""
    ratio = np.asarray(radius_m, dtype=np.float64) / np.asarray(distance_m, dtype=np.float64)
    return np.asarray((1.0 + ratio**2) ** 1.5 - 1.0)


def axial_reach_m(source: Source, limit_t: float) -> float:
    """Return how far on its axis the strongest coil exceeds a field at full current; zero if nowhere."""
    _positive(limit_t=limit_t)
    farthest = 0.0
    for coil in source.coils:
        # mu0 N I b^2 / (2 (b^2 + z^2)^1.5) = limit
        moment = MU0_TM_PER_A * coil.turns * source.current_limit_a * coil.radius_m**2
        reach = (0.5 * moment / limit_t) ** (2.0 / 3.0) - coil.radius_m**2
        farthest = max(farthest, math.sqrt(max(reach, 0.0)))
    return farthest


def keep_away_distance_m(source: Source, limit_t: float = PACEMAKER_LIMIT_T) -> float:
    """Return the distance from a coil's centre beyond which, in all directions, it stays below a field.

    At full current, for the strongest coil. Beside the wire the field is stronger than on the axis, so that this is
    more than `axial_reach_m`. People with a pacemaker or a similar implant must not wear a source at all; this
    number is for those beside them.
    """
    _positive(limit_t=limit_t)
    farthest = 0.0
    polar = np.linspace(0.0, 0.5 * math.pi, 91)
    for coil in source.coils:
        alone = Source((Coil(coil.turns, coil.radius_m),), "exact", source.current_limit_a)
        directions = np.stack([np.sin(polar), np.zeros_like(polar), np.cos(polar)], axis=1)
        # Outside the wire the strongest field at a distance falls with the distance.
        near, far = coil.radius_m * (1.0 + 1e-6), 100.0 * coil.radius_m
        for _ in range(60):
            middle = 0.5 * (near + far)
            strongest = np.linalg.norm(
                alone.field(0, source.current_limit_a, middle * directions), axis=1
            ).max()
            near, far = (middle, far) if strongest > limit_t else (near, middle)
        farthest = max(farthest, far)
    return farthest


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not value > 0.0:
            raise SetupError(f"{name} must be above zero, not {value}")
