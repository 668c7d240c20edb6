"""Earth and reference frames of other systems, and how far an orientation is off: for experiments and tests."""

from estimators.orientation._heading import estimate_lag, to_true_north
from estimators.orientation._optical_reference import align_marker_frame, heading_offset, stick_angle_errors

__all__ = [
    "align_marker_frame",
    "estimate_lag",
    "heading_offset",
    "stick_angle_errors",
    "to_true_north",
]
