"""The result of a calibration; below the pipelines, which carry it in their setup."""

from dataclasses import dataclass, field

from estimators.conventions import Placement

UNUSABLE_SCORE = 0.25
"""A calibration that scores less is refused instead of being put in force."""


@dataclass(frozen=True)
class Calibration:
    """How each sensor sits on its segment, and the constants found while standing still.

    Attributes
    ----------
    q_sensor_segment : dict of placement to (w, x, y, z)
        Orientation of the segment frame in the sensor frame: `q_room_segment = q_room_earth *
        q_earth_sensor * q_sensor_segment`.
        Empty while only biases are known (method `level`).
    gyroscope_bias_radps : dict of placement to (x, y, z)
    accelerometer_bias_mps2 : dict of placement to (x, y, z)
        Subtracted before estimation; empty when nothing is known. From `level` all three axes, from an
        N-pose only the component along gravity.
    facing_rad : float
        Heading of the patient's forward direction in the earth frame, counter-clockwise from x;
        `q_room_earth` is the rotation about z by `-facing_rad`.
    heading_offset_rad : dict of placement to float
        Added per sensor when headings share no reference (no magnetometer): rotation about z that
        brings the sensor's own earth frame to the common one.
    score : float
        0 (redo) to 1 (as good as it gets).
    reasons : tuple of str
        What lowered the score and what to do, in plain words.
    unknown_headings : tuple of placement
        Sensors whose heading nothing has shown yet in this session: their mounting is remembered from an earlier
        one. A pose or a heading reset tells it; until then angles with them mean nothing.
    mounting_sigma_rad : dict of placement to (x, y, z)
        One-sigma of `q_sensor_segment` about the segment's axes, against the pose as it was asked for: how well the
        sensor knew its own orientation, and how well people put it on where its heading was only assumed. How far
        a person's pose is from the one asked for is not in it. Empty where nothing is known.
    contradicted : tuple of placement
        Sensors whose mounting the movements that followed contradict: what they give is flagged as unknown.
    """

    q_sensor_segment: dict[Placement, tuple[float, float, float, float]]
    gyroscope_bias_radps: dict[Placement, tuple[float, float, float]]
    facing_rad: float = 0.0
    heading_offset_rad: dict[Placement, float] = field(default_factory=dict)
    method: str = "n_pose"
    score: float = 1.0
    reasons: tuple[str, ...] = ()
    accelerometer_bias_mps2: dict[Placement, tuple[float, float, float]] = field(default_factory=dict)
    unknown_headings: tuple[Placement, ...] = ()
    mounting_sigma_rad: dict[Placement, tuple[float, float, float]] = field(default_factory=dict)
    contradicted: tuple[Placement, ...] = ()
