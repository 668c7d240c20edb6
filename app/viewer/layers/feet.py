"""Feet of a walk as they are prepared for drawing: poses, footprints, mass, pressure and base of support."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.balance import base_of_support
from estimators.conventions import Side
from estimators.kinetics import ShoeGeometry
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames

Float32 = NDArray[np.float32]

SOLE_HALF_WIDTH_M: Final = 0.045
_FOLLOWED_S: Final = 2.0
_LEAST_STEP_M: Final = 0.10


@dataclass(frozen=True)
class Footprint:
    """Where a foot stood: from which tick on, of which foot, where and pointing where about the vertical."""

    tick: int
    foot: int
    place_m: tuple[float, float, float]
    heading_rad: float


@dataclass(frozen=True)
class FeetTrack:
    """The feet over K ticks.

    Attributes
    ----------
    sides : tuple of Side
        Of the feet that are worn, in column order.
    place_m, wxyz : ndarray of float32, shape (K, F, 3) and (K, F, 4)
        Pose of each sole, room.
    stands, lost : ndarray of bool, shape (K, F)
    followed_m : ndarray of float32, shape (K, 2)
        What the picture goes along with: the middle of the feet, without their steps.
    prints : tuple of Footprint
        Of the whole recording; live those seen so far.
    mass_m, pressure_m, going_m : ndarray of float32, shape (K, 3), or None
        Centre of mass, centre of pressure and extrapolated centre of mass; None without forces, NaN while not known.
    force_n, pressed_m : ndarray of float32, shape (K, F, 3), or None
        Of the ground on each foot and where; live only, NaN while not measured.
    is_in_room : bool
        Whether the feet share a room already; else each is in its own world, as single sensors are live.
    trails_m : (ndarray, ndarray), each of float32, shape (N, 3), or None
        Live: where centre of mass and centre of pressure have been.
    """

    sides: tuple[Side, ...]
    place_m: Float32
    wxyz: Float32
    stands: NDArray[np.bool_]
    lost: NDArray[np.bool_]
    followed_m: Float32
    prints: tuple[Footprint, ...]
    mass_m: Float32 | None
    pressure_m: Float32 | None
    going_m: Float32 | None
    force_n: Float32 | None = None
    pressed_m: Float32 | None = None
    is_in_room: bool = False
    trails_m: tuple[Float32, Float32] | None = None


def feet_of(frames: Frames) -> FeetTrack | None:
    """Return the feet in frames; None when they are of another pipeline."""
    layout = frames.layout
    names = [name for name in ("foot_left", "foot_right") if f"{name}_stance" in layout.scalars]
    if not names or "pelvis" in layout.points:
        return None
    points = [layout.points.index(name) for name in names]
    segments = [layout.segments.index(name) for name in names]
    place = np.nan_to_num(frames.point_room_m[:, points])
    wxyz = frames.q_room_segment[:, segments].copy()
    wxyz[~np.isfinite(wxyz).all(axis=2)] = (1.0, 0.0, 0.0, 0.0)
    stance = np.stack([frames.scalar[:, layout.scalars.index(f"{name}_stance")] for name in names], axis=1)
    stands = np.nan_to_num(stance) > 0.5
    sides: tuple[Side, ...] = tuple("left" if name.endswith("left") else "right" for name in names)
    ticks = max(1, min(round(_FOLLOWED_S / frames.time_step_s), len(place)))
    middle = place[:, :, :2].mean(axis=1)

    def balance(name: str) -> Float32 | None:
        if name not in layout.points:
            return None
        return frames.point_room_m[:, layout.points.index(name)].astype(np.float32)

    force, pressed = _loads(frames, sides)
    return FeetTrack(
        sides=sides,
        place_m=place.astype(np.float32),
        wxyz=wxyz.astype(np.float32),
        stands=stands,
        lost=(frames.segment_flags[:, segments] & np.uint8(OrientationFlag.INVALID)) != 0,
        followed_m=scipy.ndimage.uniform_filter1d(middle, ticks, axis=0, mode="nearest").astype(np.float32),
        prints=_prints(place, wxyz, stands),
        mass_m=balance("centre_of_mass"),
        pressure_m=balance("centre_of_pressure"),
        going_m=balance("extrapolated_centre"),
        force_n=force,
        pressed_m=pressed,
        is_in_room=force is not None,
    )


def _loads(frames: Frames, sides: tuple[Side, ...]) -> tuple[Float32 | None, Float32 | None]:
    """Return force on each foot and its pressure centre, where live frames have them."""
    layout = frames.layout
    if "pressure_left" not in layout.points:
        return None, None
    columns = [[layout.scalars.index(f"foot_{side}_force_{axis}_n") for axis in "xyz"] for side in sides]
    places = [layout.points.index(f"pressure_{side}") for side in sides]
    return frames.scalar[:, columns].astype(np.float32), frames.point_room_m[:, places].astype(np.float32)


def heading_of(wxyz: NDArray[np.floating]) -> float:
    """Return where a foot points about the vertical."""
    w, x, y, z = (float(v) for v in wxyz)
    return float(np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z)))


def has_moved(before: Footprint | None, place_m: NDArray[np.floating]) -> bool:
    """Return whether a foot stands elsewhere than its last print."""
    if before is None:
        return True
    return bool(np.hypot(place_m[0] - before.place_m[0], place_m[1] - before.place_m[1]) > _LEAST_STEP_M)


def support_outline(track: FeetTrack, tick: int) -> NDArray[np.float64]:
    """Return the base of support of a tick, shape (M, 2), counter-clockwise; empty while nobody stands."""
    corners = [
        _sole_corners(track.place_m[tick, foot], track.wxyz[tick, foot])
        for foot in np.flatnonzero(track.stands[tick])
    ]
    return base_of_support(corners) if corners else np.empty((0, 2))


def _sole_corners(place_m: Float32, wxyz: Float32) -> NDArray[np.float64]:
    shoe = ShoeGeometry()
    heading = heading_of(wxyz)
    cosine, sine = np.cos(heading), np.sin(heading)
    ends = (shoe.rear_edge_m, shoe.hinge_m + shoe.toe_edge_m)
    local = np.array([(x, y) for x in ends for y in (SOLE_HALF_WIDTH_M, -SOLE_HALF_WIDTH_M)])
    return np.asarray(local @ np.array([[cosine, sine], [-sine, cosine]]) + place_m[:2])


def _prints(
    place: NDArray[np.float64], wxyz: NDArray[np.float64], stands: NDArray[np.bool_]
) -> tuple[Footprint, ...]:
    """Return a print for the middle of every stance that is elsewhere than the one before."""
    found = []
    for foot in range(stands.shape[1]):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], stands[:, foot], [False]]).astype(np.int8)))
        last: Footprint | None = None
        for start, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            middle = (start + stop - 1) // 2
            where = place[middle, foot]
            if has_moved(last, where):
                x, y, z = (float(v) for v in where)
                last = Footprint(start, foot, (x, y, z), heading_of(wxyz[middle, foot]))
                found.append(last)
    return tuple(sorted(found, key=lambda one: one.tick))
