"""Six degrees of freedom from one burst of the coils of a source (Roetenberg 2006, chapter 5, with exact coils)."""

from dataclasses import dataclass
from enum import IntFlag

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.errors import ShapeError
from estimators.magnetic._closed_form import ClosedForm, closed_form
from estimators.magnetic._coil import Source
from estimators.magnetic._refine_kernel import refine
from estimators.recording import Float


class TrackerFlag(IntFlag):
    """Why a fix is less than sound; zero means sound."""

    SOUND = 0
    NO_SOLUTION = 1
    """The pulses fit no pose at all; position and orientation are NaN."""
    AMBIGUOUS = 2
    """Another pose fits about as well: give a mounting prior or the last position."""
    OUT_OF_RANGE = 4
    """Signal below four times the noise."""
    DISTURBED = 8
    """The pulses do not fit the coils: iron, a moving sensor, or a wrong coil description."""
    WRONG_ORDER = 16
    """Coils, sensor axes or a polarity are exchanged: the field matrix has a negative determinant."""
    SATURATED = 32
    """A sample of the burst was at full scale."""
    TOO_NEAR = 64
    """Nearer to the source than its coils allow: are source and sensor swapped?"""


@dataclass(frozen=True)
class TrackerLimits:
    """When a fix is flagged.

    `chi_square`: of the residuals, 3 degrees of freedom for one burst; the default is the 99.9 % point.
    `gain_sigma`: share of the pulse that the coil description may be wrong by. `ambiguous_chi_square` and
    `ambiguous_distance_m`: another minimum that far away must be worse by this much. `prior_angle_deg`: half angle of
    the cone that a mounting prior allows.
    """

    chi_square: float = 16.27
    signal_to_noise: float = 4.0
    gain_sigma: float = 0.002
    ambiguous_chi_square: float = 9.0
    ambiguous_distance_m: float = 0.1
    prior_angle_deg: float = 60.0
    nearest_m: float = 0.08


@dataclass(frozen=True)
class Fix:
    """Pose of the sensor in the source frame.

    Attributes
    ----------
    position_m : ndarray, shape (3,)
    q_source_sensor : ndarray, shape (4,)
    covariance : ndarray, shape (6, 6)
        Position in source axes, orientation error in sensor axes.
    chi_square : float
        Of the residuals; degrees of freedom are values less six.
    signal_to_noise : float
        Root mean square pulse over its noise.
    """

    position_m: Float
    q_source_sensor: Float
    covariance: Float
    chi_square: float
    signal_to_noise: float
    flags: TrackerFlag

    @property
    def usable(self) -> bool:
        """Whether a filter may start from it."""
        return not self.flags & ~(TrackerFlag.OUT_OF_RANGE)


def locate(
    source: Source,
    coil: ArrayLike,
    current_a: ArrayLike,
    pulses_t: ArrayLike,
    sigma_t: float,
    direction: ArrayLike | None = None,
    last_position_m: ArrayLike | None = None,
    moved_m: ArrayLike | None = None,
    q_turned: ArrayLike | None = None,
    saturated: bool = False,
    limits: TrackerLimits | None = None,
    start: tuple[ArrayLike, ArrayLike] | None = None,
) -> Fix:
    """Find the pose that explains the pulses of at least three coils.

    Parameters
    ----------
    coil : array_like of int, shape (N,)
        N of three or more pulses; the first pulses of coils 0, 1 and 2 seed the search.
    current_a : array_like, shape (N,) or scalar
    pulses_t : array_like, shape (N, 3)
        Pulse values in sensor axes.
    sigma_t : float
        Standard deviation of a pulse value.
    direction : array_like, shape (3,), optional
        Mounting prior in the source frame: the sensor is within a cone about it.
    last_position_m : array_like, shape (3,), optional
        Continuity: of two mirror images the one nearer to this.
    moved_m : array_like, shape (N, 3), optional
        How far the sensor had moved in the source frame at each pulse, against the pose that is asked for.
    q_turned : array_like, shape (N, 4), optional
        How it had turned (in its own axes). With both, motion within the burst is compensated.
    saturated : bool
        A sample was at full scale.
    start : (array_like, array_like), optional
        Position and `q_source_sensor` that are known roughly: where they lead to pulses that fit, nothing else is
        searched.
    """
    bounds = limits or TrackerLimits()
    numbers = np.ascontiguousarray(coil, dtype=np.int64)
    pulses = np.ascontiguousarray(pulses_t, dtype=np.float64)
    if pulses.shape != (len(numbers), 3) or len(numbers) < 3:
        raise ShapeError("a fix needs three pulses or more of shape (N, 3) with a coil each")
    currents = np.array(np.broadcast_to(current_a, numbers.shape), dtype=np.float64)
    offset = np.zeros_like(pulses) if moved_m is None else np.array(moved_m, dtype=np.float64)
    turn = rotation.identity((len(numbers),)) if q_turned is None else np.array(q_turned, dtype=np.float64)
    noise = np.sqrt(sigma_t**2 + bounds.gain_sigma**2 * np.sum(pulses**2, axis=1))
    ratio = float(np.sqrt(np.mean(pulses**2)) / sigma_t)
    flags = TrackerFlag.SATURATED if saturated else TrackerFlag.SOUND
    if ratio < bounds.signal_to_noise:
        flags |= TrackerFlag.OUT_OF_RANGE
    if not np.isfinite(pulses).all():
        return _nothing(flags, ratio)
    seed = _seed(source, numbers, currents, turn, pulses)
    if not seed.strength > 0.0 or not np.isfinite(seed.position_m).all():
        return _nothing(flags | TrackerFlag.WRONG_ORDER, ratio)
    if seed.determinant < 0.0:
        flags |= TrackerFlag.WRONG_ORDER
    solutions: list[_Solution] = []
    if start is not None:
        pose = np.concatenate([np.asarray(part, dtype=np.float64) for part in start])
        solutions = _near(source, numbers, currents, offset, turn, pulses, noise, pose, bounds)
    solutions = solutions or _search(source, numbers, currents, offset, turn, pulses, noise, seed, bounds)
    if not solutions:
        return _nothing(flags, ratio)
    best, ambiguous = _choose(solutions, direction, last_position_m, bounds)
    if ambiguous:
        flags |= TrackerFlag.AMBIGUOUS
    cost, pose, information = best
    if cost > most_chi_square(bounds, len(numbers)):
        flags |= TrackerFlag.DISTURBED
    if np.linalg.norm(pose[:3]) < bounds.nearest_m * 1.2:
        flags |= TrackerFlag.TOO_NEAR
    return Fix(
        pose[:3],
        rotation.positive(pose[3:]),
        np.asarray(np.linalg.inv(information), dtype=np.float64),
        cost,
        ratio,
        flags,
    )


_Solution = tuple[float, Float, Float]


def most_chi_square(bounds: TrackerLimits, pulses: int) -> float:
    """Return the chi-square above which pulses do not fit."""
    freedom = 3 * pulses - 6
    # 99.9 % point of chi-square grows about as freedom + 3.3 sqrt(2 freedom) from the given one at 3
    return float(bounds.chi_square + (freedom - 3) + 4.4 * (np.sqrt(freedom) - np.sqrt(3.0)))


def _near(
    source: Source,
    coil: NDArray[np.int64],
    current: Float,
    offset: Float,
    turn: Float,
    pulses: Float,
    noise: Float,
    pose: Float,
    bounds: TrackerLimits,
) -> list[_Solution]:
    """Refine from one pose; nothing if that does not fit."""
    information = np.empty((6, 6))
    if np.linalg.norm(pose[:3]) < bounds.nearest_m:
        return []
    cost = float(
        refine(
            source.loops,
            coil,
            current,
            offset,
            turn,
            pulses,
            1.0 / noise**2,
            bounds.nearest_m,
            pose,
            information,
        )
    )
    fits = cost <= most_chi_square(bounds, len(coil)) and np.linalg.cond(information) < 1e14
    return [(cost, pose, information)] if fits else []


def _search(
    source: Source,
    coil: NDArray[np.int64],
    current: Float,
    offset: Float,
    turn: Float,
    pulses: Float,
    noise: Float,
    seed: ClosedForm,
    bounds: TrackerLimits,
) -> list[_Solution]:
    """Refine from both mirror images and several distances."""
    position, q = seed.position_m, seed.q_source_sensor
    loops, weight = source.loops, 1.0 / noise**2
    found: list[_Solution] = []
    concentric = not offset.any() and all(bool(np.linalg.norm(coil.centre_m) < 1e-6) for coil in source.coils)
    for sign in (1.0, -1.0):
        if concentric and sign < 0.0 and found:
            # The mirror image fits exactly as well, with the same orientation.
            found += [
                (cost, np.concatenate([-pose[:3], pose[3:]]), info * _MIRROR) for cost, pose, info in found
            ]
            break
        for trial in _starts(position, concentric):
            start = sign * trial
            if np.linalg.norm(start) < bounds.nearest_m:
                start = start / np.linalg.norm(start) * bounds.nearest_m * 1.3
            for attitude in _attitudes(source, coil, current, start + offset, pulses, q, concentric):
                pose = np.concatenate([start, attitude])
                information = np.empty((6, 6))
                cost = refine(
                    loops, coil, current, offset, turn, pulses, weight, bounds.nearest_m, pose, information
                )
                if np.isfinite(cost) and np.linalg.cond(information) < 1e14:
                    found.append((float(cost), pose, information))
            if found and min(cost for cost, _, _ in found) < bounds.chi_square and concentric:
                break
    return found


def _starts(position: Float, concentric: bool) -> list[Float]:
    """Where to begin: several distances; near to coils that are apart also several directions."""
    found = [factor * position for factor in (1.0, 0.7, 1.3)]
    if concentric or np.linalg.norm(position) > _NEAR_M:
        return found
    across = np.cross(position, np.eye(3)[np.argmin(np.abs(position))])
    across *= np.linalg.norm(position) / np.linalg.norm(across)
    other = np.cross(position, across) / np.linalg.norm(position)
    tilted = [position + tilt for tilt in (across, -across, other, -other)]
    return found + [trial * np.linalg.norm(position) / np.linalg.norm(trial) for trial in tilted]


_NEAR_M = 0.45
"""Below this the closed form for one common centre may lead into a local minimum (method page 2.7)."""
_MIRROR = np.outer([-1.0] * 3 + [1.0] * 3, [-1.0] * 3 + [1.0] * 3)


def _attitudes(
    source: Source,
    coil: NDArray[np.int64],
    current: Float,
    points: Float,
    pulses: Float,
    q: Float,
    concentric: bool,
) -> list[Float]:
    """Orientation of the closed form; for coils that are apart also the one that fits the exact field here."""
    if concentric:
        return [q]
    field = source.field(coil, current, points)
    w, _, zt = np.linalg.svd(field.T @ pulses)
    proper = w @ np.diag([1.0, 1.0, np.linalg.det(w @ zt)]) @ zt
    return [rotation.from_matrix(proper)]


def _choose(
    solutions: list[_Solution],
    direction: ArrayLike | None,
    last: ArrayLike | None,
    bounds: TrackerLimits,
) -> tuple[_Solution, bool]:
    allowed = solutions
    if direction is not None:
        axis = np.asarray(direction, dtype=np.float64)
        axis = axis / np.linalg.norm(axis)
        least = np.cos(np.radians(bounds.prior_angle_deg))
        inside = [s for s in solutions if s[1][:3] @ axis > least * np.linalg.norm(s[1][:3])]
        # None inside: the half space at least
        allowed = inside or [s for s in solutions if s[1][:3] @ axis > 0.0] or solutions
    best = min(allowed, key=lambda s: s[0])
    rivals = [
        s
        for s in allowed
        if np.linalg.norm(s[1][:3] - best[1][:3]) > bounds.ambiguous_distance_m
        and s[0] - best[0] < bounds.ambiguous_chi_square
    ]
    if not rivals:
        return best, False
    if last is not None:
        place = np.asarray(last, dtype=np.float64)
        return min([best, *rivals], key=lambda s: float(np.linalg.norm(s[1][:3] - place))), False
    return best, True


def _seed(
    source: Source, coil: NDArray[np.int64], current_a: Float, q_turned: Float, pulses_t: Float
) -> ClosedForm:
    """Return the closed form of the first pulses of the first three coils."""
    firsts = [int(np.flatnonzero(coil == c)[0]) if (coil == c).any() else -1 for c in range(3)]
    if min(firsts) < 0:
        raise ShapeError("a fix needs a pulse of each of the first three coils")
    aligned = rotation.rotate(q_turned[firsts], pulses_t[firsts])
    return closed_form(source, aligned.T, current_a[firsts])


def _nothing(flags: TrackerFlag, ratio: float) -> Fix:
    return Fix(
        np.full(3, np.nan),
        rotation.identity(),
        np.full((6, 6), np.nan),
        np.inf,
        ratio,
        flags | TrackerFlag.NO_SOLUTION,
    )
