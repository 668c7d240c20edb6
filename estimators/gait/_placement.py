"""Foot placement against the sliding average path, and step width between feet that can be related."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from estimators.errors import SetupError, ShapeError
from estimators.recording import Float
from estimators.sentences import say

RMS_FACTOR_3 = 1.0 / np.sqrt(3.0)
"""Root mean square of lateral placement within windows of three over the scatter of independent footholds."""
MIDDLE_FACTOR_3, END_FACTOR_3 = np.sqrt(2.0 / 3.0), np.sqrt(1.0 / 6.0)


@dataclass(frozen=True)
class Placement:
    """Foot placement in W windows of N consecutive footholds of one foot.

    Attributes
    ----------
    lateral_m : ndarray, shape (W, N)
        Signed distance of each foothold from the window's average path, left positive.
    length_m : ndarray, shape (W, N - 1)
        Stride lengths along the path.
    middle_m : ndarray, shape (W,)
        Lateral placement of the middle foothold (the later of two for even N).
    direction_rad : ndarray, shape (W,)
        Course of the path.
    """

    lateral_m: Float
    length_m: Float
    middle_m: Float
    direction_rad: Float


def foot_placement(position_m: Float, window: int = 3, method: Literal["tls", "ols"] = "tls") -> Placement:
    """Compare footholds with the straight line through a sliding window of them.

    Parameters
    ----------
    position_m : ndarray, shape (n, 2) or (n, 3)
        Footholds of one foot in walking order; the vertical does not count.
    window : int
        Footholds a window, 3 or more. Two strides are in a window of three.
    method : {"tls", "ols"}
        Perpendicular distances from the line of least such squares; or, for comparison with the published
        numbers only, ordinary least squares of y on x after turning the whole walk along x, which depends on the
        compass direction.

    Returns
    -------
    Placement
        Without windows when there are fewer footholds than a window needs.

    Raises
    ------
    ShapeError, SetupError
        For positions of another shape or not finite, and windows below 3.

    Notes
    -----
    Schepers, section 3.2.2, features F05 to F08; the line by total least squares because the printed form is not
    invariant to rotation (erratum E6). N counts footholds, not strides (E4).
    """
    if position_m.ndim != 2 or position_m.shape[1] not in (2, 3) or not np.isfinite(position_m).all():
        raise ShapeError(f"footholds must be finite, shape (n, 2) or (n, 3), not {position_m.shape}")
    if window < 3:
        raise SetupError(f"a window of {window} footholds; a line through it needs at least 3")
    if method not in ("tls", "ols"):
        raise SetupError(f"method {method!r}; use tls or ols")
    flat = position_m[:, :2]
    count = max(len(flat) - window + 1, 0)
    if count == 0:
        return Placement(np.empty((0, window)), np.empty((0, window - 1)), np.empty(0), np.empty(0))
    turned = 0.0
    if method == "ols":
        whole = flat[-1] - flat[0]
        turned = float(np.arctan2(whole[1], whole[0]))
        cosine, sine = np.cos(turned), np.sin(turned)
        flat = flat @ np.array([[cosine, -sine], [sine, cosine]])
    windows = np.stack([flat[i : i + window] for i in range(count)])
    centred = windows - windows.mean(axis=1, keepdims=True)
    if method == "tls":
        direction = np.linalg.svd(centred, full_matrices=False)[2][:, 0]
    else:
        slope = np.sum(centred[..., 0] * centred[..., 1], axis=1) / np.sum(centred[..., 0] ** 2, axis=1)
        direction = np.stack([np.ones_like(slope), slope], axis=1) / np.hypot(1.0, slope)[:, None]
    forward = np.sum(direction * (windows[:, -1] - windows[:, 0]), axis=1) < 0.0
    direction[forward] *= -1.0
    left = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    lateral = np.einsum("wni,wi->wn", centred, left)
    if method == "ols":
        # The published distance is along y, not perpendicular to the line.
        lateral = lateral / direction[:, :1]
    length = np.einsum("wni,wi->wn", np.diff(windows, axis=1), direction)
    course = np.arctan2(direction[:, 1], direction[:, 0]) + turned
    return Placement(lateral, length, lateral[:, window // 2], course)


@dataclass(frozen=True)
class Steps:
    """Steps between the feet: n of them, in order of landing.

    Attributes
    ----------
    is_left : ndarray of bool, shape (n,)
        The foot that lands.
    length_m, width_m : ndarray, shape (n,)
        Along and across the line from the foothold before of the landing foot to this one; width is positive when
        the foot lands on its own side.
    foothold : ndarray of int, shape (n,)
        Number of the foothold of the landing foot.
    """

    is_left: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    length_m: Float
    width_m: Float
    foothold: np.ndarray[tuple[int, ...], np.dtype[np.int64]]


def steps_between(
    left_m: Float, left_s: Float, right_m: Float, right_s: Float, right_from_left_m: Float
) -> Steps:
    """Step length and width, where the feet's worlds can be related.

    Parameters
    ----------
    left_m, right_m : ndarray, shape (n, 3) and (m, 3)
        Footholds in walking order, each in the world of its own foot.
    left_s, right_s : ndarray, shape (n,) and (m,)
        Their times.
    right_from_left_m : ndarray, shape (2,)
        Where the right foot stood at the start, seen from the left one: forward and to the left of the common
        course, so (0, -0.15) for feet side by side. It must be measured (by the therapist, or by forces): two
        inertial sensors cannot tell.

    Raises
    ------
    ShapeError
        With fewer than two footholds of a foot.

    Notes
    -----
    Both feet walk the same course: the worlds are turned onto each other by the directions of their way from the
    first to the last foothold, which leaves an error of the feet's difference in width over that way.
    """
    if min(len(left_m), len(right_m)) < 2:
        raise ShapeError(say("walk.few_footholds", least=2))
    left, right = (_along_course(feet) for feet in (left_m[:, :2], right_m[:, :2]))
    return steps_in_one_world(left, left_s, right + right_from_left_m, right_s)


def steps_in_one_world(left_m: Float, left_s: Float, right_m: Float, right_s: Float) -> Steps:
    """Step length and width of footholds that are in one world already.

    Parameters
    ----------
    left_m, right_m : ndarray, shape (n, 2 or 3) and (m, 2 or 3)
        Footholds in walking order; the vertical does not count.
    left_s, right_s : ndarray, shape (n,) and (m,)
        Their times.
    """
    left, right = left_m[:, :2], right_m[:, :2]
    entries = sorted(
        [(t, True, i) for i, t in enumerate(left_s)] + [(t, False, i) for i, t in enumerate(right_s)]
    )
    rows, sides, numbers = [], [], []
    last: dict[bool, int] = {}
    for _, is_left, i in entries:
        own, other = (left, right) if is_left else (right, left)
        if is_left in last and (not is_left) in last:
            way = own[i] - own[i - 1]
            size = max(float(np.linalg.norm(way)), 1e-9)
            between = own[i] - other[last[not is_left]]
            across = (way[0] * between[1] - way[1] * between[0]) / size
            rows.append((float(way @ between) / size, across if is_left else -across))
            sides.append(is_left)
            numbers.append(i)
        last[is_left] = i
    table = np.array(rows).reshape(-1, 2)
    return Steps(np.array(sides, dtype=np.bool_), table[:, 0], table[:, 1], np.array(numbers, dtype=np.int64))


def _along_course(positions: Float) -> Float:
    """Return positions from the first, with x along the whole way."""
    way = positions[-1] - positions[0]
    angle = np.arctan2(way[1], way[0])
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.asarray((positions - positions[0]) @ np.array([[cosine, -sine], [sine, cosine]]))
