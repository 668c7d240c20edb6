"""Exercises as via-postures of trunk, acting arm and acting leg, in degrees.

Everything is written for a person whose *right* side acts ("acting" and "other" arm and leg); `arm.body` mirrors it
for the left, so a mirrored patient with the same seed makes exactly the mirrored movement.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

ExerciseName = Literal[
    "reaching", "drinking", "abduction", "flexion", "pronation", "knee_extension", "leg_raise"
]

TRUNK_COORDINATES: Final = ("lean_forward", "lean_right", "turn_left")
ARM_COORDINATES: Final = (
    "hike",
    "plane",
    "elevation",
    "axial",
    "flexion",
    "carrying",
    "pronation",
    "wrist_flexion",
    "wrist_deviation",
    "wrist_rotation",
)
LEG_COORDINATES: Final = ("hip_flexion", "hip_abduction", "hip_rotation", "knee_flexion", "ankle_flexion")
UPPER_COORDINATES: Final = (
    *TRUNK_COORDINATES,
    *(f"acting_{name}" for name in ARM_COORDINATES),
    *(f"other_{name}" for name in ARM_COORDINATES),
)
COORDINATES: Final = (
    *UPPER_COORDINATES,
    *(f"acting_{name}" for name in LEG_COORDINATES),
    *(f"other_{name}" for name in LEG_COORDINATES),
)
"""Order of the columns of a posture; radians, hike as the angle of the clavicle, the hip's against the room."""

TRUNK = slice(0, 3)
ACTING = slice(3, 13)
OTHER = slice(13, 23)
ACTING_LEG = slice(23, 28)
OTHER_LEG = slice(28, 33)


@dataclass(frozen=True)
class Stop:
    """A posture of trunk, acting arm and leg (degrees, by coordinate name), how long to get there and to stay."""

    posture_deg: Mapping[str, float]
    move_s: float
    hold_s: float


@dataclass(frozen=True)
class Exercise:
    """Where one repetition starts and ends, and the stops between.

    The other leg stays as it rests. `primary_channel` is the comparison's main angle.
    """

    name: str
    title: str
    rest_deg: Mapping[str, float]
    stops: tuple[Stop, ...]
    return_s: float
    primary_channel: str

    @property
    def moves_leg(self) -> bool:
        """Whether a leg acts."""
        return not set(LEG_COORDINATES).isdisjoint(name for stop in self.stops for name in stop.posture_deg)


_AT_TABLE: Final[dict[str, float]] = {
    "plane": 40,
    "elevation": 20,
    "axial": -40,
    "flexion": 88,
    "pronation": 115,
    "wrist_flexion": -5,
}


def hanging(plane: float) -> dict[str, float]:
    """Return an arm that hangs relaxed, a little off the body, ready to rise in the given plane."""
    return {"plane": plane, "elevation": 8, "axial": -plane, "flexion": 10, "pronation": 92}


EXERCISES: Final[dict[str, Exercise]] = {
    "reaching": Exercise(
        "reaching",
        "Reach forward",
        _AT_TABLE,
        (
            Stop(
                {
                    "plane": 78, "elevation": 76, "axial": -62, "flexion": 22,
                    "carrying": 4, "pronation": 125,
                    "wrist_flexion": -12, "lean_forward": 4,
                },
                1.3,
                0.4,
            ),
        ),
        1.3,
        "humerus_forearm_{side}_zxy_flexion",
    ),
    "drinking": Exercise(
        "drinking",
        "Drink from a cup",
        _AT_TABLE,
        (
            Stop(
                {
                    "plane": 72, "elevation": 48, "axial": -62, "flexion": 52,
                    "carrying": 3, "pronation": 100,
                    "wrist_flexion": -15, "lean_forward": 2,
                },
                1.1,
                0.3,
            ),
            Stop(
                {
                    "plane": 60, "elevation": 52, "axial": -36, "flexion": 137, "pronation": 88,
                    "wrist_flexion": 10, "wrist_deviation": 5, "lean_forward": 3,
                },
                1.2,
                0.8,
            ),
            Stop(
                {
                    "plane": 72, "elevation": 48, "axial": -62, "flexion": 52,
                    "carrying": 3, "pronation": 100,
                    "wrist_flexion": -15, "lean_forward": 2,
                },
                1.2,
                0.3,
            ),
        ),
        1.1,
        "humerus_forearm_{side}_zxy_flexion",
    ),
    "abduction": Exercise(
        "abduction",
        "Raise the arm to the side",
        hanging(12),
        (
            Stop(
                {
                    "plane": 14, "elevation": 105, "axial": -35, "flexion": 6,
                    "pronation": 70, "lean_right": -1,
                },
                1.9,
                0.5,
            ),
        ),
        1.9,
        "thorax_humerus_{side}_yxy_elevation",
    ),
    "flexion": Exercise(
        "flexion",
        "Raise the arm to the front",
        hanging(82),
        (
            Stop(
                {
                    "plane": 84, "elevation": 130, "axial": -84, "flexion": 6,
                    "pronation": 85, "lean_forward": -1,
                },
                1.9,
                0.5,
            ),
        ),
        1.9,
        "thorax_humerus_{side}_yxy_elevation",
    ),
    "pronation": Exercise(
        "pronation",
        "Turn the palm up and down",
        _AT_TABLE | {"pronation": 90},
        (
            Stop(_AT_TABLE | {"pronation": 15}, 1.0, 0.3),
            Stop(_AT_TABLE | {"pronation": 155}, 1.6, 0.3),
        ),
        1.0,
        "humerus_forearm_{side}_zxy_pronation",
    ),
}  # fmt: skip

_SEATED: Final = hanging(30.0) | {"hip_flexion": 80, "knee_flexion": 85}

LEG_EXERCISES: Final[dict[str, Exercise]] = {
    "knee_extension": Exercise(
        "knee_extension",
        "Straighten the knee, seated",
        _SEATED,
        (Stop(_SEATED | {"hip_flexion": 82, "knee_flexion": 12, "ankle_flexion": 10}, 1.4, 0.5),),
        1.4,
        "thigh_shank_{side}_zxy_flexion",
    ),
    "leg_raise": Exercise(
        "leg_raise",
        "Raise the leg to the side, standing",
        hanging(30.0),
        (Stop(hanging(30.0) | {"hip_abduction": 32, "hip_rotation": -4, "knee_flexion": 3}, 1.3, 0.3),),
        1.3,
        "pelvis_thigh_{side}_zxy_abduction",
    ),
}
"""Exercises of a leg; the hips stay where they are when somebody sits down."""
