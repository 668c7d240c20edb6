"""English sentences of repetitions, templates and comparisons."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "repetition.no_measurement": "No measurement during this repetition.",
    "repetition.lost": "The sensors lost track for {lost_s:s.1} during this repetition.",
    "repetition.shorter": "Much shorter than the others: {duration_s:s.1} instead of about {usual_s:s.1}.",
    "repetition.longer": "Much longer than the others: {duration_s:s.1} instead of about {usual_s:s.1}.",
    "repetition.opposite": "Moved in the opposite direction to the others.",
    "repetition.half_way": "Stopped half way: {share:percent} of the usual movement.",
    "repetition.other_movement": "Another movement than the one that was to be done.",
    "repetition.unlike": "Unlike the others: the movement took another path.",
    "findings.none_found": "No clear repetitions were found in this session.",
    "findings.none_used": "Repetitions were found, but all were excluded; the reason stands beside each.",
    "findings.no_strides": "No stride from one contact with the floor to the next was found in this session.",
    "findings.no_stride_used": "Strides were found, but all were left out; the reason stands beside each.",
    "findings.matched": "The movement matched the template within what can be measured.",
    "findings.no_difference": "No difference from the template is larger than the uncertainty of the measurement.",
    "findings.range_smaller": "{channel:channel} range was {difference_rad:deg} smaller than in the template"
    " ({value_rad:deg} against {reference_rad:deg}).",
    "findings.range_larger": "{channel:channel} range was {difference_rad:deg} larger than in the template"
    " ({value_rad:deg} against {reference_rad:deg}).",
    "findings.range_less": "{channel:channel} range was {difference} smaller than in the template ({value} against"
    " {reference}).",
    "findings.range_more": "{channel:channel} range was {difference} larger than in the template ({value} against"
    " {reference}).",
    "size.angle": "{value_rad:deg}",
    "size.length": "{value_m:cm.1}",
    "size.speed": "{value_mps:mps}",
    "findings.main_not_measured": "{channel:channel}, the main measurement of this exercise, was not measured. Nothing"
    " can be said about it: wear and calibrate the sensors above and below the joint.",
    "findings.main_mostly_not_measured": "{channel:channel}, the main measurement of this exercise, was not measured"
    " most of the time: only in {share:percent} of the movement. Check the sensors above and below the joint.",
    "findings.main_uncertain": "{channel:channel}, the main measurement of this exercise, was not measured well enough"
    " to be compared: it is known within {unsure_rad:deg} only.",
    "findings.trunk_leaned_forward": "Compensation: the trunk leaned {more_rad:deg} more than in the template, forward"
    " and back ({value_rad:deg} against {reference_rad:deg}).",
    "findings.trunk_leaned_sideways": "Compensation: the trunk leaned {more_rad:deg} more than in the template, to the"
    " side ({value_rad:deg} against {reference_rad:deg}).",
    "findings.trunk_turned": "Compensation: the trunk turned {more_rad:deg} more than in the template ({value_rad:deg}"
    " against {reference_rad:deg}).",
    "findings.some_trunk": {
        "one": "Compensation in repetition {repetitions:and}: {channel:channel} {more_rad:deg} more than in the"
        " template.",
        "other": "Compensation in repetitions {repetitions:and}: {channel:channel} up to {more_rad:deg} more than in"
        " the template.",
    },
    "findings.some_shoulder_rose": {
        "one": "Compensation in repetition {repetitions:and}: the shoulder rose {more_m:cm} more than in the template.",
        "other": "Compensation in repetitions {repetitions:and}: the shoulder rose up to {more_m:cm} more than in the"
        " template.",
    },
    "findings.some_smaller": {
        "one": "Repetition {repetitions:and} was smaller than in the template: {channel:channel} {value_rad:deg}"
        " against {reference_rad:deg}.",
        "other": "Repetitions {repetitions:and} were smaller than in the template: {channel:channel} down to"
        " {value_rad:deg} against {reference_rad:deg}.",
    },
    "findings.some_strides_less": {
        "one": "Stride {strides:and} was smaller than in the template: {channel:channel} {value} against {reference}.",
        "other": "Strides {strides:and} were smaller than in the template: {channel:channel} down to {value} against"
        " {reference}.",
    },
    "findings.some_strides_slower": {
        "one": "Stride {strides:and} took {value_s:s.1} against {reference_s:s.1} in the template.",
        "other": "Strides {strides:and} took up to {value_s:s.1} against {reference_s:s.1} in the template.",
    },
    "findings.some_strides_faster": {
        "one": "Stride {strides:and} took only {value_s:s.1} against {reference_s:s.1} in the template.",
        "other": "Strides {strides:and} were faster than in the template: down to {value_s:s.1} against"
        " {reference_s:s.1}.",
    },
    "findings.strides_slower": "Each stride took {ratio:number.1} times as long as in the template ({value_s:s.1}"
    " against {reference_s:s.1}).",
    "findings.strides_faster": "Each stride was faster than in the template ({value_s:s.1} against {reference_s:s.1}).",
    "findings.stride_outside": {
        "one": "{what:foot}: outside the band between {start:points} and {end:percent} of the stride.",
        "other": "{what:foot}: outside the band in {outside:number} of {count:number} strides, mostly between"
        " {start:points} and {end:percent} of the stride.",
    },
    "foot.toes_lower": "the toes pointed further down than in the template",
    "foot.toes_higher": "the toes pointed further up than in the template",
    "foot.lower": "the foot was lifted less than in the template",
    "foot.higher": "the foot was lifted more than in the template",
    "foot.slower": "the foot went forward more slowly than in the template",
    "foot.faster": "the foot went forward faster than in the template",
    "findings.some_slower": {
        "one": "Repetition {repetitions:and} took {value_s:s.1} against {reference_s:s.1} in the template.",
        "other": "Repetitions {repetitions:and} took up to {value_s:s.1} against {reference_s:s.1} in the template.",
    },
    "findings.some_faster": {
        "one": "Repetition {repetitions:and} took only {value_s:s.1} against {reference_s:s.1} in the template.",
        "other": "Repetitions {repetitions:and} were faster than in the template: down to {value_s:s.1} against"
        " {reference_s:s.1}.",
    },
    "findings.how_often": {
        "one": "This was outside the band.",
        "other": "This was outside the band in {outside:number} of {count:number} repetitions.",
    },
    "findings.outside": {
        "one": "{channel:channel}: outside the band, by up to {beyond_rad:deg}.",
        "other": "{channel:channel}: outside the band in {outside:number} of {count:number} repetitions, by up to"
        " {beyond_rad:deg}.",
    },
    "findings.outside_length": {
        "one": "{channel:channel}: outside the band, by up to {beyond_m:cm}.",
        "other": "{channel:channel}: outside the band in {outside:number} of {count:number} repetitions, by up to"
        " {beyond_m:cm}.",
    },
    "findings.this_outside_mostly": {
        "one": "This was outside the band, mostly between {start:points} and {end:percent} of the movement.",
        "other": "This was outside the band in {outside:number} of {count:number} repetitions, mostly between"
        " {start:points} and {end:percent} of the movement.",
    },
    "findings.places_followed": "So the arm was elsewhere too: {angles:and}.",
    "findings.in_phases": "Mostly in: {phases:and}.",
    "findings.outside_mostly": {
        "one": "{channel:channel}: outside the band, mostly between {start:points} and {end:percent} of the"
        " movement.",
        "other": "{channel:channel}: outside the band in {outside:number} of {count:number} repetitions, mostly"
        " between {start:points} and {end:percent} of the movement.",
    },
    "findings.beyond_angle": "{channel:channel} (by up to {beyond_rad:deg})",
    "findings.beyond_length": "{channel:channel} (by up to {beyond_m:cm})",
    "findings.others_outside": "Outside the band: {angles:and}.",
    "findings.also_outside": "Also outside the band: {angles:and}.",
    "findings.slower": "Each repetition took {ratio:number.1} times as long as in the template ({value_s:s.1}"
    " against {reference_s:s.1}).",
    "findings.faster": "Each repetition was faster than in the template ({value_s:s.1} against {reference_s:s.1}).",
    "findings.less_smooth": "The movement was less smooth than in the template (smoothness {value:number.1} against"
    " {reference:number.1}).",
    "findings.smoother": "The movement was smoother than in the template (smoothness {value:number.1} against"
    " {reference:number.1}).",
    "findings.longer_way": "The path of the hand was {more:percent} longer than in the template.",
    "findings.shoulder_rose": "Compensation: the shoulder rose {more_m:cm} more than in the template.",
    "measure.no_stroke": "Undefined: the movement has no clear way out.",
    "measure.no_peak": "Undefined: the speed has no peak on the way out.",
    "measure.stroke_short": "Undefined: the way out took less than {least_s:s.1}.",
    "measure.way_short": "Undefined: the hand moved less than {share:percent} of the reach.",
    "measure.joint_still": "Undefined: shoulder or elbow moved less than {least_rad:deg} on the way out.",
    "measure.unlike_angle": "Undefined: the repetitions differ by {rms_rad:deg.1} from their mean, too much for a"
    " movement of {extent_rad:deg.1}.",
    "measure.unlike_length": "Undefined: the repetitions differ by {rms_m:cm} from their mean, too much for a"
    " movement of {extent_m:cm}.",
    "measure.straight_path": "The path is straight: how far it is turned about itself cannot be known.",
    "compare.side_not_measured": "Nothing of the {side:side} side was measured in this recording. Wear and calibrate"
    " its sensors, or compare the other side.",
    "compare.other_side_measured": "Nothing of the {side:side} side was measured in this recording: the sensors were"
    " worn on the {worn:side} side. Wear and calibrate them on the {side:side} side, or choose the exercise of the"
    " {worn:side} side.",
    "compare.no_signal": "No joint angle and no wrist was measured on the {side:side} side. Wear and calibrate the"
    " sensors above and below the joint.",
    "compare.few_repetitions": {
        "one": "Only one usable repetition was found. Record at least two, better five, with a short rest between"
        " them.",
        "other": "{count:number} usable repetitions were found. Record at least two, better five, with a short rest"
        " between them.",
    },
    "compare.not_measured": "{channel:channel} was not measured. Choose one of {channels:channel|or}.",
    "compare.not_stored": "These bytes are not a stored {kind:stored}.",
    "compare.other_version": "This {kind:stored} was stored in another form ({version}) than this program reads"
    " ({known}). Update the program.",
    "compare.cut_short": "This stored {kind:stored} is cut short or larger than any real one. Make it again.",
    "compare.damaged": "This stored {kind:stored} is damaged. Make it again.",
}
