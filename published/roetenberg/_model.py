"""State of Roetenberg's filter: orientation and offset, and the magnetic disturbance that it adds to them.

Its error delta = R d_e is in the earth frame as that of orientation is. Fields are in units of the reference's norm.
"""

from typing import Final

from estimators.kernels import Record, record, step
from estimators.orientation import _strapdown_steps as steps
from estimators.recording import Float
from published._error_state import BASE, Matrix

_BIAS: Final = 3
STATES: Final = BASE + 3
"""Orientation error in the earth frame, offset error in the sensor frame, disturbance error in the earth frame."""
MEASUREMENTS: Final = 5
"""Two of gravity, three of the field."""
DISTURBANCE: Final = steps.DETAIL_INNOVATION + MEASUREMENTS
NORM, DIP, DETAILS = DISTURBANCE + 3, DISTURBANCE + 4, DISTURBANCE + 5
"""Columns of the details after the innovations."""

SETTINGS = record(
    steps.SETTINGS,
    [
        ("use_gravity", "i8"),
        ("use_field", "i8"),
        ("compensate", "i8"),
        ("blocks_only", "i8"),
        ("raw_detector", "i8"),
        ("held_acceleration", "i8"),
        ("field_variance", "f8"),
        ("disturbance_gain", "f8"),  # c_d
        ("smoothing", "f8"),
        ("dead_band", "f8"),
        ("norm_gain", "f8"),
        ("dip_gain", "f8"),
        ("floor_variance", "f8"),
        ("nominal_norm", "f8"),
        ("nominal_dip", "f8"),
        ("nominal_ticks", "f8"),
        ("guard_norm", "f8"),
        ("guard_dip", "f8"),
        ("heading_lost_variance", "f8"),
        ("trust_ticks", "f8"),
        ("tilt_lever", "f8"),
        ("tilt_variance", "f8"),
    ],
)
STATE = record(
    steps.STATE,
    [
        ("reference_norm", "f8"),  # tesla; zero until known
        ("reference_dip", "f8"),
        ("reference_field", "f8", 3),  # earth frame
        ("disturbance", "f8", 3),  # earth frame
        ("spread", "f8", 3),  # Q_a in the earth frame: xx xy yy
        ("smooth_norm", "f8"),
        ("smooth_dip", "f8"),
        ("last_norm", "f8"),
        ("last_dip", "f8"),
        ("heading_sum", "f8", 3),
        # Samples in a row: of the nominal field, of a foreign one, of a sound one while the heading is unknown.
        ("nominal", "i8"),
        ("mismatch", "i8"),
        ("facing", "i8"),
        ("is_detecting", "i8"),
        ("is_pinned", "i8"),  # the disturbance is held to nothing
    ],
)


@step("void(float64[:, ::1])")
def keep_blocks(p: Float) -> None:
    """Forget what orientation, offset and disturbance have to do with each other, as the published filter does (E5)."""
    for i in range(3):
        for j in range(_BIAS, STATES):
            p[i, j] = 0.0
        for j in range(BASE, STATES):
            p[_BIAS + i, j] = 0.0


@step(inlined=True)
def forget_disturbance(x: Record, p: Float, c: Record) -> None:
    """No disturbance, known to the floor (page 2.5)."""
    for i in range(3):
        x.disturbance[i] = 0.0
        for j in range(BASE + i + 1):
            p[j, BASE + i] = 0.0
        p[BASE + i, BASE + i] = c.floor_variance


@step(inlined=True)
def predict_disturbance(x: Record, p: Float, c: Record, turned: Matrix, change: float) -> None:
    """Delta' = c_d delta + w_d of variance `change`, and xi' = xi - T R b against it (page 2.3)."""
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turned
    gain = c.disturbance_gain
    for j in range(BASE, STATES):
        if gain != 1.0:
            for i in range(BASE):
                p[i, j] *= gain
            for i in range(BASE, j + 1):
                p[i, j] *= gain * gain
        x.disturbance[j - BASE] *= gain
        bx, by, bz = p[_BIAS, j], p[_BIAS + 1, j], p[_BIAS + 2, j]
        p[0, j] -= r00 * bx + r01 * by + r02 * bz
        p[1, j] -= r10 * bx + r11 * by + r12 * bz
        p[2, j] -= r20 * bx + r21 * by + r22 * bz
        p[j, j] += change
