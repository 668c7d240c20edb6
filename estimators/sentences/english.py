"""English words of the library. The first part of a code is the room, or the kind of names that places refer to."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "text.lines": "{lines:lines}",
    "place.head": "head",
    "place.sternum": "chest",
    "place.pelvis": "pelvis",
    "place.shoulder_left": "left shoulder",
    "place.shoulder_right": "right shoulder",
    "place.upper_arm_left": "left upper arm",
    "place.upper_arm_right": "right upper arm",
    "place.forearm_left": "left forearm",
    "place.forearm_right": "right forearm",
    "place.hand_left": "left hand",
    "place.hand_right": "right hand",
    "place.thigh_left": "left thigh",
    "place.thigh_right": "right thigh",
    "place.shank_left": "left shank",
    "place.shank_right": "right shank",
    "place.foot_left": "left foot",
    "place.foot_right": "right foot",
    "place.heel_left": "left heel",
    "place.forefoot_left": "left forefoot",
    "place.heel_right": "right heel",
    "place.forefoot_right": "right forefoot",
    "calibration.same_signals": "The sensors on {where:place} send the same signal, down to the noise: one sensor comes"
    " under several names. Check how the gateway assigns its sensors to the body, then calibrate again.",
    "calibration.not_checked": "Not checked by a movement yet: a calibration by movement tells whether the sensors turn"
    " as the body does.",
    "side.left": "left",
    "side.right": "right",
}

__all__ = ["ENGLISH"]
