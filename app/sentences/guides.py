"""English sentences of guided calibrations: what a person does, step by step."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "guide_functional.title": "By movement",
    "guide_functional.summary": "Finds the patient's own joint axes, the most accurate calibration. Stand"
    " still, then bend the elbows, turn the palms, and raise the arms forward and sideways.",
    "guide_functional.elbow_flexion_title": "Bend the elbow",
    "guide_functional.elbow_flexion": "With the upper arm hanging, bend the elbow fully and stretch it again,"
    " three times.",
    "guide_functional.pronation_title": "Turn the palm",
    "guide_functional.pronation": "With the elbow bent at the side, turn the palm up and down, three times.",
    "guide_functional.raise_forward_title": "Raise forward",
    "guide_functional.raise_forward": "Raise the straight arm forward to shoulder height and lower it, three"
    " times.",
    "guide_functional.raise_sideways_title": "Raise sideways",
    "guide_functional.raise_sideways": "Raise the straight arm sideways to shoulder height and lower it, three"
    " times.",
    "guide_functional.rest_title": "Stand still",
    "guide_functional.rest": "Stand upright with hanging arms, thumbs forward, for three seconds.",
    "guide_heading_reset.title": "Set the directions",
    "guide_heading_reset.summary": "Sets the directions of a limb again when they have drifted; the"
    " calibration stays. Stand still with hanging arms for two seconds, facing as at the calibration.",
    "guide_heading_reset.pose_title": "Let the arms hang",
    "guide_heading_reset.pose": "Stand upright, facing as at the calibration, arms hanging, palms to the"
    " thighs, and hold still.",
    "guide_magnetometer.title": "Compass",
    "guide_magnetometer.summary": "Finds how iron in the sensor bends the magnetic field. Turn the sensor"
    " slowly in all directions, away from iron.",
    "guide_magnetometer.turn_all_ways_title": "Turn it in all directions",
    "guide_magnetometer.turn_all_ways": "Turn the sensor slowly in all directions, as if painting the inside"
    " of a ball, until every field is filled.",
    "guide_n_pose.title": "Standing pose",
    "guide_n_pose.summary": "Finds how the sensors sit on the body. Stand still with hanging arms for three"
    " seconds.",
    "guide_n_pose.pose_title": "Hold the standing pose",
    "guide_n_pose.pose": "Stand upright, arms hanging, palms to the thighs, thumbs forward, and hold still.",
    "guide_passive.title": "Seated, assisted",
    "guide_passive.summary": "For patients who cannot stand or hold a pose: somebody else moves the arm,"
    " seated. Half the range of the active movements is enough.",
    "guide_passive.elbow_flexion_title": "Bend the elbow for the patient",
    "guide_passive.elbow_flexion": "Bend and stretch the patient's elbow, three times, as far as it goes"
    " without pain.",
    "guide_passive.pronation_title": "Turn the palm for the patient",
    "guide_passive.pronation": "Turn the patient's palm up and down, three times.",
    "guide_passive.raise_forward_title": "Raise the arm forward for the patient",
    "guide_passive.raise_forward": "Raise the patient's arm forward and lower it, three times.",
    "guide_passive.raise_sideways_title": "Raise the arm sideways for the patient",
    "guide_passive.raise_sideways": "Raise the patient's arm sideways and lower it, three times.",
    "guide_passive.rest_title": "Sit still",
    "guide_passive.rest": "Sit upright, upper arm hanging, elbow bent, thumb up, for three seconds; the arm"
    " may lie on a support.",
    "guide_six_position.title": "Six positions",
    "guide_six_position.summary": "Finds scale, zero and axes of a sensor's accelerometer and gyroscope;"
    " needed once for each sensor, and after a fall.",
    "guide_six_position.face_z_up": "Lay the sensor with the printed side up, and let go for two seconds.",
    "guide_six_position.face_z_down": "Lay the sensor with the printed side down, and let go for two seconds.",
    "guide_six_position.face_x_up": "Lay the sensor on its edge, x axis up, and let go for two seconds.",
    "guide_six_position.face_x_down": "Lay the sensor on its edge, x axis down, and let go for two seconds.",
    "guide_six_position.face_y_up": "Lay the sensor on its edge, y axis up, and let go for two seconds.",
    "guide_six_position.face_y_down": "Lay the sensor on its edge, y axis down, and let go for two seconds.",
    "guide_six_position.face_title": "Lay it down",
    "guide_six_position.turn_title": "Turn about {axis}",
    "guide_six_position.turn": "With the {axis} axis up or down, mark where it lies, turn the sensor on the"
    " table by exactly one whole turn, and let it lie still before and after.",
    "guide_static_bias.title": "Gyroscope zero",
    "guide_static_bias.summary": "Finds what the gyroscopes read at rest. Lay all sensors on a table for five"
    " seconds; do it when they have warmed up.",
    "guide_static_bias.rest_title": "Lay the sensors down",
    "guide_static_bias.rest": "Lay every sensor on a table, any way up, and do not touch it.",
    "guide_t_pose.title": "T-pose",
    "guide_t_pose.summary": "As the standing pose, with the arms stretched out to the sides; needs working"
    " compasses.",
    "guide_t_pose.pose_title": "Hold the T-pose",
    "guide_t_pose.pose": "Stand upright, both arms straight out to the sides at shoulder height, palms down,"
    " and hold still.",
}
