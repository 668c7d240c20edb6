"""English sentences about readings that cannot be right: units, axes, signs, dead and clipped channels."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "readings.more": {
        "one": "One more was found.",
        "other": "{count} more were found.",
    },
    "readings.no_data": "{where:place}: hardly any samples arrive. Check that the sensor is on and near.",
    "readings.accelerometer_dead": "{where:place}: the accelerometer never changes. Replace the sensor or check its"
    " wiring.",
    "readings.accelerometer_clipped": "{where:place}: the accelerometer stops at {level_mps2:mps2}. Choose a larger"
    " range.",
    "readings.accelerometer_uncalibrated": "{where:place}: the accelerometer has an offset or a scale error that tilts"
    " the readings by about {angle_rad:deg.1}. It was never calibrated, or its calibration was not applied. Calibrate"
    " it in six positions.",
    "readings.accelerometer_corrected": "{where:place}: offset and scale error of the accelerometer were found from the"
    " movement and taken off; as recorded, the sensor would lean by about {angle_rad:deg.1}. What stays unknown,"
    " {sigma_rad:deg.1}, is in the stated uncertainty. Calibrate it in six positions to measure better.",
    "readings.accelerometer_unit": "{where:place}: the accelerometer reads {value:number~4} at rest where 9.81 m/s²"
    " is expected. {remedy}",
    "readings.force_without_gravity": "The device removes gravity: switch it to raw acceleration.",
    "readings.force_in_g": "This looks like g: multiply by 9.80665.",
    "readings.force_in_feet": "This looks like ft/s²: multiply by 0.3048.",
    "readings.force_in_milli_g": "This looks like mg or cm/s²: multiply by 0.00980665 or 0.01.",
    "readings.force_in_counts": "This looks like raw counts: scale them as the data sheet says.",
    "readings.force_off": "Its scale or its zero is off, or its range or unit is another one. Calibrate it in six"
    " positions; if it still reads so, check range and unit.",
    "readings.force_unknown": "Check unit, range and calibration.",
    "readings.gyroscope_dead": {
        "one": "{where:place}: an axis of the gyroscope never changes ({axes:and}). Replace the sensor or check its"
        " wiring.",
        "other": "{where:place}: axes of the gyroscope never change ({axes:and}). Replace the sensor or check its"
        " wiring.",
    },
    "readings.gyroscope_clipped": "{where:place}: the gyroscope stops at {level_radps:degps}, so faster movement is"
    " lost. Choose a larger range or move more slowly.",
    "readings.gyroscope_silent": "{where:place}: the sensor turns but its gyroscope reads nothing. Replace it.",
    "readings.gyroscope_in_degrees": "{where:place}: the gyroscope reads 57 times what the sensor turns: degrees/s"
    " are given as rad/s. Divide by 57.296 or declare degrees/s.",
    "readings.gyroscope_twice": "{where:place}: the gyroscope reads a 57th of what the sensor turns: rad/s were"
    " converted twice. Declare rad/s.",
    "readings.gyroscope_scale": "{where:place}: the gyroscope reads {factor:number~3} times what the sensor turns,"
    " going by gravity and field. Check its unit and its scale factor.",
    "readings.gyroscope_pace": "{where:place}: going by gravity and field, the sensor turns {factor:number~3} times as"
    " far as its gyroscope says. Either the rate or the clock is wrong: the samples then come at {rate_hz:hz}, not at"
    " {said_hz:hz}; give that rate, or correct the times. Or the unit or the range of the gyroscope is: then multiply"
    " its columns by {factor:number~3}. The signals do not tell which.",
    "readings.gyroscope_too_calm": "{where:place}: the gyroscope reads at most {rate_radps:number~2} rad/s although the"
    " sensor is shaken by {force_mps2:mps2}. Check its unit.",
    "readings.gyroscope_restless": "{where:place}: the gyroscope reads {rate_radps:number~2} rad/s while the"
    " accelerometer stands still. If the sensor lay still, these may be degrees/s: declare them so; otherwise find the"
    " gyroscope zero.",
    "readings.gyroscope_against_others": "{where:place}: the axes of the gyroscope do not fit the other sensors."
    " Check the axes that are declared: {mapping:and}.",
    "readings.accelerometer_against_others": "{where:place}: the axes of the accelerometer do not fit the other"
    " sensors. Check the axes that are declared: {mapping:and}.",
    "readings.gyroscope_against_accelerometer": "{where:place}: the axes of the gyroscope do not fit those of the"
    " accelerometer. Check the axes that are declared: {mapping:and}.",
    "readings.axes_apart": "{where:place}: gyroscope and accelerometer do not have the same axes. Check the"
    " axes that are declared: {mapping:and}.",
    "readings.field_axes_apart": "{where:place}: gyroscope and magnetometer do not have the same axes. Check the"
    " axes that are declared: {mapping:and}.",
    "readings.gyroscope_against_magnetometer": "{where:place}: the axes of the gyroscope do not fit those of the"
    " magnetometer. Check the axes that are declared: {mapping:and}.",
    "readings.magnetometer_against_gyroscope": "{where:place}: the axes of the magnetometer do not fit those of the"
    " gyroscope. Check the axes that are declared: {mapping:and}.",
    "readings.axes_in_doubt": "{where:place}: gyroscope, accelerometer and magnetometer do not quite fit each other."
    " Iron or a magnet nearby looks like this, and so do axes that are declared wrongly. Go away from iron and turn the"
    " sensor about each of its axes; if this word comes again, have the sensor checked.",
    "readings.axes_in_doubt_six": "{where:place}: gyroscope and accelerometer do not quite fit each other. Turn the"
    " sensor about each of its axes; if this word comes again, check the axes that are declared, and have the sensor"
    " checked.",
    "readings.axes_unclear": "{where:place}: the axes of its sensors do not fit each other, and this movement does not"
    " show which are exchanged. Turn the sensor about each of its axes, and check the axes that are declared.",
    "readings.unexplained": "{where:place}: the gyroscope does not fit what gravity and the magnetic field do in the"
    " sensor, and neither another unit nor exchanged axes explain it. Check the rate and the time stamps first, then"
    " whether samples of several sensors are mixed, then iron nearby.",
    "readings.live_sensor_axes": "{where:place}: the axes of this sensor do not fit each other as its sensor box"
    " gives them ({mapping:and}). Use another sensor, and tell whoever set up the sensor box.",
    "readings.live_sensor_amiss": "{where:place}: gyroscope, accelerometer and magnetometer of this sensor do not"
    " quite fit each other. Go away from iron and turn the sensor about each of its axes; if this word comes"
    " again, use another sensor and have this one checked.",
    "readings.live_gyroscope_pace": "{where:place}: going by gravity and field, this sensor turns {factor:number~3}"
    " times as far as its gyroscope says: its clock is wrong, or the range that its sensor box declares. Use another"
    " sensor, and tell whoever set up the sensor box.",
    "readings.live_gyroscope_unit": "{where:place}: the gyroscope does not read in the unit that its sensor box"
    " declares. Use another sensor, and tell whoever set up the sensor box.",
    "readings.live_gyroscope_restless": "{where:place}: the gyroscope reads {rate_radps:number~2} rad/s while the"
    " accelerometer stands still. Lay the sensor down and find its gyroscope zero; if this word comes again, use"
    " another sensor.",
    "readings.live_accelerometer_unit": "{where:place}: the accelerometer does not show gravity in the unit that"
    " its sensor box declares. Use another sensor, and tell whoever set up the sensor box.",
    "readings.live_magnetometer_unit": "{where:place}: the magnetometer does not read in the unit that its sensor"
    " box declares. Use another sensor, and tell whoever set up the sensor box.",
    "readings.live_field_up": "{where:place}: the magnetic field points up by {angle_rad:deg}. That is right south"
    " of the equator: set the hemisphere of this service. Otherwise the sensor box gives gravity or the field"
    " with the other sign: use another sensor, and tell whoever set it up.",
    "readings.live_field_down": "{where:place}: the magnetic field points down by {angle_rad:deg}. That is right"
    " north of the equator: set the hemisphere of this service. Otherwise the sensor box gives gravity or the"
    " field with the other sign: use another sensor, and tell whoever set it up.",
    "readings.magnetometer_zero": "{where:place}: the magnetometer always reads zero. Declare that there is none, or"
    " switch it on.",
    "readings.magnetometer_constant": "{where:place}: the magnetometer never changes. Declare that there is none, or"
    " switch it on.",
    "readings.magnetometer_frozen": "{where:place}: the magnetometer repeated one value for {lasts_s:s} while the"
    " sensor turned. Headings there rest on the gyroscope alone; check the sensor and its connection.",
    "readings.magnetometer_unit": "{where:place}: the magnetometer reads {value:number~3} where 0.000025 to 0.000065"
    " T is expected. {remedy}",
    "readings.field_in_microtesla": "This looks like microtesla: divide by 1 000 000.",
    "readings.field_in_gauss": "This looks like gauss: divide by 10 000.",
    "readings.field_normalised": "This looks like a normalised field: send the raw readings.",
    "readings.field_in_milligauss": "This looks like milligauss: divide by 10 000 000.",
    "readings.field_in_nanotesla": "This looks like nanotesla: divide by 1 000 000 000.",
    "readings.field_off": "{where:place}: the magnetometer reads {field_t:ut~3} where 25 to 65 µT is expected. Go away"
    " from iron and magnets, and calibrate it; if that does not help, check its unit.",
    "readings.field_varies": "{where:place}: the magnetic field varies by {share:percent}. Go away from iron and"
    " magnets, or calibrate the magnetometer.",
    "readings.field_up": "{where:place}: the magnetic field points up by {angle_rad:deg}. That is right where this was"
    " recorded south of the equator: say so. Otherwise the accelerometer gives gravity instead of specific force, as"
    " phones and north-east-down devices do, or the magnetometer is reversed: give its columns the other sign.",
    "readings.field_down": "{where:place}: the magnetic field points down by {angle_rad:deg}. That is right where this"
    " was recorded north of the equator: say so. Otherwise the accelerometer gives gravity instead of specific force,"
    " as phones and north-east-down devices do, or the magnetometer is reversed: give its columns the other sign.",
}
