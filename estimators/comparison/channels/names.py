"""Names of channels for people, their units, and which angles tell how a limb moves."""

import re
from typing import Final

from estimators.sentences import CATALOGUE

_CHANNEL_NAMES: Final = {
    "plane_of_elevation": "plane_of_elevation",
    "elevation": "elevation",
    "axial_rotation": "axial_rotation",
    "humerus_forearm_flexion": "elbow_flexion",
    "humerus_forearm_carrying": "elbow_carrying",
    "humerus_forearm_pronation": "forearm_pronation",
    "forearm_hand_flexion": "wrist_flexion",
    "forearm_hand_deviation": "wrist_deviation",
    "forearm_hand_rotation": "wrist_rotation",
    "pelvis_thigh_flexion": "hip_flexion",
    "pelvis_thigh_abduction": "hip_abduction",
    "pelvis_thigh_internal_rotation": "hip_rotation",
    "thigh_shank_flexion": "knee_flexion",
    "thigh_shank_abduction": "knee_abduction",
    "thigh_shank_internal_rotation": "knee_rotation",
    "shank_foot_flexion": "ankle_flexion",
    "shank_foot_inversion": "ankle_inversion",
    "shank_foot_internal_rotation": "ankle_rotation",
    "trunk_lean_forward_rad": "trunk_forward_lean",
    "trunk_lean_lateral_rad": "trunk_sideways_lean",
    "trunk_axial_rotation_rad": "trunk_rotation",
}


_FOOT: Final = re.compile(r"(foot_(?:pitch|height|speed))_(?:left|right)_(?:rad|m|mps)")


def foot_channels(side: str) -> tuple[str, str, str]:
    """Return the names of pitch, height and forward speed of a foot that walks; see `foot_trajectory`."""
    return f"foot_pitch_{side}_rad", f"foot_height_{side}_m", f"foot_speed_{side}_mps"


def is_of_stride(channel: str) -> bool:
    """Tell whether a channel is one of a foot over its strides: cycles that begin and end on the floor."""
    return _FOOT.fullmatch(channel) is not None


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
    if is_of_stride(channel):
        return channel[: channel.index("_", len("foot_"))]
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
    words = CATALOGUE.name("channel", channel_name(channel))
    return words[:1].upper() + words[1:]


def channel_unit(channel: str) -> str:
    """Return `m` for positions, heights and hikes, `m/s` for speeds, `rad` for everything else that is compared."""
    if channel.endswith("_mps"):
        return "m/s"
    return "m" if "." in channel or channel.endswith("_m") else "rad"


_TELLING: Final = re.compile(
    r"thorax_humerus_\w+_yxy_elevation|humerus_forearm_\w+_zxy_(flexion|pronation)"
    r"|(pelvis_thigh|thigh_shank|shank_foot)_\w+_zxy_flexion|pelvis_thigh_\w+_zxy_abduction"
)


def tells_movement(channel: str) -> bool:
    """Tell whether a channel is an angle that shows how a limb moves.

    Not so angles with a singularity at rest, those of the wrist, and what a joint hardly does: these are measured and
    judged, but do not say how far a movement has come. All channels of a stride do.
    """
    return _TELLING.fullmatch(channel) is not None or is_of_stride(channel)
