"""English sentences of exercises, prescriptions, templates and comparisons."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "prescription.not_found": "Prescription not found, or not shared with you.",
    "exercise.not_found": "Exercise not found in your clinic.",
    "exercise.create_not_allowed": "Only therapists and administrators can add exercises.",
    "prescription.no_such_template": "There is no such template of this exercise for this patient.",
    "prescription.ends_before_start": "A prescription must end after it starts.",
    "prescription.time_needs_zone": "A time needs its time zone, for instance 2030-01-31T12:00:00Z.",
    "template.not_found": "Template not found, or not shared with you.",
    "comparison.not_found": "Comparison not found, or not shared with you.",
    "template.create_not_allowed": "Only therapists can create templates.",
    "template.other_exercise": "A further version must be of the same exercise and patient as its template.",
    "template.other_patient": "This template was made for another patient.",
    "template.by_hand": "Excluded by hand.",
    "template.no_repetition": "There is no repetition {number} in this recording.",
    "template.no_angle": "No joint angle was measured in this session; calibrate the sensors on the"
    " patient and record again.",
    "comparison.not_compared": "Not compared: {reason}",
    "comparison.done": "{kept} of {all} repetitions compared.",
}

__all__ = ["ENGLISH"]
