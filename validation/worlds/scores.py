"""Scores of an orientation method in one world, beside those of the `vqf` package."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2
from vqf import VQF, offlineVQF

from estimators import orientation, rotation
from estimators.errors import EstimationError
from estimators.orientation import OrientationFlag, OrientationResult
from estimators.recording import Float, ImuChunk
from validation.worlds.world import World

_SETTLED_S: Final = 10.0
_REGION: Final = float(chi2.ppf(0.95, 3))
_LOST_DEG: Final = 180.0
_TRUSTWORTHY_RAD: Final = float(np.radians(10.0))


@dataclass(frozen=True)
class Score:
    """One run of one method.

    Attributes
    ----------
    error_deg, package_deg : float
        Root mean square of the total error, ours and of the package, from the tenth second on, where anything is
        measured; 180 for a run of ours that ended in an error.
    inside_percent : float
        Of the ticks where an orientation is given, so many with the error inside the stated 95 % region of three axes.
    sigma_deg : float, or None
        Median over these ticks of the root sum of squares of the three sigmas.
    untrusted_percent : float, or None
        Of the ticks with the heading within 10 degrees, so many with HEADING_NOT_TRUSTED; None without magnetometer, or
        where the heading is never so near.
    has_failed : bool
        The run ended in an error.
    """

    error_deg: float
    package_deg: float
    inside_percent: float
    sigma_deg: float | None
    untrusted_percent: float | None
    has_failed: bool = False


def is_beyond(score: Score) -> bool:
    """Say whether a run is worse than 1.5 times the package plus 0.5 degrees, or ended in an error."""
    return score.error_deg > 1.5 * score.package_deg + 0.5 or score.has_failed


def _online(chunk: ImuChunk, parameters: Mapping[str, float] | None = None) -> OrientationResult:
    return orientation.create("telemotion", chunk.sensor_count, chunk.time_step_s, parameters).update(chunk)


def _offline(chunk: ImuChunk, parameters: Mapping[str, float] | None = None) -> OrientationResult:
    return orientation.smooth("telemotion_smoother", chunk, parameters).orientation


def _package_online(gyroscope: Float, force: Float, field: Float | None, step_s: float) -> Float:
    found = VQF(step_s).updateBatch(gyroscope, force, field)
    return np.asarray(found["quat6D" if field is None else "quat9D"])


def _package_offline(gyroscope: Float, force: Float, field: Float | None, step_s: float) -> Float:
    found = offlineVQF(gyroscope, force, field, step_s)
    return np.asarray(found["quat6D" if field is None else "quat9D"])


_Package = Callable[[Float, Float, Float | None, float], Float]
METHODS: Final[dict[str, tuple[Callable[..., OrientationResult], _Package]]] = {
    "online": (_online, _package_online),
    "off-line": (_offline, _package_offline),
}
"""Ours and the method of the package that it is held against."""


def package_error_deg(world: World, method: str) -> float:
    """Run the package that a method of `METHODS` is held against; return its root mean square error."""
    ticks = _scored_ticks(world)
    return _size_deg(_errors(world, _of_package(world.chunk, METHODS[method][1]), ticks)[ticks])


def scored(
    world: World,
    method: str,
    parameters: Mapping[str, float] | None = None,
    package_deg: float | None = None,
) -> Score:
    """Run a method in a world, and the package beside it.

    Parameters
    ----------
    method : str
        Of `METHODS`.
    parameters : mapping, optional
        Of the method, where they differ from its defaults.
    package_deg : float, optional
        Result of `package_error_deg`; the package runs where it is not given.
    """
    ours, _ = METHODS[method]
    ticks = _scored_ticks(world)
    if package_deg is None:
        package_deg = package_error_deg(world, method)
    try:
        found = ours(world.chunk, parameters) if parameters else ours(world.chunk)
    except (EstimationError, ArithmeticError, ValueError):
        return Score(_LOST_DEG, package_deg, 0.0, None, None, has_failed=True)
    if found.sigma_rad is None or not np.isfinite(found.q_earth_sensor[0, ticks]).all():
        return Score(_LOST_DEG, package_deg, 0.0, None, None, has_failed=True)
    errors, sigma = _errors(world, found.q_earth_sensor[0], ticks), found.sigma_rad[0]
    given = ticks & ((found.flags[0] & int(OrientationFlag.INVALID)) == 0)
    inside = ((errors[given] / sigma[given]) ** 2).sum(axis=1) < _REGION
    return Score(
        _size_deg(errors[ticks]),
        package_deg,
        100.0 * float(inside.mean()) if given.any() else 0.0,
        float(np.degrees(np.median(np.linalg.norm(sigma[given], axis=1)))) if given.any() else None,
        _untrusted(found.flags[0], errors, given) if world.conditions.axes == 9 else None,
    )


def _scored_ticks(world: World) -> NDArray[np.bool_]:
    settled = np.arange(world.chunk.tick_count) * world.chunk.time_step_s >= _SETTLED_S
    return np.asarray(world.is_measured & settled)


def _errors(world: World, q: Float, ticks: NDArray[np.bool_]) -> Float:
    """Return rotation vectors of the error in earth axes, shape (K, 3).

    Without magnetometer the heading is counted from the truth at the first tick of `ticks`: what remains is the drift.
    """
    apart = rotation.multiply(q, rotation.conjugate(world.q_earth_sensor))
    if world.conditions.axes == 6:
        first = apart[np.argmax(ticks)]
        apart = rotation.multiply(rotation.about_z(-2.0 * np.arctan2(first[3], first[0])), apart)
    return rotation.log(apart)


def _size_deg(errors: Float) -> float:
    return float(np.degrees(np.sqrt((errors**2).sum(axis=1).mean())))


def _untrusted(flags: NDArray[np.uint8], errors: Float, given: NDArray[np.bool_]) -> float | None:
    turn = rotation.exp(errors)
    heading = rotation.log(rotation.about_z(2.0 * np.arctan2(turn[:, 3], turn[:, 0])))[:, 2]
    near = given & (np.abs(heading) < _TRUSTWORTHY_RAD)
    if not near.any():
        return None
    return 100.0 * float(np.mean((flags[near] & int(OrientationFlag.HEADING_NOT_TRUSTED)) != 0))


def _of_package(chunk: ImuChunk, package: _Package) -> Float:
    """Run the package on readings without holes: lost stretches are bridged by straight lines."""
    field = None if chunk.magnetometer_t is None else _whole(1e6 * chunk.magnetometer_t[0])
    return package(
        _whole(chunk.gyroscope_radps[0]), _whole(chunk.accelerometer_mps2[0]), field, chunk.time_step_s
    )


def _whole(values: Float) -> Float:
    known, ticks = np.isfinite(values).all(axis=1), np.arange(len(values))
    filled = [np.interp(ticks, ticks[known], values[known, axis]) for axis in range(values.shape[1])]
    return np.ascontiguousarray(np.column_stack(filled))
