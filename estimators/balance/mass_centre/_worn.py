"""Centre of mass of a body from the sensors it wears, tick by tick, with what is not known of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.balance.mass_centre import _worn_kernel as at
from estimators.balance.mass_centre._body_levers import MIDDLE_TRUNK, body_levers, stand_in_of
from estimators.balance.mass_centre._segments import BodySegments, mean_segments
from estimators.body import HIP_HEIGHT_PER_STATURE, BodyDimensions
from estimators.conventions import PLACEMENTS, SIDES
from estimators.errors import SetupError, ShapeError
from estimators.recording import Float

MASS_POINT: Final = "centre_of_mass"
MASS_SCALARS: Final = (
    "centre_of_mass_ahead_m",
    "centre_of_mass_left_m",
    "centre_of_mass_height_m",
    "centre_of_mass_ahead_sigma_m",
    "centre_of_mass_left_sigma_m",
    "centre_of_mass_height_sigma_m",
)
"""From the middle between the ankles, ahead as the trunk faces, and above the floor under the lower foot; and one
sigma of each."""
NEEDED: Final = ("thigh_left", "thigh_right")


@dataclass(frozen=True)
class WornBodyParameters:
    """What is not measured of a body.

    Attributes
    ----------
    lever_share : float
        By which part of its length each segment's lever may be wrong, in any direction: lengths, masses and where
        they lie differ from the table's.
    assumed_rad : dict of str to float
        How far a segment without a sensor may be turned against the one it is taken to move with, one sigma about
        each axis.
    """

    lever_share: float = 0.05
    assumed_rad: dict[str, float] = field(
        default_factory=lambda: {
            "pelvis": 0.2,
            "sternum": 0.2,
            "head": 0.25,
            "shoulder": 0.1,
            "upper_arm": 0.5,
            "forearm": 0.6,
            "hand": 0.4,
            "thigh": 0.4,
            "shank": 0.4,
            "foot": 0.3,
        }
    )


class WornMassCentreResult(NamedTuple):
    """What is known of K ticks.

    Attributes
    ----------
    from_hip_m : ndarray, shape (K, 3)
        From the middle of the hips, room axes.
    scalar : ndarray, shape (K, 6)
        `MASS_SCALARS`; sigmas are NaN where those of the orientations are.
    """

    from_hip_m: Float
    scalar: Float


def has_mass_centre(placements: Sequence[str]) -> bool:
    """Return whether sensors tell a centre of mass: one on the trunk and both thighs.

    Without the thighs nobody knows whether a person stands or sits.
    """
    worn = set(placements)
    return bool(worn & {"sternum", "pelvis"}) and worn.issuperset(NEEDED)


class WornMassCentre:
    """The centre of mass of one body with a sensor on some of its seventeen segments.

    Equals `segmental_mass_centre` and says how well it is known. Segments without a sensor move with their
    neighbour; feet without one are level.

    Parameters
    ----------
    placements : sequence of Placement
        In the order of the orientations; at least the trunk and both thighs.
    segments : BodySegments, optional
        By default the mean of men and women.

    Attributes
    ----------
    assumed : tuple of str
        Segments without a sensor.

    Raises
    ------
    SetupError
        If a sensor that is needed is missing, or a placement is unknown or occurs twice.

    Notes
    -----
    `c = sum of m_j c_j` (Schepers 2009, equation 4.7), written as `sum of R_s b_s` over sensors. Orientation errors d
    of sensors are independent: each adds `d x R_s b_s`; of an assumed segment the lever of all that moves with it.
    """

    def __init__(
        self,
        placements: Sequence[str],
        body: BodyDimensions | None = None,
        segments: BodySegments | None = None,
        parameters: WornBodyParameters | None = None,
    ) -> None:
        self.placements = worn = _checked(placements)
        self.assumed = tuple(name for name in PLACEMENTS if name not in worn)
        c = parameters or WornBodyParameters()
        known = body_levers(segments or mean_segments(), body or BodyDimensions())
        carrier: dict[str, str] = {name: _carrier(name, worn) for name in PLACEMENTS}
        level = {side: f"foot_{side}" for side in SIDES if f"foot_{side}" not in worn}
        count = len(worn)
        self._lever = np.zeros((at.TARGETS, count, 3))
        self._doubt = np.zeros((at.TARGETS, count, 3, 3))
        self._middle, self._feet = known.mass[MIDDLE_TRUNK], np.zeros((2, 3))
        for side, name in level.items():
            self._feet[SIDES.index(side)] = known.mass[name]
        self._settings = np.zeros(at.SETTINGS)
        self._settings[at.S_ANKLE] = known.ankle_height_m
        # From the hips; from the middle of the ankles, the left, the right ankle to the centre of mass.
        minus = ((0.0, 0.0), (0.5, 0.5), (1.0, 0.0), (0.0, 1.0))
        for target, parts in enumerate(minus):
            own = {name: vector.copy() for name, vector in known.mass.items() if name != MIDDLE_TRUNK}
            for weight, side in zip(parts, SIDES, strict=True):
                for name, vector in known.ankle[side].items():
                    own[name] -= weight * vector
            if target == at.FROM_MIDDLE:
                squares = sum(float(vector @ vector) for vector in (*own.values(), self._middle))
                self._settings[at.S_LEVER2] = c.lever_share**2 * squares
            for name, vector in own.items():
                if name not in level.values():
                    self._lever[target, worn.index(carrier[name])] += vector
            for name in self.assumed:
                # All that moves with it; of the trunk's middle, half.
                if name in level.values():
                    continue
                moved = np.zeros(3)
                for other in self.assumed:
                    if name in _way(other, worn) and other not in level.values():
                        moved = moved + own[other]
                if name in ("pelvis", "sternum"):
                    moved = moved + 0.5 * self._middle
                part = name.rpartition("_")[0] if name.endswith(SIDES) else name
                spread = float(moved @ moved) * np.eye(3) - np.outer(moved, moved)
                self._doubt[target, worn.index(carrier[name])] += c.assumed_rad[part] ** 2 * spread
        self._has_doubt = np.asarray(self._doubt.any(axis=(0, 2, 3)), dtype=np.uint8)
        pelvis, sternum = (worn.index(carrier[name]) for name in ("pelvis", "sternum"))
        shanks = [worn.index(carrier[f"shank_{side}"]) for side in SIDES]
        self._standing = self._settings.copy()
        self._standing[at.S_HIP] = HIP_HEIGHT_PER_STATURE * (body or BodyDimensions()).stature_m
        self._source = np.array([pelvis, sternum, *shanks], dtype=np.int64)

    def evaluate(self, q_room_segment: Float, sigma_room_rad: Float | None = None) -> WornMassCentreResult:
        """Find the centre of mass of K ticks.

        Parameters
        ----------
        q_room_segment : ndarray, shape (K, S, 4)
            In the order of `placements`; z up.
        sigma_room_rad : ndarray, shape (K, S, 3), optional
            One sigma about the room axes.

        Raises
        ------
        ShapeError
            If an array does not fit the placements.
        """
        ticks, count = len(q_room_segment), len(self.placements)
        if q_room_segment.shape != (ticks, count, 4):
            raise ShapeError(f"q_room_segment has shape {q_room_segment.shape}, not {(ticks, count, 4)}")
        sigma = np.full((ticks, count, 3), np.nan) if sigma_room_rad is None else sigma_room_rad
        if sigma.shape != (ticks, count, 3):
            raise ShapeError(f"sigma_room_rad has shape {sigma.shape}, not {(ticks, count, 3)}")
        from_hip, scalar = np.empty((ticks, 1, 3)), np.empty((ticks, len(MASS_SCALARS)))
        self._run(
            np.ascontiguousarray(q_room_segment, dtype=np.float64),
            np.ascontiguousarray(sigma, dtype=np.float64),
            np.zeros((ticks, count), dtype=np.uint8),
            self._settings,
            from_hip,
            scalar,
        )
        return WornMassCentreResult(from_hip[:, 0], scalar)

    def write(
        self,
        q_room_segment: Float,
        sigma_room_rad: Float,
        segment_flags: NDArray[np.uint8],
        point_room_m: Float,
        scalar: Float,
    ) -> None:
        """Write the centre of mass of K ticks into the last point and the last scalars of frames, unchecked.

        Parameters
        ----------
        q_room_segment : ndarray, shape (K, S, 4)
        sigma_room_rad : ndarray, shape (K, S, 3)
        segment_flags : ndarray of uint8, shape (K, S)
            While a sensor is INVALID, the scalars are NaN.
        point_room_m : ndarray, shape (K, P, 3)
            With the hips at their height above the floor.
        scalar : ndarray, shape (K, C)
            `MASS_SCALARS` are the last six.
        """
        self._run(q_room_segment, sigma_room_rad, segment_flags, self._standing, point_room_m, scalar)

    def _run(
        self,
        q: Float,
        sigma: Float,
        flags: NDArray[np.uint8],
        settings: Float,
        point: Float,
        scalar: Float,
    ) -> None:
        at.mass_centre(
            q,
            sigma,
            flags,
            self._lever,
            self._doubt,
            self._has_doubt,
            self._middle,
            self._feet,
            self._source,
            settings,
            point,
            scalar,
        )


def _way(name: str, worn: Sequence[str]) -> list[str]:
    """Return the segment and those, without a sensor, over which it hangs on the one that carries it."""
    way = []
    while name not in worn:
        way.append(name)
        name = stand_in_of(name)
    return way


def _carrier(name: str, worn: Sequence[str]) -> str:
    """Return the worn segment with which one moves."""
    way = _way(name, worn)
    return stand_in_of(way[-1]) if way else name


def _checked(placements: Sequence[str]) -> tuple[str, ...]:
    worn = tuple(placements)
    unknown = [name for name in worn if name not in PLACEMENTS]
    if unknown or len(set(worn)) != len(worn):
        raise SetupError(f"placements must be different ones of {', '.join(PLACEMENTS)}; got {worn}")
    if not has_mass_centre(worn):
        raise SetupError(
            "a centre of mass needs sensors on both thighs and on the sternum or the pelvis; worn: "
            + (", ".join(worn) or "none")
        )
    return worn
