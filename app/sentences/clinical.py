"""English sentences of exercises, prescriptions, templates and comparisons."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "caseload.due": "{name}: {dose}",
    "caseload.due_also": "{before}; {name}: {dose}",
    "prescription.not_found": "Prescription not found, or not shared with you.",
    "exercise.not_found": "Exercise not found in your clinic.",
    "exercise.create_not_allowed": "Only therapists and administrators can add or change exercises.",
    "prescription.no_such_template": "There is no such template of this exercise for this patient.",
    "prescription.ends_before_start": "A prescription must end after it starts.",
    "prescription.of_template": "In its template: {trouble}",
    "prescription.has_ended": "This prescription has ended; prescribe the exercise again.",
    "edited.elsewhere": "Somebody else has changed this since you opened it. Load it again; what you entered is still"
    " here.",
    "edited.meanwhile": "{name} changed this after you opened it. Nothing of yours was saved and nothing is"
    " lost: look at that change, then save again.",
    "template.changed_meanwhile": "{name} saved version {number} after you opened this one: “{reason}”."
    " Nothing is lost: look at that version, then save yours on top of it.",
    "prescription.time_needs_zone": "A time needs its time zone, for instance 2030-01-31T12:00:00Z.",
    "template.not_found": "Template not found, or not shared with you.",
    "comparison.not_found": "Comparison not found, or not shared with you.",
    "template.create_not_allowed": "Only therapists can create templates.",
    "template.other_exercise": "A further version must be of the same exercise and patient as its template.",
    "template.other_patient": "This template was made for another patient.",
    "template.not_walked": "This exercise is a walk; choose a recording of a walk.",
    "template.other_kind": "Strides are compared with the template of a walk, and other movements with that of a"
    " movement; choose a template of the same kind.",
    "template.few_strides": {
        "one": "Only one stride can be used. Record a walk straight ahead, at least four strides with each foot.",
        "other": "{count:number} strides can be used. Record a walk straight ahead, at least four strides with each"
        " foot.",
    },
    "template.by_hand": "Excluded by hand.",
    "template.no_repetition": "Nothing in this recording has the number {number}.",
    "template.no_angle": "No joint angle was measured in this session; calibrate the sensors on the patient"
    " and record again.",
    "design.no_channel": "The template has no curve {name}; choose one of those that it shows.",
    "design.main_counts": "{name} is the main angle of the exercise and always counts; it cannot be watched only.",
    "design.phases": "Phases must follow each other, each with a name of its own and its start before its end; move"
    " the border that lies over another.",
    "design.knots": "The points of a band must be in order and at different phases, one band for each curve; load the"
    " template again and draw anew.",
    "design.stop": "Stop rule {number} is not valid; give it an angle of the template and a limit above zero.",
    "design.band_narrow": "The band of {channel:channel} is too narrow: {left} of {of} repetitions of the template's"
    " own recording leave it, by up to {excess}. Widen it.",
    "design.limit_above": "Stop rule {number}: in the template's own recording {channel:channel} reaches {value}, so"
    " this limit would stop every repetition. Set it to {least} or more.",
    "design.limit_below": "Stop rule {number}: in the template's own recording {channel:channel} goes down to"
    " {value}, so this limit would stop every repetition. Set it to {least} or less.",
    "design.rest_above": "Stop rule {number}: this patient rests with {channel:channel} at {value}, so this limit would"
    " stop the exercise before it begins. Set it to {least} or more.",
    "design.rest_below": "Stop rule {number}: this patient rests with {channel:channel} at {value}, so this limit would"
    " stop the exercise before it begins. Set it to {least} or less.",
    "design.time_short": "Stop rule {number}: one repetition of the template lasts {lasts_s:s.1}, so this time is over"
    " before the first one ends. Set a longer time.",
    "design.limit_channel": "Stop rule {number}: {channel:channel} is no curve of the template, so its limit could"
    " not be watched. Choose another angle.",
    "design.weight": "Part {number} of the sum is not valid; choose one of the measures that are offered, each once,"
    " and a weight other than zero.",
    "design.cue": "Cue {number} is not valid; give it a curve of the template, phases in order and a tolerance"
    " above zero.",
    "template.no_base": "This version belongs to another template; reload the page and change the newest one.",
    "template.retired": "“{name}” is retired; restore it in the library, or choose another template.",
    "template.other_angle": "{name} was not recorded in this template; choose an exercise with one of its angles.",
    "exercise.walk_angle": "A walk has no primary angle; leave it empty.",
    "exercise.angle": "The primary angle is not a joint angle of the {side:side} side; choose one from the"
    " list.",
    "comparison.no_template": "No template is prescribed, so there was no comparison.",
    "caseload.pain": "The session was stopped because it hurt.",
    "caseload.pain_marked": "The session was stopped because it hurt; pain {mark} of 10.",
    "caseload.much_pain": "Pain {mark} of 10 after the session.",
    "caseload.pain_corrected": "{before} Later changed to {mark} of 10.",
    "worry.not_found": "This is not in the list any more; load the page again.",
    "caseload.compensation_angle": "{channel:channel}: {more_rad:deg} more than in the template.",
    "caseload.compensation_length": "{channel:channel}: {more_m:cm} more than in the template.",
    "caseload.few_repetitions": "{valid} of {count} prescribed repetitions were valid in the last session.",
    "caseload.declining": {
        "one": "{channel:channel}: has probably decreased within {count} week.",
        "other": "{channel:channel}: has probably decreased within {count} weeks.",
    },
    "caseload.declining_angle": {
        "one": "{channel:channel}: probably {less_rad:deg} ± {half_rad:deg} less than {count} week ago.",
        "other": "{channel:channel}: probably {less_rad:deg} ± {half_rad:deg} less than {count} weeks ago.",
    },
    "caseload.dead_link": "The link to the sensors was lost for more than {silence_s:s}.",
    "caseload.dead_to_the_end": "The link to the sensors was lost and did not come back.",
    "caseload.link_lost": "A session is open, but no data comes from the sensors.",
    "caseload.not_practising": {
        "one": "Nothing practised for {count} day.",
        "other": "Nothing practised for {count} days.",
    },
    "caseload.rarely_practised": "{share:percent} of the sessions of the last four weeks were done.",
    "caseload.no_template": "An exercise is prescribed without a template to compare with.",
    "caseload.failed": "The last session failed.",
    "caseload.lost": "The last session lost {share:percent} of its packets.",
    "progress.other_side": {
        "one": "Other side ({side:side}), newest session, 1 repetition",
        "other": "Other side ({side:side}), newest session, mean of {count}",
    },
    "progress.norm_confidence": "Healthy people of {first} to {last} years, mean with its 95 % interval ({source})",
    "progress.norm_means": "Means of healthy men and women of {first} to {last} years ({source})",
    "progress.pain": "Stopped because it hurt",
    "progress.template": "Template {name}, version {number}",
    "progress.prescribed": "Prescribed: {dose}",
    "progress.estimator": "Estimator {estimator} {version}, pipeline {pipeline}",
    "dose.repetitions": {"one": "{count} repetition", "other": "{count} repetitions"},
    "dose.walk": "1 walk",
    "dose.sets": "{sets} sets of {amount}",
    "dose.weekly": {"one": "{amount}, once a week", "other": "{amount}, {count} times a week"},
    "comparison.not_compared": "Not compared. {reason}",
    "comparison.not_practised": "This session does not count as practised. {reason}",
    "comparison.done": "Repetitions compared: {kept} of {all}.",
}
