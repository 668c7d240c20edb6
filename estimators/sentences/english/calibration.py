"""English sentences of calibration by pose, rest and movement, and of how sensors sit."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "calibration.same_signals": "The sensors on the {where:place} send the same signal, down to the noise: one sensor"
    " comes under several names. Check how the sensor box assigns its sensors to the body, then calibrate again.",
    "calibration.not_checked": "Not checked by a movement yet: only a calibration by movement shows whether the"
    " sensors turn as the body does.",
    "calibration.too_few_samples": "{where:place}: only {samples:number} usable samples arrived. Rest for at least"
    " {least_s:s}, with a steady signal.",
    "calibration.moved": "{where:place}: movement during the rest. Put everything down or stand still, and repeat.",
    "calibration.turned_steadily": "{where:place}: steady turning at more than {limit_radps:degps}. Keep still and"
    " repeat.",
    "calibration.unusual_zero": "{where:place}: the gyroscope reads more than {limit_radps:degps} at rest. Either it"
    " turned slowly, or it is a poor gyroscope: lay the sensor on a table that does not move and find the gyroscope"
    " zero.",
    "calibration.no_data": "{where:place}: no data from the sensor during the pose. Check that it is on and near,"
    " and repeat.",
    "calibration.pose_moved": "{where:place}: the sensor moved by {angle_rad:deg}. Stand still with hanging arms and"
    " repeat.",
    "calibration.seat_moved": "{where:place}: the sensor moved by {angle_rad:deg}. Sit still and repeat.",
    "calibration.swayed": "{where:place}: the sensor swayed. Stand still and repeat.",
    "calibration.level_arms": "The sensors on the arms have no compass, and arms that are held level do not show the"
    " direction. Hold the standing pose with hanging arms instead.",
    "calibration.flat_no_compass": "{where:place}: the sensor lies flat and has no compass, so its direction cannot"
    " be found. Turn its printed side away from the body and repeat.",
    "calibration.flat": "{where:place}: the sensor lies flat. Turn its printed side away from the body.",
    "calibration.put_on": "{where:place}: without a compass the direction is taken from how the sensor is put on,"
    " accurate to ±{sigma_rad:deg} at best. Calibrate by movement to measure it.",
    "calibration.pose_unusable": "This pose cannot be used. {reasons:lines}",
    "calibration.was_moving": "{where:place}: the sensor was moving. Stand still with hanging arms and repeat.",
    "calibration.not_still": "{where:place}: the sensor was not still. Repeat the pose.",
    "calibration.gravity_fault": "{where:place}: the accelerometer reads {error:percent} off gravity at rest. Check"
    " its unit and range, or replace the sensor.",
    "calibration.gravity_off": "{where:place}: the accelerometer is {error:percent} off. Calibrate it.",
    "calibration.not_settled": "{where:place}: the sensor has not settled ({angle_rad:deg} off gravity). Wait 3 s in"
    " the pose and repeat.",
    "calibration.iron_near": "{where:place}: iron or a magnet is near. Move away from it and repeat.",
    "calibration.just_started": "{where:place}: measuring had only just begun. Wait 3 s and repeat.",
    "calibration.at_limit": "{where:place}: readings were at the limit of the range while standing. Check the range.",
    "calibration.facing_unknown": "It is not known where the patient faces, because the sensors on the {where:place}"
    " lie flat. Turn the printed side of one of them away from the body and repeat.",
    "calibration.facing_by_other": "{where:place}: the sensor lies flat. Where the patient faces was measured on the"
    " {by:place} instead.",
    "calibration.nearly_flat": "{where:place}: the sensor lies nearly flat. Put it on upright.",
    "calibration.faces_away": "{where:place}: the other sensors face {angle_rad:deg} away from this one. If their"
    " printed sides face outward, check this one.",
    "calibration.rest_missing": "The moment of rest is missing. Keep still for 3 s before the movements.",
    "calibration.no_arm_moved": "No arm with sensors on upper arm and forearm made the movements. Bend the elbow and"
    " turn the palm, then repeat.",
    "calibration.contradiction": "Rest and movements of the {side:side} arm contradict each other by"
    " {angle_rad:deg}. Start with a hanging arm and repeat.",
    "calibration.movements_unusable": "These movements cannot be used. {reasons:lines}",
    "calibration.movement_missing": "A movement of the {side:side} arm is missing: {kind:movement}. Repeat with this"
    " movement.",
    "calibration.swung": "The {side:side} arm swung round instead of rising. Move it straight up and down:"
    " {kind:movement}.",
    "calibration.raises_apart": "The arms were raised in directions that do not fit together. Raise them straight"
    " forward and straight sideways, and repeat.",
    "calibration.arm_no_compass": "The {side:side} arm has no compass, so a movement must show its direction. Raise"
    " the arm forward, then repeat.",
    "calibration.compasses_apart": "The compasses on the {where:place} differ by {angle_rad:deg}. Go away from iron,"
    " calibrate them, and repeat.",
    "calibration.movement_small": "The {side:side} arm moved by {angle_rad:deg} only: {kind:movement}. Move it by at"
    " least {least_rad:deg} and repeat.",
    "calibration.hardly_moved": "The {side:side} arm hardly moved: {kind:movement}. Move it further and repeat.",
    "calibration.uncertain": "{where:place}: the direction of the sensor is uncertain by {sigma_rad:deg}. Larger"
    " movements measure it better.",
    "calibration.not_raised": "The arms were not raised, so where the patient faces is taken from how the sensors"
    " are put on.",
    "calibration.faces_backward": "{where:place}: the sensor faces backward. That is allowed here, but check that it"
    " is the right one.",
    "calibration.elbow_hardly_bent": "The {side:side} elbow was hardly bent, so how its sensors face is taken from"
    " how they are put on. Bend it a few times in a recording.",
    "calibration.elbow_uncertain": "{side:side} arm: how its sensors face is taken from how they are put on; bending"
    " the elbow measured it only to {sigma_rad:deg}.",
    "calibration.elbow_measured": "{side:side} arm: how its sensors face was measured by bending the elbow, to about"
    " {sigma_rad:deg}.",
    "calibration.movements_tell_nothing": "These movements cannot calibrate every sensor: {where:place}. Take that"
    " sensor off, or calibrate both arms.",
    "calibration.reset_needs_one": "Directions can be set anew only after a calibration. Hold the standing pose.",
    "calibration.not_worn": "No sensor is worn on the {where:place}.",
    "calibration.off_pose": "{where:place}: the sensor is {angle_rad:deg} off the standing pose. Let the arms hang,"
    " palms to the thighs, and repeat.",
    "calibration.not_level": "A sensor does not lie level with its printed side up. Put all on a level table and"
    " repeat.",
    "calibration.forgotten": "The pose was more than {memory_s:s} ago. Hold it again for 3 s.",
    "calibration.other_sensors": "{where:place}: the calibration does not cover this sensor. Calibrate again with"
    " all sensors on.",
    "calibration.no_rest_found": "There is no moment of 1.5 s in which all sensors are still. Record the calibration"
    " pose, standing still with hanging arms for 3 s, or say when it was held.",
    "calibration.pose_outside": "The pose from {start_s:s.1} to {stop_s:s.1} is not in the recording.",
    "calibration.no_joints": "These sensors measure no joint, so there is nothing to calibrate by movement.",
    "calibration.no_directions": "In this kind of session the directions are not set by a pose.",
    "calibration.no_devices": "Single sensors cannot be calibrated in this kind of session.",
    "calibration.walk_needs_none": "A walk needs no calibration pose. Stand still for a second, then walk.",
    "calibration.magnetic_needs_none": "A session with a magnetic source needs no calibration pose. Stand still for"
    " three seconds.",
    "calibration.single_sensors": "Single sensors have no pose. Lay them down and find their gyroscope zero instead.",
    "calibration.knee_hardly_moved": "The knee hardly moved. Bend and stretch it five times, briskly.",
    "calibration.leg_two_axes": "The leg turned about more than one axis. Bend the knee without turning the foot.",
    "calibration.leg_twisted": "The leg turned about its long axis. Bend the knee, do not twist the leg.",
    "placement.segments_swapped": "The sensors on the {where:place} are swapped. Put each where it belongs and repeat.",
    "placement.arms_swapped": "The sensors of the left and the right arm are swapped. Put each where it belongs and"
    " repeat.",
    "placement.wrong_arm": "The sensors named {side:side} arm moved as those of the other arm do. Check the side and"
    " repeat.",
    "placement.twins_swapped": "The sensors on the {where:place} are swapped, or the printed sides of both face the"
    " body. Check them.",
    "placement.half_turn": "{where:place}: the sensor is turned by half a turn, its printed side to the body. The"
    " calibration allows for it, but check that it is the right sensor.",
    "placement.half_turn_since": "{where:place}: the sensor is turned by half a turn since last time. That is"
    " allowed, but check that it is the right sensor.",
    "placement.back_to_front": "{where:place}: the sensor was worn back to front, because joints bent the wrong"
    " way. The direction it gave was turned by half a turn, and the angles are computed with that.",
    "placement.faced_away": "{where:place}: the sensor faced {angle_rad:deg} off the direction that was assumed."
    " Where the patient faced is taken from how the joints bent, to about {sigma_rad:deg}. Calibrate by movement to"
    " measure it.",
    "placement.elbow_impossible": "The {side:side} elbow read {angle_rad:deg}, which is not possible. Either the"
    " arm did not hang straight in the calibration pose (elbows bent while seated, for instance), or a sensor is"
    " back to front: {where:place}. The angles of this arm are not given. Calibrate again standing with hanging"
    " arms, or by movement.",
    "placement.knee_impossible": "The {side:side} knee read {angle_rad:deg}, which is not possible. Either the leg"
    " was not straight in the calibration pose (the patient sat, for instance), or a sensor is back to front:"
    " {where:place}. The angles of this leg are not given. Calibrate again standing upright.",
    "placement.arm_behind": "The {side:side} arm seemed to rise behind the back or through the trunk, which is not"
    " possible. Either a sensor is back to front, or sensors of both sides are swapped: {where:place}. The angles"
    " of this arm are not given. Check the sensors, then calibrate again.",
    "placement.arm_unclear": "{side:side} arm: bending the elbow says that a sensor sits {angle_rad:deg} off how it"
    " should be put on, or that the arm did not hang straight in the calibration pose: {where:place}. The angles of"
    " this arm are not given. Put the sensors on with the printed side outward, and calibrate again standing with"
    " hanging arms, or by movement.",
    "placement.trunk_backward": "{where:place}: the trunk seemed to lean back from the hanging arms further than"
    " shoulders can. The sensor is probably back to front. The angles of trunk and shoulders are not given. Turn"
    " its printed side forward, then calibrate again.",
    "placement.bent_aside": "A joint of the {side:side} side seemed to bend {angle_rad:deg} off the way it can. A"
    " sensor's printed side may not face outward: {where:place}. The angles of this limb are not given. Check the"
    " sensors, then calibrate again, or by movement.",
    "placement.moved_since": "{where:place}: the sensor sits {angle_rad:deg} off its position of last time.",
}
