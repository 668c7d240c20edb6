"""What of a session is compared: trajectories, the channels of one side, mirroring, and names for people."""

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._bands import Knot, ToleranceCurve
from estimators.comparison._contract import Repetition, Template, Trajectory
from estimators.comparison.measures.places import ARM_POINTS, place_sigma
from estimators.conventions import Side
from estimators.errors import ComparisonError, SetupError
from estimators.orientation._contract import OrientationFlag
from estimators.pipelines._contract import Frames
from estimators.recording import Float
from estimators.rotation import conjugate, rotate
from estimators.sentences import ENGLISH, say

TRUNK_CHANNELS = ("trunk_lean_forward_rad", "trunk_lean_lateral_rad", "trunk_axial_rotation_rad")
"""Scalars that show compensation with the trunk; the last two change sign in a mirror."""

_HIKES = "shoulder_hike"

LEG_SEGMENTS = ("thigh", "shank")
"""Their lean is a channel of repetitions, not of comparisons: no joint of the leg is measured."""

_MIRRORED_SIGN = {"trunk_lean_lateral_rad", "trunk_axial_rotation_rad"}
_UNUSABLE = np.uint8(OrientationFlag.INVALID | OrientationFlag.SINGULAR)


def trajectory(frames: Frames) -> Trajectory:
    """Collect the channels of a session that comparisons use.

    Parameters
    ----------
    frames : Frames
        Consecutive ticks of one session, for instance from `estimators.pipelines.concatenate`.

    Returns
    -------
    Trajectory
        Every angle, every scalar, then every point as `<point>.x|y|z` in the room frame, m; then of worn thighs and
        shanks `<segment>_lean_forward_rad`, how far the upper end leans ahead in the segment's own x-z plane, rad. A
        value is valid when it is finite and its sensors were tracked; an angle also not where its sequence is singular,
        because there the number says nothing about the posture. Sigma of elbow, wrist and hand is that of their place
        relative to the shoulder.
    """
    layout = frames.layout
    points = tuple(f"{point}.{axis}" for point in layout.points for axis in "xyz")
    point_values = frames.point_room_m.reshape(frames.tick_count, -1)
    values = np.concatenate([frames.angle_rad, frames.scalar, point_values], axis=1)
    sigma = np.full_like(values, np.nan)
    sigma[:, : len(layout.angles)] = frames.angle_sigma_rad
    if frames.segment_sigma_rad is not None:
        sigma[:, len(layout.angles) + len(layout.scalars) :] = place_sigma(frames, frames.segment_sigma_rad)
    valid = np.isfinite(values)
    valid[:, : len(layout.angles)] &= (frames.angle_flags & _UNUSABLE) == 0
    tracked = (frames.segment_flags & np.uint8(OrientationFlag.INVALID)) == 0
    for column, name in enumerate((*layout.scalars, *points), start=len(layout.angles)):
        needed = [layout.segments.index(s) for s in _segments_behind(name) if s in layout.segments]
        if needed:
            valid[:, column] &= tracked[:, needed].all(axis=1)
    legs = [column for column, name in enumerate(layout.segments) if name.startswith(LEG_SEGMENTS)]
    if legs:
        up = rotate(conjugate(frames.q_room_segment[:, legs]), np.array([0.0, 0.0, 1.0]))
        lean = np.arctan2(-up[..., 0], up[..., 2])
        values = np.concatenate([values, lean], axis=1)
        sigma = np.concatenate([sigma, np.full_like(lean, np.nan)], axis=1)
        valid = np.concatenate([valid, np.isfinite(lean) & tracked[:, legs]], axis=1)
    return Trajectory(
        time_s=frames.time_s,
        channels=(
            *layout.angles,
            *layout.scalars,
            *points,
            *(f"{layout.segments[column]}_lean_forward_rad" for column in legs),
        ),
        values=values,
        sigma=sigma,
        valid=valid,
    )


def _segments_behind(channel: str) -> tuple[str, ...]:
    """Segments whose loss makes a scalar or point untrue."""
    if channel.startswith("trunk_"):
        return ("sternum",)
    side = "left" if "_left" in channel else "right" if "_right" in channel else ""
    if not side:
        return ("sternum",)
    chain = ["sternum", f"upper_arm_{side}", f"forearm_{side}", f"hand_{side}"]
    if channel.startswith("shoulder_"):
        return tuple(chain[:1])
    if channel.startswith("elbow_"):
        return tuple(chain[:2])
    if channel.startswith("wrist_"):
        return tuple(chain[:3])
    return tuple(chain)


@dataclass(frozen=True)
class ArmChannels:
    """The comparable channels of one side.

    Attributes
    ----------
    channels : tuple of str
        Joint angles of the side, trunk scalars, then elbow, wrist and hand as `<point>.x|y|z`.
    values, sigma : ndarray, shape (N, C)
        Angles and leans in rad. Positions in m relative to the shoulder of the same side, times
        `reach_to / reach_from`, so that people of different size can be laid on each other. NaN where
        the trajectory is not valid.
    """

    time_s: Float
    channels: tuple[str, ...]
    values: Float
    sigma: Float

    def column(self, channel: str) -> Float | None:
        """Return one channel, shape (N,), or None when it was not measured."""
        return self.values[:, self.channels.index(channel)] if channel in self.channels else None

    def cut(self, repetition: Repetition) -> "ArmChannels":
        """Return the samples of one repetition, half-open in session time."""
        inside = (self.time_s >= repetition.start_s - 1e-9) & (self.time_s < repetition.end_s - 1e-9)
        return replace(self, time_s=self.time_s[inside], values=self.values[inside], sigma=self.sigma[inside])


def arm_channels(source: Trajectory, side: str, size_ratio: float = 1.0) -> ArmChannels:
    """Pick and normalise the channels of one side.

    Parameters
    ----------
    source : Trajectory
    side : {"left", "right"}
    size_ratio : float
        Reach of the person to compare with divided by the reach of the person measured.

    Returns
    -------
    ArmChannels
        Only channels with at least one valid sample.

    Raises
    ------
    ComparisonError
        If nothing of that side was measured.
    """
    check_side(side)
    masked = np.where(source.valid, source.values, np.nan)
    index = {name: column for column, name in enumerate(source.channels)}
    names: list[str] = []
    values: list[Float] = []
    sigma: list[Float] = []
    for name in source.channels:
        is_angle = (
            f"_{side}_" in name and not name.endswith(("_mps", "_m")) and not name.startswith(LEG_SEGMENTS)
        )
        if is_angle or name in TRUNK_CHANNELS or name == f"shoulder_hike_{side}_m":
            names.append(name)
            values.append(masked[:, index[name]])
            sigma.append(source.sigma[:, index[name]])
    for point in ARM_POINTS:
        for axis in "xyz":
            name, origin = f"{point}_{side}.{axis}", f"shoulder_{side}.{axis}"
            if name in index and origin in index:
                names.append(name)
                values.append((masked[:, index[name]] - masked[:, index[origin]]) * size_ratio)
                sigma.append(source.sigma[:, index[name]] * size_ratio)
    measured = [i for i, column in enumerate(values) if np.isfinite(column).any()]
    if not any(f"_{side}" in names[i] for i in measured):
        raise ComparisonError(say("compare.side_not_measured", side=side))
    return ArmChannels(
        time_s=source.time_s,
        channels=tuple(names[i] for i in measured),
        values=np.ascontiguousarray(np.stack([values[i] for i in measured], axis=1)),
        sigma=np.ascontiguousarray(np.stack([sigma[i] for i in measured], axis=1)),
    )


def check_side(side: str) -> None:
    """Raise `SetupError` unless the side is one of the two."""
    if side not in ("left", "right"):
        raise SetupError(f"side is {side!r}; use 'left' or 'right'")


def other_side(side: str) -> Side:
    """Return the side across."""
    check_side(side)
    return "left" if side == "right" else "right"


def mirrored_name(name: str) -> str:
    """Return what a channel is called on the other side."""
    return re.sub(r"left|right", lambda found: other_side(found.group()), name)


def _mirrored_signs(channels: tuple[str, ...]) -> Float:
    return np.array([-1.0 if changes_sign(name) else 1.0 for name in channels])


def changes_sign(name: str) -> bool:
    """Return whether a channel has the opposite sign in a mirror: to the side, and turning of the trunk."""
    return name in _MIRRORED_SIGN or name.endswith(".y")


def is_compensation(channel: str) -> bool:
    """Tell whether a channel shows how trunk or shoulder help the arm."""
    return channel in TRUNK_CHANNELS or channel.startswith(_HIKES)


def mirror_trajectory(source: Trajectory) -> Trajectory:
    """Swap left and right: what the same person would show in a mirror.

    Joint angles keep their sign because their positive directions are anatomical on both sides; y
    coordinates, lateral lean and axial rotation of the trunk change it.
    """
    return replace(
        source,
        channels=tuple(mirrored_name(name) for name in source.channels),
        values=source.values * _mirrored_signs(source.channels),
    )


def mirror_template(template: Template) -> Template:
    """Return the template for the other arm; see `mirror_trajectory` for the signs.

    What changes its sign has above where it had below.
    """
    return replace(
        template,
        tolerances=tuple(
            ToleranceCurve(
                mirrored_name(curve.channel),
                tuple(Knot(k.phase, k.above, k.below) for k in curve.knots)
                if changes_sign(curve.channel)
                else curve.knots,
            )
            for curve in template.tolerances
        ),
        watched=tuple(mirrored_name(name) for name in template.watched),
        channels=tuple(mirrored_name(name) for name in template.channels),
        mean=template.mean * _mirrored_signs(template.channels),
        primary_channel=mirrored_name(template.primary_channel),
        side=other_side(template.side),
        measures={mirrored_name(name): value for name, value in template.measures.items()},
        measure_sd={mirrored_name(name): value for name, value in template.measure_sd.items()},
    )


_CHANNEL_NAMES = {
    "plane_of_elevation": "plane_of_elevation",
    "elevation": "elevation",
    "axial_rotation": "axial_rotation",
    "humerus_forearm_flexion": "elbow_flexion",
    "humerus_forearm_carrying": "elbow_carrying",
    "humerus_forearm_pronation": "forearm_pronation",
    "forearm_hand_flexion": "wrist_flexion",
    "forearm_hand_deviation": "wrist_deviation",
    "forearm_hand_rotation": "wrist_rotation",
    "trunk_lean_forward_rad": "trunk_forward_lean",
    "trunk_lean_lateral_rad": "trunk_sideways_lean",
    "trunk_axial_rotation_rad": "trunk_rotation",
}


def channel_name(channel: str) -> str:
    """Return what sentences call a channel, without the side: `elbow_flexion` has the words `channel.elbow_flexion`.

    Parameters
    ----------
    channel : str
        Of a trajectory. One without words of its own is named by its parts.
    """
    if "." in channel:
        point, axis = channel.split(".")
        return f"{point.split('_')[0]}_{axis}"
    if channel.startswith("shoulder_hike"):
        return "shoulder_hike"
    if channel in _CHANNEL_NAMES:
        return _CHANNEL_NAMES[channel]
    found = re.fullmatch(r"(\w+?_\w+?)_(left|right)_[xyz]{3}_(\w+)", channel)
    if found:
        joint, _, meaning = found.groups()
        name = _CHANNEL_NAMES.get(meaning if joint == "thorax_humerus" else f"{joint}_{meaning}")
        if name:
            return name
    return channel.removesuffix("_rad").replace("_", " ")


def channel_label(channel: str) -> str:
    """Return what a person calls a channel, without the side: `Elbow flexion`, `Hand forward`."""
    name = channel_name(channel)
    words = str(ENGLISH.get(f"channel.{name}", name))
    return words[:1].upper() + words[1:]


def channel_unit(channel: str) -> str:
    """Return `m` for positions and hikes, `rad` for everything else that is compared."""
    return "m" if "." in channel or channel.endswith("_m") else "rad"


def fill_gaps(values: Float) -> tuple[Float, NDArray[np.bool_]]:
    """Interpolate each column linearly over its gaps; also return which columns have any value.

    Parameters
    ----------
    values : ndarray, shape (N, C)
        NaN in gaps.

    Returns
    -------
    filled : ndarray, shape (N, C)
        Ends hold the nearest value; a column without any value is zero.
    usable : ndarray of bool, shape (C,)
    """
    filled = values.copy()
    sound: NDArray[np.bool_] = np.asarray(np.isfinite(values))
    usable = np.asarray(sound.any(axis=0))
    ticks = np.arange(values.shape[0])
    for column in range(values.shape[1]):
        if not usable[column]:
            filled[:, column] = 0.0
        elif not sound[:, column].all():
            good = sound[:, column]
            filled[:, column] = np.interp(ticks, ticks[good], values[good, column])
    return filled, usable
