"""English sentences of walks, walking tests and instrumented shoes."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "walk.no_stride": "{side:side} foot: no stride was found. It never stood between its movements, or never left"
    " the ground.",
    "walk.only_turns": {
        "one": "{side:side} foot: every stride turns, none is straight; the one stride in turns is {length_m:m.2}"
        " long and takes {duration_s:s.2}. Walk a straight stretch of at least four strides.",
        "other": "{side:side} foot: every stride turns, none is straight; the {count:number} strides in turns are"
        " {length_m:m.2} long and take {duration_s:s.2}. Walk a straight stretch of at least four strides.",
    },
    "walk.no_straight_stride": "{side:side} foot: there is no stride of continuous straight walking. Walk at least"
    " four strides.",
    "walk.aloft": "{side:side} foot: for {away_s:s} it moved without standing as in walking. This is not counted.",
    "walk.long_strides": {
        "one": "{side:side} foot: one stride took far longer than those around it and is not counted: a halt, or"
        " two strides taken for one.",
        "other": "{side:side} foot: {count:number} strides took far longer than those around them and are not"
        " counted: halts, or two strides taken for one.",
    },
    "walk.sideways": {
        "one": "{side:side} foot: one stride went sideways or back and is not counted.",
        "other": "{side:side} foot: {count:number} strides went sideways or back and are not counted.",
    },
    "walk.trembling": "{side:side} foot: it trembles while it stands, as in clonus. Strides may be missing, and lengths"
    " and differences between the feet are less certain.",
    "walk.backward": "The walk went backward. Contacts and lifts are those of backward steps, so do not compare the"
    " numbers with those of forward walking.",
    "walk.carried": "{side:side} foot: it did not stand while the other one walked, as if carried. There are no step"
    " lengths, no double support and no asymmetry.",
    "walk.carried_way": "{side:side} foot: it was carried. Distance and steps are those of the other foot.",
    "walk.counts_apart": "The left foot made {left:number} strides and the right foot {right:number}, which two feet"
    " that walk in turn cannot do. Strides of one foot were not found.",
    "walk.ways_apart": "{side:side} foot: only {way_m:m} of way was found, but {other_m:m} of the other foot. Strides"
    " of it were not found; distance and steps are those of the other foot.",
    "walk.exchanged": "Both feet point inward: the left one by {left_rad:deg}, the right one by {right_rad:deg}. Are"
    " the left and the right shoe exchanged?",
    "walk.rolled": "For {moved_s:s} the feet moved without stepping, as in a wheelchair, on a bicycle or on an"
    " escalator. This way is not counted.",
    "walk.one_foot": "One foot only: no double support and no asymmetry.",
    "walk.missing": {
        "one": "{side:side} foot: {missing_s:s.1} of samples are missing; the stride there is not in the averages.",
        "other": "{side:side} foot: {missing_s:s.1} of samples are missing; the {count:number} strides there are not"
        " in the averages.",
    },
    "walk.too_long": "{side:side} foot: strides of {length_m:m} are longer than anybody's who walks. Check units,"
    " axes and sampling rate of the recording.",
    "walk.too_fast": "{side:side} foot: {speed_mps:number.1} m/s is faster than anybody walks. Check units, axes and"
    " sampling rate of the recording.",
    "walk.rises_apart": "From start to end the left foot rose by {left_m:m.2} and the right foot by {right_m:m.2},"
    " which one person cannot do. Do not trust heights. Check units, axes and sampling rate of the recording.",
    "walk.ended_above": "{side:side} foot: it ended {rise_m:m} above where it began. If there were no stairs, check"
    " units, axes and sampling rate of the recording.",
    "walk.ended_below": "{side:side} foot: it ended {rise_m:m} below where it began. If there were no stairs, check"
    " units, axes and sampling rate of the recording.",
    "walk.not_six_minutes": "Walked for {walked_s:min.1} of six minutes.",
    "walk.one_foot_steps": "One foot only: the other is taken to have made as many steps.",
    "walk.no_chair": "The feet do not measure getting up and sitting down: the time is from the first step to the"
    " last.",
    "walk.no_turn": "No turn was found.",
    "walk.other_foot": "{side:side} foot: {missing_s:s.1} of samples are missing. Distance and steps are those of"
    " the other foot.",
    "walk.count_short": "{missing_s:s.1} of samples are missing: the distance is probably too short, and steps,"
    " turns or halts may be missing from the count.",
    "walk.few_footholds": "Each foot needs {least:number} footholds before the feet can be related. Walk further.",
    "walk.short_way": "The walk is shorter than {least_m:m}; it is too short to relate the feet.",
    "walk.source_saw_few": "The magnetic source saw {seen:number} of {count:number} footholds of the right foot, too"
    " few to relate the feet.",
    "walk.too_short": "A foot needs at least {least_s:s.1} of samples; this recording is too short.",
    "walk.rate": "A foot cannot be followed at {rate_hz:hz.1}. Use 30 to 2000 Hz.",
    "walk.hole": "The samples of a foot have a hole of {hole_s:s}. Cut the recording there.",
    "walk.needs_foot": "A walk needs a sensor on a foot: {places:place|or}.",
    "walk.feet_only": "The feet are related by a magnetic source on one foot and a sensor on the other, and no"
    " others.",
    "shoes.exchanged": "By the forces the left foot stood right of the right one. The left and the right shoe seem"
    " to be exchanged.",
    "shoes.stairs": "Forces are analysed on level ground only, and a stride of the {side:side} foot rises or falls"
    " by {rise_m:cm}.",
    "shoes.clipped": "The load cell of the {where:place} stops at {level_n:number} N. What is above is missing, so"
    " forces, moments and balance are too small.",
    "shoes.no_weight": "The {side:side} shoe shows {load_n:number} N while it stands alone, which is nobody's"
    " weight. Check its load cells and their units (newton).",
    "shoes.loads_apart": "The {side:side} shoe shows {load_n:number} N while it stands alone, and the other"
    " {other_n:number} N. Check its load cells.",
    "shoes.of": "{side:side} shoe. {reason}",
    "shoes.cells_missing": "Forces need load cells under heel and forefoot of both feet.",
    "shoes.one_foot": "The walk has only one foot; forces need both.",
    "shoes.no_cell": "The sensor under the {cell:load_cell} has no load cell in this recording.",
    "shoes.cell_jammed": "The load cell under the {cell:load_cell} is never without load although the shoe swings."
    " Tare it, and check whether it is jammed.",
    "shoes.no_stance": "No stance was found: the foot never lies flat. Check taring and thresholds.",
    "shoes.never_loaded": "The shoes were never loaded. Check calibration and units (newton).",
    "shoes.never_still": "Nobody stands still in this recording, so nobody can be weighed.",
    "shoes.no_cycle": "A gait cycle lies between two landings of a foot; fewer were found.",
    "shoes.shank_swing": "The sensor on the lower leg does not swing about one axis. Check how it is put on.",
    "shoes.shank_twist": "The sensor on the lower leg turns about the long axis of the leg. Check how it is put on.",
    "shoes.few_loads": "{loads:number} loads are too few. Use at least {least:number}, in all directions.",
    "shoes.loads_alike": "These loads do not separate the channels. Push along x, y and z, both ways and off centre.",
    "shoes.time_bases": "The sensors of a shoe are on different time bases. Resample them to one.",
    "shoes.uneven": "The samples of a shoe are not even. Resample them to a common rate.",
    "stride.outside": "Before Record was pressed or after Stop.",
    "stride.missing": "Samples are missing in or beside this stride.",
    "stride.aloft": "The foot moved too long without standing; its way is not known.",
    "stride.long": "Far longer than the strides around it: a halt, or a stance that was not found.",
    "stride.sideways": "A step aside or back.",
    "stride.last": "The last stride before standing still.",
    "stride.turning": "Walked along a turn.",
    "stride.unsteady": "Not steady or not straight.",
}
