"""Where one looks from: presets that fit the picture's shape, and steps for keys and buttons."""

import math
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from viser import _messages as viser_messages

from app.exercises.models import Posture
from app.viewer.figure.ghost import Limb
from app.viewer.figure.proportions import hip_half_width_m, hip_height_m
from estimators.body import BodyDimensions

Preset = Literal["start", "front", "side", "top", "arm", "movement"]
Point = tuple[float, float, float]

FIELD_OF_VIEW_RAD: Final = math.radians(32.0)
_LOWEST_DEG, _HIGHEST_DEG = -4.0, 88.5
_NEAREST_M, _FARTHEST_M = 0.6, 12.0

# Direction from which one looks (degrees from straight ahead of the patient toward the arm, degrees up), then
# what must fit in: middle, height and width as shares of stature.
_PRESETS: Final[dict[Preset, tuple[float, float, float, float, float]]] = {
    "start": (44.0, 9.0, 0.545, 1.16, 1.05),
    "front": (6.0, 6.0, 0.545, 1.16, 1.05),
    "side": (90.0, 5.0, 0.545, 1.16, 1.05),
    "top": (180.0, 86.0, 0.60, 1.05, 1.05),
    "arm": (38.0, 14.0, 0.74, 0.62, 0.70),
}
# A walk happens on the floor: seen from higher, its middle at the knees; `arm` comes near to the feet.
_WALK_PRESETS: Final[dict[Preset, tuple[float, float, float, float, float]]] = {
    "start": (52.0, 24.0, 0.20, 1.00, 1.05),
    "front": (6.0, 16.0, 0.24, 0.90, 0.90),
    "side": (90.0, 9.0, 0.26, 0.90, 1.05),
    "top": (180.0, 86.0, 0.00, 1.05, 1.25),
    "arm": (46.0, 24.0, 0.03, 0.45, 0.50),
}
# `arm` of an exercise of a leg comes near to that leg; of who sits it lies ahead of the seat.
_NEAR_LEG: Final[dict[Posture, tuple[float, float, float, float, float]]] = {
    "standing": (42.0, 10.0, 0.27, 0.66, 0.62),
    "seated": (62.0, 10.0, 0.19, 0.52, 0.72),
}
_AHEAD: Final = 0.20
"""How far ahead of the hips the middle of the leg of who sits is, as a share of stature."""
# Without a template the kind of movement says what is known of it.
_OF_MOVEMENT: Final[dict[str, Preset]] = {
    "abduction": "front",
    "pronation": "arm",
    "flexion": "side",
    "reaching": "side",
    "drinking": "side",
}
# Never from behind, where the trunk hides the hand: a little past the side, and a little across the front.
_FARTHEST_ROUND_DEG, _FARTHEST_ACROSS_DEG = 100, -30
_AS_GOOD: Final = 0.97
_LOWER: Final = 0.3
"""Share of the way down to the seat that the middle of the picture goes: who stands up again is in it as well."""
_FEET_AHEAD: Final = 0.12
"""What the picture has below the seat for the feet, as a share of stature."""
_KNEES, _BESIDE_M = 0.36, 0.22
"""How far the feet of who sits stand ahead, as a share of stature, and what is left beside the outermost point."""
_SMALL_M: Final = 0.15
"""A hand that goes no farther is looked at from near by."""


@dataclass(frozen=True)
class Sight:
    """From where a movement is seen best.

    Attributes
    ----------
    azimuth_deg : float
        From straight ahead of the patient toward the arm that moves.
    is_near : bool
        Whether it is so small that one comes near.
    reach_m : float
        How far to a side of the hips it goes in the picture.
    """

    azimuth_deg: float
    is_near: bool
    reach_m: float


def best_sight(points_m: NDArray[np.float64], side: str) -> Sight:
    """Return from where the movement of points is large.

    Parameters
    ----------
    points_m : ndarray, shape (K, N, 3)
        Places over a movement, relative to the middle of the hips: the end of the hand first, then others that move
        with it.
    side : {"left", "right"}
        The arm that moves.

    Returns
    -------
    Sight
        Among the directions of which the picture shows the movement as large as the best one does, but for 3 %, the
        one nearest to half from the side, where depth can be seen as well.

    Notes
    -----
    How large a picture shows it: root of the sum of squares of what stands across the line of sight,
    `trace S - d' S d` with the scatter S of each point about its mean and the line of sight d.
    """
    about = points_m - points_m.mean(axis=0)
    scatter = np.einsum("kni,knj->ij", about, about)
    azimuths = np.arange(_FARTHEST_ACROSS_DEG, _FARTHEST_ROUND_DEG + 1)
    start_deg, elevation_deg = _PRESETS["start"][:2]
    toward = 1.0 if side == "left" else -1.0
    sight = np.array([_place((0.0, 0.0, 0.0), toward * a, elevation_deg, 1.0) for a in azimuths])
    seen = np.sqrt(np.maximum(np.trace(scatter) - np.einsum("ai,ij,aj->a", sight, scatter, sight), 0.0))
    good = azimuths[seen >= _AS_GOOD * seen.max()]
    best = float(good[np.argmin(np.abs(good - start_deg))])
    along = math.radians(toward * best + 90.0)
    across = points_m[..., 0] * math.cos(along) + points_m[..., 1] * math.sin(along)
    is_near = bool(np.ptp(points_m[:, 0], axis=0).max() < _SMALL_M)
    return Sight(best, is_near, float(np.abs(across).max()))


@dataclass(frozen=True)
class Camera:
    """A camera that looks at a point of the room.

    Attributes
    ----------
    position_m, look_at_m : tuple of float
        In the room.
    """

    position_m: Point
    look_at_m: Point

    def messages(self) -> list[Any]:
        """Return the viser messages that move a browser's camera here."""
        return [
            viser_messages.SetCameraPositionMessage(self.position_m),
            viser_messages.SetCameraLookAtMessage(self.look_at_m),
        ]

    def stepped(self, turn_deg: float, tilt_deg: float, zoom: float) -> "Camera":
        """Walk around the point, rise, or come nearer.

        Parameters
        ----------
        zoom : float
            Above 1 comes nearer.
        """
        azimuth, elevation, distance = self._around()
        elevation = min(max(elevation + tilt_deg, _LOWEST_DEG), _HIGHEST_DEG)
        distance = min(max(distance / zoom, _NEAREST_M), _FARTHEST_M)
        return replace(self, position_m=_place(self.look_at_m, azimuth + turn_deg, elevation, distance))

    def _around(self) -> tuple[float, float, float]:
        x, y, z = (a - b for a, b in zip(self.position_m, self.look_at_m, strict=True))
        distance = math.sqrt(x * x + y * y + z * z) or 1.0
        return math.degrees(math.atan2(y, x)), math.degrees(math.asin(z / distance)), distance


def around(name: Preset, height_m: float, size_m: float, aspect: float) -> Camera:
    """Return a preset for something of a size around the middle of the room, as markers are.

    Parameters
    ----------
    name : {"start", "front", "side", "top", "arm", "movement"}
        `arm` comes near.
    height_m, size_m : float
        Of its middle, and its largest extent.
    """
    azimuth, elevation = {
        "start": (52.0, 22.0),
        "movement": (52.0, 22.0),
        "front": (6.0, 8.0),
        "side": (90.0, 8.0),
        "top": (180.0, 86.0),
        "arm": (52.0, 22.0),
    }[name]
    seen = (0.6 if name == "arm" else 1.25) * size_m / min(max(aspect, 0.2), 1.0)
    distance = min(max(0.5 * seen / math.tan(0.5 * FIELD_OF_VIEW_RAD), _NEAREST_M), _FARTHEST_M)
    look_at = (0.0, 0.0, height_m)
    return Camera(_place(look_at, azimuth, elevation, distance), look_at)


def preset(
    name: Preset,
    body: BodyDimensions,
    side: str,
    aspect: float,
    *,
    is_walk: bool = False,
    posture: Posture = "standing",
    sight: Sight | None = None,
    movement: str = "",
    limb: Limb = "arm",
) -> Camera:
    """Return a preset for this person and this picture.

    Parameters
    ----------
    name : {"start", "front", "side", "top", "arm", "movement"}
        `start` is half from the side: it shows reaching forward as well as raising sideways.
    side : str
        `left` or `right`: the arm that matters; it is turned toward the camera.
    aspect : float
        Width over height of the picture; a narrow one needs more distance.
    is_walk : bool
        Whether feet and footprints are shown instead of the figure.
    posture : {"standing", "seated"}
        Of the exercise. Of who sits the whole figure is still in the picture when it stands up.
    sight : Sight or None
        For `movement`: from where the template's movement is large; None without a template.
    movement : str
        For `movement` without a template: the kind of the exercise.
    limb : {"arm", "leg"}
        What `arm` comes near to, where it is no walk.
    """
    drop = hip_height_m(body) - hip_height_m(body, posture)
    followed = sight if name == "movement" and not is_walk else None
    if name == "movement":
        name = (
            "arm"
            if followed and followed.is_near
            else "start"
            if followed
            else _OF_MOVEMENT.get(movement, "start")
        )
    azimuth, elevation, middle, height, width = (_WALK_PRESETS if is_walk else _PRESETS)[name]
    lower = drop if name == "arm" else _LOWER * drop
    if drop and followed is None and name in {"start", "front"}:
        # The feet stand ahead of the seat, toward the camera, and so lower in the picture than those of who stands.
        height += _FEET_AHEAD
        lower += 0.5 * _FEET_AHEAD * body.stature_m
    is_near_leg = name == "arm" and limb == "leg" and not is_walk
    if is_near_leg:
        azimuth, elevation, middle, height, width = _NEAR_LEG[posture]
        lower = 0.0
    if followed is not None:
        azimuth = followed.azimuth_deg
        if name == "start":
            # Nobody stands up while it is followed: as near as body, knees and hand allow.
            knees_m = _KNEES * body.stature_m * math.sin(math.radians(abs(azimuth))) if drop else 0.0
            lower, height = 0.55 * drop, height - 0.55 * drop / body.stature_m
            width = min(width, 2.0 * (max(followed.reach_m, knees_m) + _BESIDE_M) / body.stature_m)
    toward = 1.0 if side == "left" else -1.0
    sideways = toward * 0.5 * body.shoulder_width_m if name == "arm" and not is_walk else 0.0
    forward = 0.12 * body.stature_m if name in {"side", "top"} and not is_walk else 0.0
    if is_near_leg:
        sideways = toward * hip_half_width_m(body)
        forward = _AHEAD * body.stature_m if posture == "seated" else 0.0
    tangent = math.tan(0.5 * FIELD_OF_VIEW_RAD)
    distance = 0.5 * body.stature_m * max(height / tangent, width / (tangent * max(aspect, 0.2)))
    look_at = (forward, sideways, middle * body.stature_m - lower)
    return Camera(_place(look_at, toward * azimuth, elevation, min(distance, _FARTHEST_M)), look_at)


def _place(look_at: Point, azimuth_deg: float, elevation_deg: float, distance_m: float) -> Point:
    azimuth, elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    level = distance_m * math.cos(elevation)
    return (
        look_at[0] + level * math.cos(azimuth),
        look_at[1] + level * math.sin(azimuth),
        look_at[2] + distance_m * math.sin(elevation),
    )
