"""Where the compiled parts of Roetenberg's filter find its settings, memory and counts."""

from estimators.orientation import _strapdown_steps as steps

# Positions in the settings, after the shared ones.
(
    USE_GRAVITY,
    USE_FIELD,
    COMPENSATE,
    BLOCKS_ONLY,
    RAW_DETECTOR,
    HELD_ACCELERATION,
    CHANGE_VARIANCE,
    FORCE_VARIANCE,
    FIELD_VARIANCE,
    DISTURBANCE_GAIN,
    SMOOTHING,
    DEAD_BAND,
    NORM_GAIN,
    DIP_GAIN,
    FLOOR_VARIANCE,
    NOMINAL_NORM,
    NOMINAL_DIP,
    NOMINAL_TICKS,
    GUARD_NORM,
    GUARD_DIP,
    HEADING_LOST,
    TRUST_TICKS,
    TILT_LEVER,
    TILT_VARIANCE,
) = range(steps.SHARED_SETTINGS, steps.SHARED_SETTINGS + 24)
SETTINGS = steps.SHARED_SETTINGS + 24

# Columns of the memory, after the shared ones. Norms are over that of the reference, dips in radians; the
# reference norm is in tesla, zero until known. SPREAD is Q_a in the earth frame: xx xy yy.
(
    REFERENCE_NORM,
    REFERENCE_DIP,
    SMOOTH_NORM,
    SMOOTH_DIP,
    LAST_NORM,
    LAST_DIP,
    HEADING_SUM,
) = range(steps.MEMORY, steps.MEMORY + 7)
REFERENCE_FIELD = steps.MEMORY + 9
DISTURBANCE = REFERENCE_FIELD + 3
SPREAD = DISTURBANCE + 3
MEMORY = SPREAD + 3

# Columns of the counters, after the shared ones.
NOMINAL, MISMATCH, DETECTING, FACING, PINNED = range(steps.COUNTERS, steps.COUNTERS + 5)
COUNTERS = steps.COUNTERS + 5

STATES = 9
"""Orientation error in the earth frame, offset error in the sensor frame, disturbance error in the earth frame."""

# Columns of the details after acceleration and innovations.
INNOVATIONS = 5
DETAIL_DISTURBANCE, DETAIL_NORM, DETAIL_DIP = 8, 11, 12
DETAILS = 13

# Positions in a sample after what is prepared: what is to be done with it; its variance of the heading; whether its
# field is measured, that of the reference, one to be flagged; whether its disturbance is held to nothing.
ACTION, HEADING_VARIANCE, MEASURED, IS_NOMINAL, IS_FOREIGN, HELD = range(steps.SAMPLE, steps.SAMPLE + 6)
SAMPLE = steps.SAMPLE + 6
