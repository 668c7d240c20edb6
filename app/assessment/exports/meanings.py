"""What each measure of a repetition and each number of a stride says, for the dictionaries of the tables."""

from typing import Final

OF_REPETITION: Final[dict[str, str]] = {
    "range:": "largest minus smallest value of the angle within the repetition",
    "duration": "end minus beginning of the repetition",
    "duration_ratio": "duration divided by that of the template; 1 is the same",
    "timing_deviation": "mean time by which phases come earlier or later than in the template, % of the repetition",
    "time_to_peak_speed": "when the hand is fastest, in % of the outward movement",
    "shape_deviation": "mean distance of the curves from the template, in half widths of its band",
    "inside_band": "part of all curves that lies inside the band of the template",
    "peak_deviation:": "largest distance of the curve from the template, at the same phase",
    "peak_deviation_phase": "phase (0 to 100 % of the repetition) at which that distance is largest",
    "shape_rms:": "root mean square of the distance of the curve from the template",
    "peak_speed": "largest speed of the hand",
    "mean_speed": "mean speed of the hand",
    "peak_turning_speed": "largest turning speed of the segment",
    "mean_turning_speed": "mean turning speed of the segment",
    "path_residual": "what remains between the hand's path and the template's when place, turn and size are the same",
    "path_turn": "angle by which the hand's path is turned from the template's",
    "path_scale": "factor by which the hand's path is larger than the template's",
    "spectral_arc_length": "smoothness of the hand's speed (SPARC); nearer to zero is smoother",
    "log_dimensionless_jerk": "smoothness of the hand's speed; nearer to zero is smoother",
    "movement_units": "how often the hand speeds up and slows down again",
    "units_per_metre": "movement units divided by the length of the hand's path",
    "joint_correlation": "how closely shoulder and elbow move together: 1 alike, -1 opposite, 0 unrelated",
    "joint_lag": "time by which the elbow moves later than the shoulder",
    "joint_common_share": "part of the movement of shoulder and elbow that one common movement explains",
    "hand_path_ratio": "length of the hand's outward path divided by the straight line; 1 is straight",
    "range_ratio:": "range of motion divided by that of the template; 1 is the same",
    "multiple_correlation:": "how alike the curves of all repetitions are (CMC); 1 is the same",
    "repetition_rms:": "spread of the curves of all repetitions",
    "compensation:": "largest minus smallest value of the trunk's angle within the repetition",
}
"""By the name of the measure (`estimators.measures`); one with a colon at its end goes on with a channel."""

OF_STRIDE: Final[dict[str, str]] = {
    "number": "number of the stride of this foot",
    "bout": "number of the bout of walking",
    "toe_off_s": "when the foot leaves the ground",
    "contact_s": "when it is set down",
    "length_m": "stride length",
    "length_sigma_m": "standard deviation of the estimated stride length",
    "duration_s": "stride time",
    "stance_s": "time on the ground",
    "swing_s": "time in the air",
    "rise_m": "how much higher the foot stands than before",
    "clearance_m": "foot clearance in swing",
    "circumduction_m": "how far the foot swings out to the side",
    "contact_pitch_rad": "pitch of the foot when it is set down; toes up is positive",
    "toe_off_pitch_rad": "pitch of the foot when it leaves the ground; toes up is positive",
    "toe_out_rad": "how far the toes are turned outward",
    "turn_rad": "how far the foot turns within the stride",
    "peak_speed_mps": "largest speed of the foot",
    "is_counted": "1 where the stride counts in the means, else 0",
    "is_initiation": "1 for a first stride of a bout",
    "is_termination": "1 for a last stride of a bout",
    "flags": "doubts about the stride as a number of bits; empty where there are none",
}

__all__ = ["OF_REPETITION", "OF_STRIDE"]
