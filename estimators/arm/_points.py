"""Joint centres with covariance: what orientation errors and unknown segment lengths do to a position.

A point hangs from the pelvis (or from its shoulder) by a chain of segment vectors, each carried by one worn
sensor. With a small orientation error d of that sensor (rotation vector in the room, true = Exp(d) estimated,
covariance S) and r the sum of the vectors that it carries, the point errs by d x r + 1/2 d x (d x r), and by
u dL for every length L along u. Summed over independent sensors and lengths::

    covariance = sum [r]x S [r]x^T + E[second order] + sum sigma_L^2 u u^T

The second-order part, by the moments of a Gaussian, is what a large heading error takes off the reach; the
figures are mean squares about the estimated position. Errors that two sensors share are taken as independent.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.arm._model import model_lengths
from estimators.arm._names import MODEL_POINTS
from estimators.body import BodyDimensions
from estimators.conventions import SIDES, Placement
from estimators.errors import SetupError, ShapeError

Float = NDArray[np.float64]
Origin = Literal["room", "shoulder"]

_TRUNK, _HALF_WIDTH, _HEAD, _UPPER_ARM, _FOREARM, _HAND = range(1, 7)
_UPRIGHT: Final = -1


@dataclass(frozen=True)
class LengthSigma:
    """One-sigma of the lengths of `BodyDimensions`, metres.

    The defaults are the house's for a tape measure between palpated joints; scaled from stature alone the
    spread between people is two to three times that.
    """

    trunk_m: float = 0.02
    shoulder_width_m: float = 0.02
    upper_arm_m: float = 0.01
    forearm_m: float = 0.01
    hand_m: float = 0.01
    head_m: float = 0.02

    def __post_init__(self) -> None:
        values = (
            self.trunk_m, self.shoulder_width_m, self.upper_arm_m,
            self.forearm_m, self.hand_m, self.head_m,
        )  # fmt: skip
        if not all(0.0 <= value <= 0.5 for value in values):
            raise SetupError(f"{self}: a sigma of a length is metres, 0 to 0.5")

    @property
    def by_link(self) -> Float:
        """Sigma in the order of `model_lengths`; half the width, and nothing for the height of the hips."""
        return np.array(
            [
                0.0, self.trunk_m, 0.5 * self.shoulder_width_m, self.head_m,
                self.upper_arm_m, self.forearm_m, self.hand_m,
            ]
        )  # fmt: skip


class Link(NamedTuple):
    """One vector of a chain: column of the carrying sensor (-1 upright), direction in its axes, length number."""

    carrier: int
    direction: tuple[float, float, float]
    length: int


def point_chain(point: str, placements: Sequence[str], origin: Origin = "room") -> tuple[Link, ...]:
    """Return the links from the origin to a point, as `ArmModel` hangs them.

    Parameters
    ----------
    point : str
        A name of `MODEL_POINTS`.
    placements : sequence of str
        Worn sensors (or segments of stored frames), the columns.
    origin : {"room", "shoulder"}
        From the middle of the hips, or from the shoulder centre of the point's own side, as in the thesis.

    Raises
    ------
    SetupError
        If there is no such point, or the sensors that it needs are not worn.
    """
    if point not in MODEL_POINTS:
        raise SetupError(f"no point {point!r}; known are {', '.join(MODEL_POINTS)}")
    worn = tuple(placements)

    def carrier(*choices: str) -> int:
        return next((worn.index(name) for name in choices if name in worn), _UPRIGHT)

    joint, _, side = point.rpartition("_")
    trunk = Link(carrier("sternum"), (0.0, 0.0, 1.0), _TRUNK)
    if side not in SIDES:
        head = Link(carrier("head", "sternum"), (0.0, 0.0, 1.0), _HEAD)
        return {"pelvis": (), "neck": (trunk,), "head": (trunk, head)}[point]
    outward = 1.0 if side == "left" else -1.0
    clavicle = Link(carrier(f"shoulder_{side}", "sternum"), (0.0, outward, 0.0), _HALF_WIDTH)
    arm = (
        ("elbow", (f"upper_arm_{side}",), _UPPER_ARM),
        ("wrist", (f"forearm_{side}",), _FOREARM),
        ("hand", (f"hand_{side}", f"forearm_{side}"), _HAND),
    )
    links: list[Link] = [trunk, clavicle] if origin == "room" else []
    for name, choices, length in arm[: ("shoulder", "elbow", "wrist", "hand").index(joint)]:
        if carrier(*choices) == _UPRIGHT:
            raise SetupError(f"{point} needs a sensor on {choices[-1]} ({name}); worn: {', '.join(worn)}")
        links.append(Link(carrier(*choices), (0.0, 0.0, -1.0), length))
    return tuple(links)


class PointCovariance(NamedTuple):
    """Positions with their uncertainty.

    Attributes
    ----------
    position_m : ndarray, shape (K, P, 3)
        In room axes, from the chosen origin.
    covariance_m2 : ndarray, shape (K, P, 3, 3)
        Room axes, about `position_m`.
    """

    points: tuple[str, ...]
    position_m: Float
    covariance_m2: Float

    @property
    def sigma_m(self) -> Float:
        """Root of the summed variances, shape (K, P): one number for people."""
        return np.asarray(np.sqrt(np.trace(self.covariance_m2, axis1=-2, axis2=-1)))


def point_covariance(
    q_room_segment: Float,
    placements: Sequence[Placement],
    body: BodyDimensions,
    orientation_sigma_rad: Float,
    length_sigma: LengthSigma | None = None,
    *,
    points: Sequence[str] | None = None,
    origin: Origin = "room",
) -> PointCovariance:
    """Return positions and their 3x3 covariance.

    Parameters
    ----------
    q_room_segment : ndarray, shape (K, G, 4)
        In the order of `placements`.
    orientation_sigma_rad : ndarray, shape (K, G, 3) or (K, G, 3, 3)
        One-sigma about the room axes, or full covariances (rad^2) about them.
    points : sequence of str, optional
        By default elbow, wrist and hand of each side that the sensors allow.
    origin : {"room", "shoulder"}
        Relative to the shoulder, errors of the trunk do not count.

    Returns
    -------
    PointCovariance
        NaN where an orientation or its sigma is NaN.

    Raises
    ------
    ShapeError
        If the arrays do not fit the placements.
    SetupError
        If a point cannot be distinguished from these sensors.
    """
    q = np.asarray(q_room_segment, dtype=np.float64)
    shape = (q.shape[0], len(placements))
    if q.shape != (*shape, 4):
        raise ShapeError(f"orientations have shape {q.shape}; these placements need (ticks, {shape[1]}, 4)")
    given = np.asarray(orientation_sigma_rad, dtype=np.float64)
    if given.shape == (*shape, 3):
        spread = np.square(given)[..., None] * np.eye(3)
    elif given.shape == (*shape, 3, 3):
        spread = given
    else:
        raise ShapeError(f"orientation sigma has shape {given.shape}, not {(*shape, 3)} or {(*shape, 3, 3)}")
    names = tuple(points) if points is not None else arm_points(placements)
    lengths, sigmas = model_lengths(body), (length_sigma or LengthSigma()).by_link
    position = np.empty((shape[0], len(names), 3))
    covariance = np.empty((shape[0], len(names), 3, 3))
    for p, name in enumerate(names):
        start = np.zeros(3)
        if origin == "room":
            start[2] = lengths[0]
        total, matrix = np.broadcast_to(start, (shape[0], 3)), np.zeros((shape[0], 3, 3))
        carried: dict[int, Float] = {}
        for link in point_chain(name, placements, origin):
            unit = _direction(q, link)
            carried[link.carrier] = carried.get(link.carrier, np.zeros(3)) + lengths[link.length] * unit
            matrix = matrix + sigmas[link.length] ** 2 * unit[:, :, None] * unit[:, None, :]
        for column, vector in carried.items():
            total = total + vector
            if column != _UPRIGHT:
                matrix = matrix + _turned(vector, spread[:, column])
        position[:, p], covariance[:, p] = total, matrix
    return PointCovariance(names, position, covariance)


def arm_points(placements: Sequence[str]) -> tuple[str, ...]:
    """Return elbow, wrist and hand of each side, as far as the sensors tell them."""
    found = []
    for side in SIDES:
        if f"upper_arm_{side}" in placements:
            found.append(f"elbow_{side}")
            if f"forearm_{side}" in placements:
                found += [f"wrist_{side}", f"hand_{side}"]
    return tuple(found)


def _direction(q: Float, link: Link) -> Float:
    """Return the unit vector of a link in the room, shape (K, 3)."""
    direction = np.array(link.direction)
    if link.carrier == _UPRIGHT:
        return np.broadcast_to(direction, (q.shape[0], 3))
    return rotation.rotate(q[:, link.carrier], direction)


def _turned(vector: Float, spread: Float) -> Float:
    """Return the mean square of what a random turn, covariance (K, 3, 3), does to vectors (K, 3).

    First order [r]x S [r]x^T, and for e = 1/2 (d (d . r) - r d . d), by the fourth moments of a Gaussian:
    4 E[e e^T] = S (r'Sr) + 2 (Sr)(Sr)' - (v r' + r v') + r r' (t^2 + 2 tr S^2), v = t Sr + 2 SSr, t = tr S.
    The cross term of first and third order, which would make it smaller, is left out. No turn moves a point
    farther than a random one does, whose mean square is 2 r^2: the whole is cut off there.
    """
    x, y, z = np.moveaxis(vector, -1, 0)
    nought = np.zeros_like(x)
    cross = np.stack((nought, -z, y, z, nought, -x, -y, x, nought), axis=-1).reshape(-1, 3, 3)
    first = cross @ spread @ np.swapaxes(cross, -1, -2)
    along = np.einsum("kij,kj->ki", spread, vector)
    trace = np.trace(spread, axis1=-2, axis2=-1)
    v = trace[:, None] * along + 2.0 * np.einsum("kij,kj->ki", spread, along)
    outer = v[:, :, None] * vector[:, None, :]
    fourth = np.square(trace) + 2.0 * np.sum(np.square(spread), axis=(-2, -1))
    second = (
        spread * np.sum(vector * along, axis=-1)[:, None, None]
        + 2.0 * along[:, :, None] * along[:, None, :]
        - outer
        - np.swapaxes(outer, -1, -2)
        + vector[:, :, None] * vector[:, None, :] * fourth[:, None, None]
    )
    total = first + 0.25 * second
    size = np.trace(total, axis1=-2, axis2=-1)
    most = 2.0 * np.sum(np.square(vector), axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(size > most, most / size, 1.0)
    return np.asarray(total * share[:, None, None])
