"""Steps of a person in each kind of calibration; pictures are drawn by the browser."""

from typing import Final

from app.live.calibration.messages import CalibrationGuide, CalibrationKind, CalibrationStep, Picture
from estimators.sentences import Sentence, say


def _step(
    key: str, title: Sentence, instruction: Sentence, picture: Picture, *, itself: bool = True
) -> CalibrationStep:
    return CalibrationStep(
        key=key,
        title=title,
        instruction=instruction,
        picture=picture,
        ends="itself" if itself else "next",
    )


_FACES: Final[tuple[tuple[str, Picture, Sentence], ...]] = (
    ("face_z_up", "face_z_up", say("guide_six_position.face_z_up")),
    ("face_z_down", "face_z_down", say("guide_six_position.face_z_down")),
    ("face_x_up", "face_x_up", say("guide_six_position.face_x_up")),
    ("face_x_down", "face_x_down", say("guide_six_position.face_x_down")),
    ("face_y_up", "face_y_up", say("guide_six_position.face_y_up")),
    ("face_y_down", "face_y_down", say("guide_six_position.face_y_down")),
)
_TURNS: Final[tuple[tuple[str, Picture, str], ...]] = (
    ("turn_x", "turn_x", "x"),
    ("turn_y", "turn_y", "y"),
    ("turn_z", "turn_z", "z"),
)
_REST = _step(
    "rest",
    say("guide_functional.rest_title"),
    say("guide_functional.rest"),
    "n_pose",
)
_SEATED = _step(
    "rest",
    say("guide_passive.rest_title"),
    say("guide_passive.rest"),
    "seated_rest",
)

GUIDES: Final[dict[CalibrationKind, CalibrationGuide]] = {
    guide.kind: guide
    for guide in (
        CalibrationGuide(
            kind="static_bias",
            title=say("guide_static_bias.title"),
            summary=say("guide_static_bias.summary"),
            worn=False,
            one_sensor=False,
            steps=[
                _step(
                    "rest",
                    say("guide_static_bias.rest_title"),
                    say("guide_static_bias.rest"),
                    "lie_still",
                )
            ],
        ),
        CalibrationGuide(
            kind="six_position",
            title=say("guide_six_position.title"),
            summary=say("guide_six_position.summary"),
            worn=False,
            one_sensor=True,
            steps=[
                *(
                    _step(key, say("guide_six_position.face_title"), instruction, picture)
                    for key, picture, instruction in _FACES
                ),
                *(
                    _step(
                        key,
                        say("guide_six_position.turn_title", axis=axis),
                        say("guide_six_position.turn", axis=axis),
                        picture,
                    )
                    for key, picture, axis in _TURNS
                ),
            ],
        ),
        CalibrationGuide(
            kind="magnetometer",
            title=say("guide_magnetometer.title"),
            summary=say("guide_magnetometer.summary"),
            worn=False,
            one_sensor=True,
            steps=[
                _step(
                    "turn_all_ways",
                    say("guide_magnetometer.turn_all_ways_title"),
                    say("guide_magnetometer.turn_all_ways"),
                    "turn_all_ways",
                )
            ],
        ),
        CalibrationGuide(
            kind="n_pose",
            title=say("guide_n_pose.title"),
            summary=say("guide_n_pose.summary"),
            worn=True,
            one_sensor=False,
            steps=[
                _step(
                    "pose",
                    say("guide_n_pose.pose_title"),
                    say("guide_n_pose.pose"),
                    "n_pose",
                )
            ],
        ),
        CalibrationGuide(
            kind="t_pose",
            title=say("guide_t_pose.title"),
            summary=say("guide_t_pose.summary"),
            worn=True,
            one_sensor=False,
            steps=[
                _step(
                    "pose",
                    say("guide_t_pose.pose_title"),
                    say("guide_t_pose.pose"),
                    "t_pose",
                )
            ],
        ),
        CalibrationGuide(
            kind="functional",
            title=say("guide_functional.title"),
            summary=say("guide_functional.summary"),
            worn=True,
            one_sensor=False,
            steps=[
                _REST,
                _step(
                    "elbow_flexion",
                    say("guide_functional.elbow_flexion_title"),
                    say("guide_functional.elbow_flexion"),
                    "elbow_flexion",
                    itself=False,
                ),
                _step(
                    "pronation",
                    say("guide_functional.pronation_title"),
                    say("guide_functional.pronation"),
                    "pronation",
                    itself=False,
                ),
                _step(
                    "raise_forward",
                    say("guide_functional.raise_forward_title"),
                    say("guide_functional.raise_forward"),
                    "raise_forward",
                    itself=False,
                ),
                _step(
                    "raise_sideways",
                    say("guide_functional.raise_sideways_title"),
                    say("guide_functional.raise_sideways"),
                    "raise_sideways",
                    itself=False,
                ),
            ],
        ),
        CalibrationGuide(
            kind="passive",
            title=say("guide_passive.title"),
            summary=say("guide_passive.summary"),
            worn=True,
            one_sensor=False,
            steps=[
                _SEATED,
                _step(
                    "elbow_flexion",
                    say("guide_passive.elbow_flexion_title"),
                    say("guide_passive.elbow_flexion"),
                    "seated_elbow_flexion",
                    itself=False,
                ),
                _step(
                    "pronation",
                    say("guide_passive.pronation_title"),
                    say("guide_passive.pronation"),
                    "seated_pronation",
                    itself=False,
                ),
                _step(
                    "raise_forward",
                    say("guide_passive.raise_forward_title"),
                    say("guide_passive.raise_forward"),
                    "seated_raise_forward",
                    itself=False,
                ),
                _step(
                    "raise_sideways",
                    say("guide_passive.raise_sideways_title"),
                    say("guide_passive.raise_sideways"),
                    "seated_raise_sideways",
                    itself=False,
                ),
            ],
        ),
        CalibrationGuide(
            kind="heading_reset",
            title=say("guide_heading_reset.title"),
            summary=say("guide_heading_reset.summary"),
            worn=True,
            one_sensor=False,
            steps=[
                _step(
                    "pose",
                    say("guide_heading_reset.pose_title"),
                    say("guide_heading_reset.pose"),
                    "arm_hanging",
                )
            ],
        ),
    )
}
