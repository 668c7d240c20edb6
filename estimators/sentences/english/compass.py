"""English sentences of calibrating single sensors in the hand: compass and six positions."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "compass.begin": "Turn the sensor slowly in all directions, as if painting the inside of a ball.",
    "compass.hardly_turned": "The sensor was hardly turned. Turn it slowly in all directions and repeat.",
    "compass.few_directions": "Only {coverage:percent} of the directions were covered. {hint}",
    "compass.not_uniform": "The magnetic field is not uniform here ({residual:percent} off). Go away from iron,"
    " magnets and loudspeakers, turn the sensor on the spot, and repeat.",
    "compass.axes_turned": "The axes of the magnetometer are turned by {angle_rad:deg} against those of the"
    " accelerometer. Check the axes of both.",
    "compass.heading_unknown": "The direction would still be uncertain by {sigma_rad:deg}. {hint}",
    "compass.heading_uncertain": "The direction is uncertain by {sigma_rad:deg.1}. {hint}",
    "compass.hard_iron_only": "Only {coverage:percent} of the directions were covered, so only the hard iron was"
    " found. {hint}",
    "compass.norm_varies": "The strength of the field still varies by {residual:percent}. Repeat away from iron and"
    " magnets.",
    "compass.unusable": "This compass calibration cannot be used. {reasons:lines}",
    "compass.all_visited": "All directions were covered.",
    "compass.next_turn": "Turn the sensor so that its {axis} axis points north and down, and swing it about there.",
    "compass.tilted": "The sensor was tilted while it turned. Hold it level, turn it about the vertical, and repeat.",
    "compass.few_samples": "Only {samples:number} samples arrived. Make two full turns of at least 5 s and repeat.",
    "compass.field_constant": "The magnetic field hardly changed. Turn the sensor about the vertical by two full"
    " turns, away from iron.",
    "compass.part_of_turn": "Only {angle_rad:deg} of a whole turn were seen. Make two full turns and repeat.",
    "compass.level_turns_only": "Level turns find the hard iron only across the vertical. Turn the sensor in all"
    " directions.",
    "compass.circle_off": "The readings are {residual:percent} off a circle. Repeat away from iron and magnets.",
    "compass.no_data": "The magnetometer gave no data. Check that it is switched on.",
    "compass.norm_implausible": "The magnetic field here is {norm_t:ut}; the earth's is {low_t:ut} to {high_t:ut}."
    " Go away from iron, magnets and loudspeakers, and calibrate again.",
    "compass.points_up": "The magnetic field points up by {angle_rad:deg}; on the northern half of the earth it"
    " points down. Go away from iron, or check the signs of the sensor.",
    "compass.points_down": "The magnetic field points down by {angle_rad:deg}; on the southern half of the earth it"
    " points up. Go away from iron, or check the signs of the sensor.",
    "compass.hardly_level": "The horizontal part of the magnetic field is only {level_t:ut}. Directions by the compass"
    " will be uncertain here.",
    "compass.odd_field": "This sensor saw another magnetic field than the others ({norm_t:ut} against"
    " {others_t:ut}). Calibrate it again, away from iron.",
    "compass.odd_dip": "This sensor saw another magnetic field than the others ({norm_t:ut}, dip {dip_rad:deg},"
    " against {others_t:ut}, dip {others_dip_rad:deg}). Calibrate it again, away from iron.",
    "six_position.gap": "The part from {start_s:s.1} to {stop_s:s.1} is not all there. Repeat that part.",
    "six_position.rest_missing": "Lay the sensor still for 2 s with {faces:and} pointing up (within 25°).",
    "six_position.turn_missing": "Turn it by exactly one full turn about {axes:and}, and let it lie still for 1 s"
    " before and after on the same side.",
    "six_position.incomplete": "The six-position calibration is not complete. {wanted:lines}",
    "six_position.correction": "The {triad:triad} would need a correction of {correction:percent}. Check its unit,"
    " range and axes, and that every turn was a full one, then repeat.",
    "six_position.contradict": "The positions contradict each other by {residual_mps2:mps2.2}. Use a level table and"
    " lay the sensor flat on each side.",
    "six_position.not_square": "The sides are {angle_rad:deg.1} off a right angle. Hold the sensor against something"
    " square and repeat.",
    "six_position.unusable": "These six positions cannot be used. {reasons:lines}",
    "six_position.turn_over": "The turn about {axis} read {error:percent.1} too much, so it was hardly a whole one.",
    "six_position.turn_under": "The turn about {axis} read {error:percent.1} too little, so it was hardly a whole"
    " one.",
    "six_position.turn_again": "{turns:lines} Mark the table and the sensor, turn it by exactly one turn, and"
    " repeat. If it was whole, turn it twice more: two turns that agree are accepted.",
    "six_position.turn_doubt_over": "The turn about {axis} read {error:percent.1} too much: by the gyroscope's"
    " scale, or because it was not quite whole. A second turn about it shows which.",
    "six_position.turn_doubt_under": "The turn about {axis} read {error:percent.1} too little: by the gyroscope's"
    " scale, or because it was not quite whole. A second turn about it shows which.",
}
