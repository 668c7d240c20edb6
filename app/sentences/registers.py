"""Names of what stands in registers: by them the client says labels, titles and descriptions in another language."""

from collections.abc import Iterator
from typing import Final

from estimators.measures import MEASURES


def _names() -> Iterator[tuple[str, str]]:
    for one in MEASURES:
        kind = {"repetition": "repetition", "asymmetry": "uneven"}.get(one.part, "walk")
        if one.label:
            yield f"measure_name.{kind}.{one.name.removesuffix(':')}", one.label


_TITLES: Final = {
    "estimator_title.telemotion": "Telemotion",
    "estimator_text.telemotion": "Also learns each sensor's own errors and nearby magnets while it is"
    " worn; the most accurate live estimate.",
    "estimator_title.vqf": "VQF",
    "estimator_text.vqf": "Learns the sensor's drift while still and moving and ignores passing magnetic"
    " disturbances; widely used and well proven.",
    "estimator_title.marzouk_quaternion_ekf": "Quaternion Kalman filter",
    "estimator_text.marzouk_quaternion_ekf": "The published filter for arm monitoring with its equations"
    " corrected; for comparison with earlier work.",
    "estimator_title.marzouk_error_state_ekf": "Error-state Kalman filter",
    "estimator_text.marzouk_error_state_ekf": "A Kalman filter without singular positions whose"
    " inclination never follows a magnet; reports its uncertainty.",
    "estimator_title.marzouk_euler_ekf": "Euler-angle Kalman filter",
    "estimator_text.marzouk_euler_ekf": "The first published filter for arm monitoring, which loses its"
    " way when the sensor points straight up or down; for comparison with earlier work.",
    "estimator_title.luinge_inclination": "Inclination Kalman filter",
    "estimator_text.luinge_inclination": "Published filter that ignores magnetism: how far each sensor"
    " leans is sound, where it faces drifts.",
    "estimator_title.roetenberg_disturbance": "Magnetic-disturbance Kalman filter",
    "estimator_text.roetenberg_disturbance": "Published filter that works out how iron nearby bends the"
    " magnetic field and keeps the heading beside it.",
    "estimator_title.telemotion_smoother": "Telemotion, off-line",
    "estimator_text.telemotion_smoother": "Looks at the whole session, forward and backward, once it is"
    " recorded; the most accurate.",
    "format_title.apdm": "APDM sensors (CSV)",
    "format_text.apdm": "Sensors named by where they are worn, as APDM's software writes them",
    "format_title.broad": "BROAD trial (.mat, .hdf5)",
    "format_text.broad": "One sensor with its optical truth",
    "format_title.csv": "Table (CSV)",
    "format_text.csv": "Any sensors: you say which column is what, and in which unit",
    "format_title.gait_tracking": "Walk with one foot sensor (x-io, CSV)",
    "format_text.gait_tracking": "One sensor on a foot, as the Gait-Tracking set writes it",
    "format_title.gaitmap": "Walk with both feet (gaitmap, CSV)",
    "format_text.gaitmap": "Sensors on both feet, as the gaitmap library writes them",
    "format_title.instrumented_shoe": "Walk on instrumented shoes (CSV)",
    "format_text.instrumented_shoe": "Inertial sensors and load cells under heel and forefoot",
    "format_title.packet_log": "Packet log of a gateway",
    "format_text.packet_log": "As downloaded from a session, or stored by a gateway (.tmlog)",
    "format_title.pyshoe": "Walk with one foot sensor (PyShoe, .mat)",
    "format_text.pyshoe": "One sensor on the right foot",
    "format_title.qmt_mat": "Whole-body recording (.mat)",
    "format_text.qmt_mat": "MATLAB file with 16 named sensors; the arms and the trunk are used",
}
"""Of estimators and file formats, as their classes have them: importing those would bring every kernel along."""
ENGLISH: Final[dict[str, str | dict[str, str]]] = {**dict(_names()), **_TITLES}

__all__ = ["ENGLISH"]
