"""Both feet in one world on a course that turns: from the path that they share."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.errors import ShapeError
from estimators.recording import Float
from estimators.sentences import say

_KNOT_S: Final = 20.0
"""The drift of one foot's heading against the other's is linear between knots so far apart."""
_DRIFT_RADPS: Final = 3.5e-4
"""One sigma of that drift: 0.02 deg/s, what is left of two gyroscopes' offsets."""
_WIDTH_SD_M, _TURNING_SD_M, _LENGTH_SD_M = 0.04, 0.12, 0.06
"""Scatter of a step across the path, in a turn, and along it."""
_TURNING_RAD: Final = 0.17
_BESIDE_SD_M: Final = 0.02
_RELATION_SD_M: Final = 0.015
"""What the mean distance of the feet was off on simulated walks with turns, beyond the covariance of the fit."""
_LEAST_FOOTHOLDS: Final = 4
_LEAST_WAY_M: Final = 3.0


@dataclass(frozen=True)
class CommonCourse:
    """The right foot's world against the left one's; K knots.

    Attributes
    ----------
    knot_s : ndarray, shape (K,)
    turn_rad : ndarray, shape (K,)
        By which steps of the right foot are turned into the left foot's world, linear between knots.
    right_m : ndarray, shape (m, 2)
        Footholds of the right foot in the left one's world.
    step_sigma_m : float
        One sigma of where the feet are against each other, mean over the walk: what the relation itself does not know.
    """

    knot_s: Float
    turn_rad: Float
    right_m: Float
    step_sigma_m: float

    def turn_at(self, time_s: Float) -> Float:
        """Return the turn at some moments, rad."""
        return np.interp(time_s, self.knot_s, self.turn_rad)


def relate_by_course(
    left_m: Float,
    left_s: Float,
    right_m: Float,
    right_s: Float,
    apart_m: float,
    *,
    end_apart_m: float | None = None,
    apart_sigma_m: float = 0.01,
) -> CommonCourse:
    """Relate feet that walk one course, straight or not.

    Both start side by side. From there on each foot goes its own way, exact from step to step, in a heading that
    drifts slowly; what is sought is the turn between the two worlds for which the feet stay beside each other: steps
    scatter across and along the path that both share, and neither widens nor runs ahead over the walk.

    Parameters
    ----------
    left_m, right_m : ndarray, shape (n, 2 or 3) and (m, 2 or 3)
        Footholds in walking order, each in the world of its own foot.
    left_s, right_s : ndarray, shape (n,) and (m,)
    apart_m : float
        Distance of the feet at the start; measured, or given by forces.
    end_apart_m : float, optional
        The same at the end, where the feet are side by side again.

    Raises
    ------
    ShapeError
        When there are fewer than four footholds of a foot, or less than three metres of way.

    Notes
    -----
    The shared path is the sliding average of both feet's footholds (Schepers 2009, section 3.2.2, features F05 and
    F06, for two feet). Least squares over the turn at the knots, the mean step width, and the mean length of left and
    right steps: an uneven walk stays uneven.
    """
    left, right = left_m[:, :2], right_m[:, :2]
    if min(len(left), len(right)) < _LEAST_FOOTHOLDS:
        raise ShapeError(say("walk.few_footholds", least=_LEAST_FOOTHOLDS))
    if min(_way(left), _way(right)) < _LEAST_WAY_M:
        raise ShapeError(say("walk.short_way", least_m=_LEAST_WAY_M))
    problem = _Problem(left, left_s, right, right_s, apart_m, end_apart_m)
    found = scipy.optimize.least_squares(
        problem.residuals, problem.start(), x_scale=problem.scale(), method="trf"
    )
    placed = problem.placed(found.x)
    # How far the steps may be off together: the relation's own covariance, carried to the mean distance.
    slopes: Float = np.asarray(found.jac, dtype=np.float64)
    inverse = np.linalg.pinv(slopes.T @ slopes)
    knots = len(problem.knot_s)
    slope = np.array([problem.mean_change(found.x, k) for k in range(knots)])
    own = float(np.sqrt(max(slope @ inverse[:knots, :knots] @ slope, 0.0)))
    return CommonCourse(
        problem.knot_s, found.x[:knots], placed, float(np.sqrt(own**2 + apart_sigma_m**2 + _RELATION_SD_M**2))
    )


class _Problem:
    """Steps of two feet and what is asked of them."""

    def __init__(
        self,
        left: Float,
        left_s: Float,
        right: Float,
        right_s: Float,
        apart_m: float,
        end_apart_m: float | None,
    ) -> None:
        self.left, self.right, self.right_s = left, right, right_s
        self.apart_m, self.end_apart_m = apart_m, end_apart_m
        begin, end = min(left_s[0], right_s[0]), max(left_s[-1], right_s[-1])
        count = 2 + int((end - begin) / _KNOT_S)
        self.knot_s = np.linspace(begin, end, count)
        middle_s = 0.5 * (right_s[1:] + right_s[:-1])
        # Weights of the knots at every step of the right foot.
        self.weights = np.stack([np.interp(middle_s, self.knot_s, row) for row in np.eye(count)], axis=1)
        times = np.concatenate([left_s, right_s])
        self.order = np.argsort(times, kind="stable")
        self.is_left = (np.arange(len(times)) < len(left_s))[self.order]
        # A step is a landing after one of the other foot.
        self.lands = np.flatnonzero(self.is_left[1:] != self.is_left[:-1]) + 1
        self.lands = self.lands[(self.lands >= 2) & (self.lands < len(times) - 1)]

    def start(self) -> Float:
        """Return a first guess: the first metres of both feet go one way."""
        turn = _first_course(self.left) - _first_course(self.right)
        knots = np.full(len(self.knot_s), (turn + np.pi) % (2.0 * np.pi) - np.pi)
        size = 0.5 * np.median(np.linalg.norm(np.diff(self.left, axis=0), axis=1))
        return np.concatenate([knots, [self.apart_m, size, size]])

    def scale(self) -> Float:
        """Return the size of what is sought."""
        return np.concatenate([np.full(len(self.knot_s), 0.02), [0.05, 0.1, 0.1]])

    def placed(self, x: Float) -> Float:
        """Return the right foot's footholds in the left foot's world."""
        turn = self.weights @ x[: len(self.knot_s)]
        steps = np.diff(self.right, axis=0)
        cosine, sine = np.cos(turn), np.sin(turn)
        turned = np.column_stack(
            [cosine * steps[:, 0] - sine * steps[:, 1], sine * steps[:, 0] + cosine * steps[:, 1]]
        )
        course = _first_course(self.left)
        first = self.left[0] + self.apart_m * np.array([np.sin(course), -np.cos(course)])
        return np.concatenate([first[None], first + np.cumsum(turned, axis=0)])

    def residuals(self, x: Float) -> Float:
        """Return what is asked of the steps, each in its own standard deviation."""
        knots = len(self.knot_s)
        width, length_left, length_right = x[knots:]
        across, along, turned = self.steps(x)
        is_left = self.is_left[self.lands]
        spread = np.where(np.abs(turned) > _TURNING_RAD, _TURNING_SD_M, _WIDTH_SD_M)
        drift = np.diff(x[:knots]) / (_DRIFT_RADPS * np.diff(self.knot_s))
        parts = [
            (across - width) / spread,
            (along - np.where(is_left, length_left, length_right))
            / np.where(spread > _WIDTH_SD_M, 2.0, 1.0)
            / _LENGTH_SD_M,
            drift,
        ]
        if self.end_apart_m is not None:
            between = self.left[-1] - self.placed(x)[-1]
            parts.append(np.array([np.linalg.norm(between) - self.end_apart_m]) / _BESIDE_SD_M)
        return np.concatenate(parts)

    def steps(self, x: Float) -> tuple[Float, Float, Float]:
        """Return width and length of every step against the shared path, and by how much the path turns there."""
        points = np.concatenate([self.left, self.placed(x)])[self.order]
        middle = 0.5 * (points[1:] + points[:-1])
        k = self.lands
        # Path before and after the step: from the middle of two footholds to that of the next two but one.
        before, after = middle[k - 1] - middle[k - 2], middle[k] - middle[k - 1]
        way = before + after
        size = np.maximum(np.linalg.norm(way, axis=1), 1e-6)
        between = points[k] - points[k - 1]
        across = (way[:, 0] * between[:, 1] - way[:, 1] * between[:, 0]) / size
        along = np.sum(way * between, axis=1) / size
        turned = np.arctan2(
            before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], np.sum(before * after, axis=1)
        )
        return np.where(self.is_left[k], across, -across), along, turned

    def mean_change(self, x: Float, knot: int) -> float:
        """Return how the mean step width changes with the turn at a knot."""
        small = 1e-4
        moved = x.copy()
        moved[knot] += small
        return float((self.steps(moved)[0].mean() - self.steps(x)[0].mean()) / small)


def _first_course(points: Float) -> float:
    """Return where the first metres go."""
    way = np.linalg.norm(points - points[0], axis=1)
    far = np.flatnonzero(way > 1.5)
    last = int(far[0]) if len(far) else len(points) - 1
    dx, dy = points[last] - points[0]
    return float(np.arctan2(dy, dx))


def _way(points: Float) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def average_path(
    left_m: Float, left_s: Float, right_m: Float, right_s: Float, time_s: Float
) -> tuple[Float, Float]:
    """Return the path that both feet share and its course at some moments.

    Parameters
    ----------
    left_m, right_m : ndarray, shape (n, 2 or 3) and (m, 2 or 3)
        Footholds in one world.
    left_s, right_s : ndarray, shape (n,) and (m,)
    time_s : ndarray, shape (N,)

    Returns
    -------
    path_m : ndarray, shape (N, 2)
        Middle between the feet, each taken to go evenly from foothold to foothold.
    course_rad : ndarray, shape (N,)
        Of that path over the stride around each moment, unwrapped; held where nobody walks.
    """

    def at(moments: Float) -> NDArray[np.float64]:
        feet = [
            np.column_stack([np.interp(moments, times, points[:, axis]) for axis in range(2)])
            for points, times in ((left_m, left_s), (right_m, right_s))
        ]
        return np.asarray(0.5 * (feet[0] + feet[1]))

    half = 0.5 * float(np.median(np.diff(np.concatenate([left_s])))) if len(left_s) > 1 else 0.5
    way = at(time_s + half) - at(time_s - half)
    moves = np.linalg.norm(way, axis=1) > 0.1
    if not moves.any():
        return at(time_s), np.zeros(len(time_s))
    index = np.arange(len(time_s))
    course = np.interp(index, index[moves], np.unwrap(np.arctan2(way[moves, 1], way[moves, 0])))
    return at(time_s), course
