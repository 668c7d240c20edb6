"""Shapes of one cycle of any exercise: how far each of a few coordinates is from home, over one cycle.

Written from what bodies do, without regard to how repetitions are found: stops reached with least jerk, smooth closed
paths, countermovement jumps with a ballistic flight, a hand that draws circles, a limb that swings, a quick effort
with a slow return.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float

Random = np.random.Generator
POINTS: Final = 400
"""Samples of a shape, evenly in time."""
_AWAY: Final = 0.3
"""Between its ends a cycle of one lobe stays further from home than this share of its size."""


@dataclass(frozen=True)
class Shape:
    """One cycle at its own pace.

    Attributes
    ----------
    offset : ndarray, shape (400, D)
        Distance from home, evenly in time; both ends are zero. The largest norm is 1.
    holds : tuple of float
        Shares of the cycle at which somebody may stay.
    pace : tuple of float
        Slowest and fastest this can be done, as factors.
    """

    offset: Float
    duration_s: float
    holds: tuple[float, ...]
    pace: tuple[float, float] = (0.3, 3.0)

    @property
    def dimensions(self) -> int:
        """Number of coordinates that take part."""
        return int(self.offset.shape[1])


def minimum_jerk(share: Float) -> Float:
    """Return the way done, 0 to 1, of a movement with least jerk (Flash and Hogan 1985, equation 3)."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10 - 15 * s + 6 * s**2))


def _unit(offset: Float) -> Float:
    return np.asarray(offset / np.linalg.norm(offset, axis=1).max())


def _has_one_lobe(offset: Float) -> bool:
    """Whether the movement does not come home before its end: else a part of it might pass for the whole."""
    away = np.linalg.norm(_unit(offset), axis=1)
    far = np.flatnonzero(away > _AWAY)
    return bool(len(far)) and bool((away[far[0] : far[-1] + 1] > _AWAY).all())


def _through(postures: Float, moves_s: Float, lag: Float) -> Float:
    """Move from posture to posture with least jerk; each coordinate starts late by its share of the move."""
    edges = np.concatenate([[0.0], np.cumsum(moves_s)])
    time_s = np.linspace(0.0, edges[-1], POINTS)
    offset = np.tile(postures[0], (POINTS, 1))
    for number, move_s in enumerate(moves_s):
        share = ((time_s - edges[number]) / move_s)[:, None]
        late = (share - lag) / (1.0 - lag)
        offset += minimum_jerk(late) * (postures[number + 1] - postures[number])
    return offset


def stops(random: Random) -> Shape:
    """Reach one to four postures one after the other and return, as in reaching, drinking, sitting down, squatting."""
    while True:
        dimensions, count = int(random.integers(1, 5)), int(random.integers(1, 5))
        postures = np.zeros((count + 2, dimensions))
        postures[1:-1] = random.normal(size=(count, dimensions))
        moves_s = random.uniform(0.5, 1.3, count + 1)
        offset = _through(postures, moves_s, random.uniform(0.0, 0.25, dimensions))
        if _has_one_lobe(offset):
            edges = np.cumsum(moves_s)[:-1] / moves_s.sum()
            return Shape(_unit(offset), float(moves_s.sum()), tuple(edges.tolist()))


def spline(random: Random) -> Shape:
    """Follow a smooth closed path through random postures, unevenly fast."""
    while True:
        dimensions, knots = int(random.integers(1, 6)), int(random.integers(4, 8))
        postures = random.normal(size=(knots + 1, dimensions))
        postures[0] = postures[-1] = 0.0
        path = CubicSpline(np.linspace(0.0, 1.0, knots + 1), postures, bc_type="periodic")
        rates = np.exp(random.normal(0.0, 0.3, 6))
        warp = np.interp(
            np.linspace(0, 1, POINTS), np.linspace(0, 1, 7), np.concatenate([[0], np.cumsum(rates)])
        )
        share = warp / warp[-1]
        offset = np.asarray(path(0.6 * share + 0.4 * minimum_jerk(share)))
        offset -= np.linspace(0.0, 1.0, POINTS)[:, None] * (offset[-1] - offset[0])
        if _has_one_lobe(offset):
            return Shape(_unit(offset), float(random.uniform(1.2, 3.0)), (float(random.uniform(0.3, 0.7)),))


def jump(random: Random) -> Shape:
    """Jump from a crouch: bend, stretch, fly, bend again on landing, stand up.

    Knee, hip and the pelvis's height, or the knee alone: the knee bends twice in one jump.
    """
    height_m = float(random.uniform(0.08, 0.35))
    flight_s = 2.0 * np.sqrt(2.0 * height_m / GRAVITY_MPS2)
    landing = float(random.uniform(0.35, 0.8))
    moves_s = np.array([random.uniform(0.5, 0.9), 0.28, flight_s, 0.25, random.uniform(0.5, 0.8)])
    bent = np.array([0.0, 1.0, 0.0, 0.0, landing, 0.0])
    lean = np.array([0.0, float(random.uniform(0.4, 0.9)), 0.0, 0.0, landing * 0.5, 0.0])
    joints = _through(np.stack([bent, lean], axis=1), moves_s, np.array([0.0, 0.05]))
    edges = np.concatenate([[0.0], np.cumsum(moves_s)])
    time_s = np.linspace(0.0, edges[-1], POINTS)
    flown = np.clip((time_s - edges[2]) / flight_s, 0.0, 1.0)
    up = -0.35 * joints[:, 0] + height_m / 0.35 * 4.0 * flown * (1.0 - flown)
    columns = [joints[:, :1], joints, np.column_stack([joints, up]), up[:, None]]
    offset = columns[int(random.integers(0, 4))]
    return Shape(_unit(offset), float(moves_s.sum()), (), (0.8, 1.25))


def orbit(random: Random) -> Shape:
    """Draw an ellipse or a figure of eight with the hand, nearly evenly fast."""
    turn = 2.0 * np.pi * np.linspace(0.0, 1.0, POINTS) + random.uniform(0.0, 2.0 * np.pi)
    breadth = float(random.uniform(0.3, 1.0))
    is_eight = random.random() < 0.4
    flat = np.column_stack([np.cos(turn), breadth * np.sin((2.0 if is_eight else 1.0) * turn)])
    axes, _ = np.linalg.qr(random.normal(size=(3, 3)))
    offset = flat @ axes[:2]
    return Shape(
        _unit(offset - offset[0]), float(random.uniform(1.0, 2.5)), (float(random.uniform(0.3, 0.7)),)
    )


def swing(random: Random) -> Shape:
    """Swing a limb: near sines of one pace in several coordinates, each with its own lag and size."""
    dimensions = int(random.integers(1, 4))
    turn = 2.0 * np.pi * np.linspace(0.0, 1.0, POINTS)[:, None]
    lag = np.concatenate([[0.0], random.uniform(-1.0, 1.0, dimensions - 1)])
    offset = random.uniform(0.4, 1.0, dimensions) * np.sin(turn + lag + random.choice([0.0, np.pi / 2]))
    offset = offset + random.uniform(0.0, 0.15, dimensions) * np.sin(2.0 * turn + 2.0 * lag)
    return Shape(_unit(offset - offset[0]), float(random.uniform(1.0, 2.2)), ())


def effort(random: Random) -> Shape:
    """Push out quickly and return slowly, or the other way about, joints one after the other."""
    dimensions = int(random.integers(1, 4))
    postures = np.zeros((3, dimensions))
    postures[1] = random.uniform(0.3, 1.0, dimensions) * random.choice([-1.0, 1.0], dimensions)
    quick = float(random.uniform(0.25, 0.5))
    slow = quick * float(random.uniform(2.0, 5.0))
    moves_s = np.array([quick, slow] if random.random() < 0.5 else [slow, quick])
    offset = _through(postures, moves_s, random.uniform(0.0, 0.4, dimensions))
    return Shape(_unit(offset), float(moves_s.sum()), (float(moves_s[0] / moves_s.sum()),))


SHAPES: Final[dict[str, Callable[[Random], Shape]]] = {
    "stops": stops,
    "spline": spline,
    "jump": jump,
    "orbit": orbit,
    "swing": swing,
    "effort": effort,
}
