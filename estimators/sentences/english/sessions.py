"""English sentences of setups, recordings and magnetic sources that cannot be used."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "setup.no_placements": "No sensor is worn. Name at least one placement.",
    "setup.placement_twice": "A placement occurs twice ({places:place}). Each sensor needs its own.",
    "setup.rate": "The rate is {rate_hz:hz.1}; it must lie between 10 and 1000 Hz.",
    "setup.unknown_placement": "Placements that do not exist: {unknown:and}. Use one of {places:place|or}.",
    "setup.balance_needs": "A balance test needs a sensor on the pelvis, on the chest, or on both, and no others.",
    "setup.arm_needs": "Arms, trunk and legs need a sensor on an upper arm or a forearm, or sensors above and below a"
    " hip, knee or ankle, or on the trunk and both thighs.",
    "setup.unknown_pipeline": "There is no pipeline {name}. Use one of {known:or}.",
    "setup.missing_sensors": "The recording lacks sensors: {missing:place}. It has {worn:place}.",
    "setup.source_sensor": "A session with a magnetic source needs the source and at least one sensor, each at its"
    " own placement.",
    "setup.source_place": "Choose where the magnetic source is worn: {places:place|or}.",
    "setup.unknown_parameters": "Parameters that do not exist: {unknown:and}. Known are {known:and}.",
    "setup.coil_numbers": "Turns, radius and current limit of the coils must be above zero.",
    "setup.gain_sigma": "Calibrated coils need their gain_sigma: how uncertain they are.",
    "setup.three_coils": "A magnetic source that is worn has three coils, not {coils:number}.",
    "setup.loops": "A winding is described by at most {most:number} loops.",
    "setup.coil_limit": "A magnetic source on a body must stay below {current_a:number~3} A and"
    " {moment_am2:number~3} A m²; these coils do not.",
    "setup.coil_layers": "coil_layers are two whole numbers: loops along and across the winding.",
    "setup.coil_list": "calibrated_coils is a list of coils.",
    "setup.only_magnetic": "Only sessions with a magnetic source can be smoothed this way.",
    "setup.bursts_need": "A recording of bursts needs magnetometers and coil states (bits 2 and 6 of the packets'"
    " mask).",
    "setup.bursts_smoother": "Bursts need orientations of the whole recording: {known:or}, not {name}.",
    "setup.no_burst": "{where:place}: no burst of three coils within {longest_s:s.1} in {pulses:number} pulses."
    " Pulses that the service asked for one by one belong to a session with a magnetic source.",
    "recording.no_samples": "The recording has no usable samples. Check the file and its column mapping.",
    "recording.span": "The time stamps span {span_s:s}, but no sensor has more than {samples:number} samples. A"
    " stamp must be wrong: check their unit, and the first and the last of them.",
    "recording.tick_rate": "The rate is {rate_hz:hz.1}; it must lie between 1 and 10 000 Hz.",
    "body.stature": "A stature of {stature_m:m.2} is outside 0.5 to 2.5 m. Give metres, not centimetres.",
}
