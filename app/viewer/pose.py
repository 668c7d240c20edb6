"""From estimated frames, or from a template, to what the figure shows: one rotation per segment and tick.

The scene is a tree of segments, so that a tick is one small message per segment that moved: rotations are
relative to the parent, and a shoulder's place is given in the thorax.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.exercises.models import Posture
from app.viewer.figure.proportions import hip_height_m
from app.viewer.layers.feet import FeetTrack, feet_of
from app.viewer.layers.markers import MarkerTrack
from app.viewer.layers.mass_node import mass_of
from app.viewer.layers.modules import ModuleTrack, modules_of
from app.viewer.layers.single_sensors import SensorTrack, sensors_of
from estimators import rotation
from estimators.body import BodyDimensions
from estimators.conventions import SIDES, Side
from estimators.orientation._contract import OrientationFlag
from estimators.pipelines._contract import Frames

Float32 = NDArray[np.float32]

PARENT: Final[dict[str, str | None]] = {
    "pelvis": None,
    "sternum": None,
    "head": "sternum",
    **{
        f"{child}_{side}": f"{parent}_{side}"
        if parent in {"upper_arm", "forearm", "thigh", "shank"}
        else parent
        for side in SIDES
        for child, parent in (
            ("upper_arm", "sternum"),
            ("forearm", "upper_arm"),
            ("hand", "forearm"),
            ("thigh", "pelvis"),
            ("shank", "thigh"),
            ("foot", "shank"),
        )
    },
}
"""Segments of the figure, parents before children; `sternum` is the thorax. None hangs on the room."""

SEGMENTS: Final = tuple(PARENT)

_PARENT_COLUMN: Final = [
    len(SEGMENTS) if parent is None else SEGMENTS.index(parent) for parent in PARENT.values()
]

# In the N-pose the palms face the thighs; arms without sensors also hang a little away from the body.
_TURNED_IN = {"left": rotation.about_z(-np.pi / 2), "right": rotation.about_z(np.pi / 2)}
_HANGING = {"left": rotation.about_x(0.10), "right": rotation.about_x(-0.10)}
_HANGING_FOREARM = {
    side: rotation.multiply(rotation.multiply(_HANGING[side], rotation.about_y(-0.22)), _TURNED_IN[side])
    for side in SIDES
}
_HANGS_RAD: Final = np.radians(40.0)
"""A thigh that is nearer than this to the vertical is of somebody who stands: on a seat it lies about level."""
_LOST = np.uint8(OrientationFlag.INVALID)


@dataclass(frozen=True)
class PoseTrack:
    """The figure over K ticks.

    Attributes
    ----------
    time_s : ndarray, shape (K,)
        Session time.
    wxyz : ndarray of float32, shape (K, S, 4)
        Rotation of each segment in its parent, in the order of `SEGMENTS`.
    shoulder_m : ndarray of float32, shape (K, 2, 3)
        Left and right shoulder in the thorax.
    hand_m : ndarray of float32, shape (K, 2, 3)
        End of the left and right hand in the room; NaN where it is not known.
    halo_m : ndarray of float32, shape (K, 2, 2)
        Two standard deviations of the position of elbow and hand, per side; zero where unknown.
    lost : ndarray of bool, shape (K, S)
        The segment's sensor gives nothing now; the rotation is the last one known.
    modules : ModuleTrack or None
        Of a magnetic session: drawn instead of the figure.
    sensors : SensorTrack or None
        Of single sensors: drawn instead of the figure.
    feet : FeetTrack or None
        Of a walk: drawn instead of the figure.
    """

    time_s: NDArray[np.float64]
    wxyz: Float32
    shoulder_m: Float32
    hand_m: Float32
    halo_m: Float32
    lost: NDArray[np.bool_]
    modules: ModuleTrack | None = None
    sensors: SensorTrack | None = None
    feet: FeetTrack | None = None
    markers: MarkerTrack | None = None
    """Of markers beside a sensor: drawn instead of the figure."""
    mass_m: Float32 | None = None
    """Centre of mass, shape (K, 3), room, NaN while not known; None where the sensors do not tell it."""
    mass_spread_m: Float32 | None = None
    """Two standard deviations of it, shape (K,)."""
    stands: NDArray[np.bool_] | None = None
    """Of a seated exercise whether the thigh hangs as of who stands, shape (K,); None where no thigh is measured."""

    def __len__(self) -> int:
        """Return the number of ticks K."""
        return int(self.time_s.shape[0])


def measured_segments(frames: Frames) -> frozenset[str]:
    """Return the segments of the figure that a sensor drives."""
    return frozenset(frames.layout.segments) & frozenset(SEGMENTS)


def is_posed(frames: Frames) -> NDArray[np.bool_]:
    """Return which ticks show the person, shape (K,).

    Before the calibration sensors do not know how they sit: there is nothing yet to show but a standing figure.
    """
    if "pelvis" not in frames.layout.points or "source_coil" in frames.layout.scalars:
        return np.ones(frames.tick_count, dtype=bool)
    return np.isfinite(frames.point_room_m[:, frames.layout.points.index("pelvis"), 0])


def track_from_frames(frames: Frames, body: BodyDimensions, posture: Posture = "standing") -> PoseTrack:
    """Prepare estimated frames for drawing.

    Parameters
    ----------
    body : BodyDimensions
        Of the session's setup.
    posture : {"standing", "seated"}
        Of the exercise: legs without a sensor are drawn in it.

    Returns
    -------
    PoseTrack
        Arms without a sensor follow their parent or hang down, legs stand or sit; nothing is invented that looks
        measured.
    """
    layout, ticks = frames.layout, frames.tick_count
    given = {name: _sound(frames.q_room_segment[:, column]) for column, name in enumerate(layout.segments)}
    room = _complete(given, ticks, posture)
    stands = _stands(given) if posture == "seated" else None
    if stands is not None and stands.any():
        upright = _complete(given, ticks)
        room = {name: np.where(stands[:, None], upright[name], room[name]) for name in room}
    points = {name: frames.point_room_m[:, column] for column, name in enumerate(layout.points)}
    known = is_posed(frames)[:, None]
    if not known.all():
        waiting = _complete({}, ticks, posture)
        room = {name: np.where(known, room[name], waiting[name]) for name in room}
    lost = np.zeros((ticks, len(SEGMENTS)), dtype=bool)
    for column, name in enumerate(layout.segments):
        if name in PARENT:
            lost[:, SEGMENTS.index(name)] = (frames.segment_flags[:, column] & _LOST) != 0
    mass, spread = mass_of(frames, body)
    return PoseTrack(
        time_s=frames.time_s,
        wxyz=relative_rotations(room),
        shoulder_m=_shoulders(points, room["sternum"], body, ticks),
        hand_m=_hands(points, ticks),
        halo_m=_halo(frames, body),
        lost=lost,
        mass_m=mass,
        mass_spread_m=spread,
        stands=stands,
        modules=modules_of(frames),
        sensors=sensors_of(frames),
        feet=feet_of(frames),
    )


def track_from_markers(time_s: NDArray[np.float64], markers: MarkerTrack) -> PoseTrack:
    """Prepare fused markers for drawing, without the figure: where it is in the laboratory nobody knows."""
    ticks = len(time_s)
    upright = rotation.identity((len(SEGMENTS),)).astype(np.float32)
    return PoseTrack(
        time_s=time_s,
        wxyz=np.broadcast_to(upright, (ticks, *upright.shape)),
        shoulder_m=np.broadcast_to(np.zeros((2, 3), np.float32), (ticks, 2, 3)),
        hand_m=np.broadcast_to(np.full((2, 3), np.nan, np.float32), (ticks, 2, 3)),
        halo_m=np.broadcast_to(np.zeros((2, 2), np.float32), (ticks, 2, 2)),
        lost=np.zeros((ticks, len(SEGMENTS)), dtype=bool),
        markers=markers,
    )


def track_from_room(
    given: dict[str, NDArray[np.float64]],
    time_s: NDArray[np.float64],
    body: BodyDimensions,
    posture: Posture = "standing",
) -> PoseTrack:
    """Prepare orientations that come from elsewhere (a template) for drawing.

    Parameters
    ----------
    given : dict of segment to ndarray, shape (K, 4)
        Orientation in the room.
    time_s : ndarray, shape (K,)
    body : BodyDimensions
        Of the person on whom it is drawn, so that template and patient have the same lengths.
    posture : {"standing", "seated"}
        Of legs that are not given.

    Returns
    -------
    PoseTrack
        With the hands where forward kinematics puts them.
    """
    ticks = len(time_s)
    room = _complete(given, ticks, posture)
    shoulder = _shoulders({}, room["sternum"], body, ticks)
    hip = np.array([0.0, 0.0, hip_height_m(body)])
    hands = np.full((ticks, 2, 3), np.nan)
    for number, side in enumerate(SIDES):
        if f"forearm_{side}" not in given:
            continue
        place = hip + rotation.rotate(room["sternum"], shoulder[:, number])
        for segment, length in (
            ("upper_arm", body.upper_arm_m),
            ("forearm", body.forearm_m),
            ("hand", body.hand_m),
        ):
            place = place + rotation.rotate(room[f"{segment}_{side}"], np.array([0.0, 0.0, -length]))
        hands[:, number] = place
    return PoseTrack(
        time_s=time_s,
        wxyz=relative_rotations(room),
        shoulder_m=shoulder,
        hand_m=hands.astype(np.float32),
        halo_m=np.zeros((ticks, 2, 2), dtype=np.float32),
        lost=np.zeros((ticks, len(SEGMENTS)), dtype=bool),
    )


def thigh_at_rest(posture: Posture) -> NDArray[np.float64]:
    """Return the orientation of the thigh of somebody who faces ahead and stands or sits."""
    return rotation.about_y(-np.pi / 2) if posture == "seated" else rotation.identity()


def relative_rotations(room: dict[str, NDArray[np.float64]]) -> Float32:
    """Turn orientations in the room into rotations in the parent, shape (K, S, 4), free of sign jumps."""
    stacked = np.stack([room[name] for name in SEGMENTS], axis=1)
    upright = np.broadcast_to(rotation.identity(), (len(stacked), 1, 4))
    parents = np.concatenate([stacked, upright], axis=1)[:, _PARENT_COLUMN]
    return rotation.positive(rotation.multiply(rotation.conjugate(parents), stacked)).astype(np.float32)


def _sound(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Hold the last orientation over unknown ones; identity before the first."""
    known = np.isfinite(q).all(axis=-1)
    if known.all():
        return q
    last = np.maximum.accumulate(np.where(known, np.arange(len(q)), -1))
    return np.where((last >= 0)[:, None], q[np.maximum(last, 0)], rotation.identity())


def _complete(
    given: dict[str, NDArray[np.float64]], ticks: int, posture: Posture = "standing"
) -> dict[str, NDArray[np.float64]]:
    """Give every segment an orientation: measured, else with its parent, else hanging, standing or sitting."""
    room: dict[str, NDArray[np.float64]] = {}
    upright = rotation.identity((ticks,))
    for name, parent in PARENT.items():
        if name in given:
            room[name] = given[name]
        elif name.startswith("upper_arm"):
            room[name] = np.broadcast_to(_HANGING[_side(name)], (ticks, 4))
        elif name.startswith("forearm"):
            side = _side(name)
            upper = f"upper_arm_{side}"
            room[name] = (
                rotation.multiply(room[upper], _TURNED_IN[side])
                if upper in given
                else np.broadcast_to(_HANGING_FOREARM[side], (ticks, 4))
            )
        elif posture == "seated" and name.startswith(("thigh", "shank", "foot")):
            # A pelvis that leans leaves the legs on the seat; one that is turned takes them along.
            facing = rotation.about_z(rotation.split_heading(room["pelvis"])[0])
            level = thigh_at_rest(posture)
            room[name] = rotation.multiply(facing, level) if name.startswith("thigh") else facing
        else:
            room[name] = upright if parent is None else room[parent]
    return room


def _stands(given: dict[str, NDArray[np.float64]]) -> NDArray[np.bool_] | None:
    """Return when every measured thigh hangs down, shape (K,); None without one."""
    thighs = [given[name] for side in SIDES if (name := f"thigh_{side}") in given]
    if not thighs:
        return None
    down = np.array([0.0, 0.0, -1.0])
    hanging = np.stack([rotation.rotate(q, down)[:, 2] for q in thighs]) < -np.cos(_HANGS_RAD)
    stands: NDArray[np.bool_] = np.logical_and.reduce(hanging)
    return stands


def _shoulders(
    points: dict[str, NDArray[np.float64]], thorax: NDArray[np.float64], body: BodyDimensions, ticks: int
) -> Float32:
    """Shoulders in the thorax; measured ones (hiked, pulled forward) where there are any."""
    half = 0.5 * body.shoulder_width_m
    neutral = np.array([[0.0, half, body.trunk_m], [0.0, -half, body.trunk_m]])
    measured = [points.get(f"shoulder_{side}") for side in SIDES]
    if measured[0] is None or measured[1] is None:
        return np.broadcast_to(neutral, (ticks, 2, 3)).astype(np.float32)
    above_hip = np.stack([measured[0], measured[1]], axis=1) - np.array([0.0, 0.0, hip_height_m(body)])
    inside = rotation.rotate(rotation.conjugate(thorax)[:, None], above_hip)
    # Comparing with NaN is false: an unknown place, or one outside the body, becomes the neutral one.
    near = (np.abs(inside - neutral) < 0.25).all(axis=-1, keepdims=True)
    return np.where(near, inside, neutral).astype(np.float32)


def _hands(points: dict[str, NDArray[np.float64]], ticks: int) -> Float32:
    nowhere = np.full((ticks, 3), np.nan)
    return np.stack([points.get(f"hand_{side}", nowhere) for side in SIDES], axis=1).astype(np.float32)


def _halo(frames: Frames, body: BodyDimensions) -> Float32:
    """Two sigmas of elbow and hand: sigmas of shoulder elevation and elbow flexion times the levers."""
    angles = frames.layout.angles
    names = [f"thorax_humerus_{side}_yxy_elevation" for side in SIDES]
    names += [f"humerus_forearm_{side}_zxy_flexion" for side in SIDES]
    sigma = np.zeros((frames.tick_count, 4))
    for column, name in enumerate(names):
        if name in angles:
            sigma[:, column] = frames.angle_sigma_rad[:, angles.index(name)]
    sigma[~np.isfinite(sigma)] = 0.0
    shoulder, elbow, beyond = sigma[:, :2], sigma[:, 2:], body.forearm_m + body.hand_m
    at_hand = np.hypot(shoulder * (body.upper_arm_m + beyond), elbow * beyond)
    return (2.0 * np.stack([shoulder * body.upper_arm_m, at_hand], axis=-1)).astype(np.float32)


def _side(name: str) -> Side:
    return "left" if name.endswith("_left") else "right"


def thinned(frames: Frames, rate_hz: float = 60.0) -> Frames:
    """Return every n-th tick, so that no more are held than are ever drawn.

    Parameters
    ----------
    rate_hz : float
        The result is at least as fast, if the frames are.
    """
    return frames.every(max(1, int(1.0 / (frames.time_step_s * rate_hz) + 1e-6)))
