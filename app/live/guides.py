"""What a person does in each kind of calibration, step by step; pictures are drawn by the browser."""

from typing import Final

from app.live.calibration_messages import CalibrationGuide, CalibrationKind, CalibrationStep, Picture


def _step(
    key: str, title: str, instruction: str, picture: Picture, *, itself: bool = True
) -> CalibrationStep:
    return CalibrationStep(
        key=key,
        title=title,
        instruction=instruction,
        picture=picture,
        ends="itself" if itself else "next",
    )


_FACES: Final[tuple[tuple[str, Picture, str], ...]] = (
    ("face_z_up", "face_z_up", "with the printed side up"),
    ("face_z_down", "face_z_down", "with the printed side down"),
    ("face_x_up", "face_x_up", "on its edge, x axis up"),
    ("face_x_down", "face_x_down", "on its edge, x axis down"),
    ("face_y_up", "face_y_up", "on its edge, y axis up"),
    ("face_y_down", "face_y_down", "on its edge, y axis down"),
)
_TURNS: Final[tuple[tuple[str, Picture, str], ...]] = (
    ("turn_x", "turn_x", "x"),
    ("turn_y", "turn_y", "y"),
    ("turn_z", "turn_z", "z"),
)
_REST = _step(
    "rest",
    "Stand still",
    "Stand upright with hanging arms, thumbs forward, for three seconds.",
    "n_pose",
)
_SEATED = _step(
    "rest",
    "Sit still",
    "Sit upright, upper arm hanging, elbow bent, thumb up, for three seconds; the arm may lie on a support.",
    "seated_rest",
)

GUIDES: Final[dict[CalibrationKind, CalibrationGuide]] = {
    guide.kind: guide
    for guide in (
        CalibrationGuide(
            kind="static_bias",
            title="Rest of the gyroscopes",
            summary="Finds what the gyroscopes read at rest. Lay all sensors on a table for five seconds; do it when"
            " they have warmed up.",
            worn=False,
            one_sensor=False,
            steps=[
                _step(
                    "rest",
                    "Lay the sensors down",
                    "Lay every sensor on a table, any way up, and do not touch it.",
                    "lie_still",
                )
            ],
        ),
        CalibrationGuide(
            kind="six_position",
            title="Six positions",
            summary="Finds scale, bias and axes of accelerometer and gyroscope of a sensor; once a device, and after a"
            " fall.",
            worn=False,
            one_sensor=True,
            steps=[
                *(
                    _step(key, "Lay it down", f"Lay the sensor {how}, and let go for two seconds.", picture)
                    for key, picture, how in _FACES
                ),
                *(
                    _step(
                        key,
                        f"Turn about {axis}",
                        f"With the {axis} axis up or down, mark where it lies, turn the sensor on the table by"
                        " exactly one whole turn, and let it lie still before and after.",
                        picture,
                    )
                    for key, picture, axis in _TURNS
                ),
            ],
        ),
        CalibrationGuide(
            kind="magnetometer",
            title="Compass",
            summary="Finds how iron in the sensor bends the magnetic field. Turn the sensor slowly in all directions,"
            " away from iron.",
            worn=False,
            one_sensor=True,
            steps=[
                _step(
                    "turn_all_ways",
                    "Turn it in all directions",
                    "Turn the sensor slowly in all directions, as if painting the inside of a ball, until every"
                    " field is filled.",
                    "turn_all_ways",
                )
            ],
        ),
        CalibrationGuide(
            kind="n_pose",
            title="Standing pose",
            summary="Finds how the sensors sit on the body. Stand still with hanging arms for three seconds.",
            worn=True,
            one_sensor=False,
            steps=[
                _step(
                    "pose",
                    "Hold the N-pose",
                    "Stand upright, arms hanging, palms to the thighs, thumbs forward, and hold still.",
                    "n_pose",
                )
            ],
        ),
        CalibrationGuide(
            kind="t_pose",
            title="T-pose",
            summary="As the standing pose, with the arms stretched out to the sides; needs working compasses.",
            worn=True,
            one_sensor=False,
            steps=[
                _step(
                    "pose",
                    "Hold the T-pose",
                    "Stand upright, both arms straight out to the sides at shoulder height, palms down, and hold"
                    " still.",
                    "t_pose",
                )
            ],
        ),
        CalibrationGuide(
            kind="functional",
            title="By movement",
            summary="Finds the patient's own joint axes, the most exact choice. Stand still, then bend the elbows, turn"
            " the palms, and raise the arms forward and sideways.",
            worn=True,
            one_sensor=False,
            steps=[
                _REST,
                _step(
                    "elbow_flexion",
                    "Bend the elbow",
                    "With the upper arm hanging, bend the elbow fully and stretch it again, three times.",
                    "elbow_flexion",
                    itself=False,
                ),
                _step(
                    "pronation",
                    "Turn the palm",
                    "With the elbow bent at the side, turn the palm up and down, three times.",
                    "pronation",
                    itself=False,
                ),
                _step(
                    "raise_forward",
                    "Raise forward",
                    "Raise the straight arm forward to shoulder height and lower it, three times.",
                    "raise_forward",
                    itself=False,
                ),
                _step(
                    "raise_sideways",
                    "Raise sideways",
                    "Raise the straight arm sideways to shoulder height and lower it, three times.",
                    "raise_sideways",
                    itself=False,
                ),
            ],
        ),
        CalibrationGuide(
            kind="passive",
            title="Seated, assisted",
            summary="For patients who cannot stand or hold a pose: somebody else moves the arm, seated. Half the range"
            " of the active movements is enough.",
            worn=True,
            one_sensor=False,
            steps=[
                _SEATED,
                _step(
                    "elbow_flexion",
                    "Bend the elbow for the patient",
                    "Bend and stretch the patient's elbow, three times, as far as it goes without pain.",
                    "seated_elbow_flexion",
                    itself=False,
                ),
                _step(
                    "pronation",
                    "Turn the palm for the patient",
                    "Turn the patient's palm up and down, three times.",
                    "seated_pronation",
                    itself=False,
                ),
                _step(
                    "raise_forward",
                    "Raise the arm forward for the patient",
                    "Raise the patient's arm forward and lower it, three times.",
                    "seated_raise_forward",
                    itself=False,
                ),
                _step(
                    "raise_sideways",
                    "Raise the arm sideways for the patient",
                    "Raise the patient's arm sideways and lower it, three times.",
                    "seated_raise_sideways",
                    itself=False,
                ),
            ],
        ),
        CalibrationGuide(
            kind="heading_reset",
            title="Set headings anew",
            summary="Sets the heading of a limb anew when it has drifted; the calibration stays. Stand still with"
            " hanging arms for two seconds, facing as at the calibration.",
            worn=True,
            one_sensor=False,
            steps=[
                _step(
                    "pose",
                    "Let the arms hang",
                    "Stand upright, facing as at the calibration, arms hanging, palms to the thighs, and hold still.",
                    "arm_hanging",
                )
            ],
        ),
    )
}

__all__ = ["GUIDES"]
