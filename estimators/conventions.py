"""Frames, units, gravity, quaternion order and names: the one source for the whole product.

Units are SI: m, s, rad, rad/s, m/s^2, T. Degrees exist only in names that end in `_deg`.

Quaternions are scalar first (w, x, y, z), unit norm. `q_parent_child` rotates vectors given in the
child frame into the parent frame, so `q_a_c = q_a_b * q_b_c`.

Frames
------
earth
    Right-handed, x east, y (magnetic) north, z up: where the orientation filters live. Without a
    magnetometer the heading of this frame is arbitrary but common to no two sensors.
room
    Right-handed, z up, x where the patient faced during the calibration pose, y to the patient's
    left; origin on the floor below the middle of the hips. `q_room_earth` is a rotation about z only.
sensor
    The axes printed on the device. The accelerometer measures specific force: at rest, level,
    it reads +9.81 m/s^2 on the axis that points up.
segment
    Fixed to a bone. In the anatomical position (standing, arms hanging, palms forward) every segment
    frame coincides with the room frame: x forward, y left, z up. Origin at the proximal joint.

In the N-pose (arms hanging, palms to the thighs, thumbs forward) the right forearm and hand are turned
+90 degrees about z and the left ones -90 degrees; every other segment is as in the anatomical position.
"""

from typing import Final, Literal, get_args

GRAVITY_MPS2: Final = 9.80665
"""Standard gravity. Specific force at rest is `(0, 0, +GRAVITY_MPS2)` in the room frame."""

Placement = Literal[
    "head",
    "sternum",
    "pelvis",
    "shoulder_left",
    "shoulder_right",
    "upper_arm_left",
    "upper_arm_right",
    "forearm_left",
    "forearm_right",
    "hand_left",
    "hand_right",
    "thigh_left",
    "thigh_right",
    "shank_left",
    "shank_right",
    "foot_left",
    "foot_right",
    "heel_left",
    "forefoot_left",
    "heel_right",
    "forefoot_right",
]
"""Where a sensor is worn; also the name of the segment it measures (sternum measures the thorax)."""

ShoePlacement = Literal["heel_left", "forefoot_left", "heel_right", "forefoot_right"]
"""Sensors of an instrumented shoe, under heel and forefoot, inertial and load cell in one.

They measure parts of the foot: the heel frame is the segment `foot` (x to the toes) with its origin in the
sensor, the forefoot frame equals it while the sole is straight. A single sensor on the shoe is `foot_left`
or `foot_right`.
"""

SHOE_PLACEMENTS: Final[tuple[ShoePlacement, ...]] = get_args(ShoePlacement)

PLACEMENTS: Final[tuple[Placement, ...]] = tuple(
    name for name in get_args(Placement) if name not in SHOE_PLACEMENTS
)
"""One sensor a segment; those under the parts of a shoe are `SHOE_PLACEMENTS`."""

Side = Literal["left", "right"]
SIDES: Final[tuple[Side, ...]] = ("left", "right")
