"""Where the compiled parts of the relative-pose filter find its state, settings, memory and counts."""

import numpy as np

# Nominal state.
POSITION, VELOCITY, ATTITUDE, FORCE_BIAS, RATE_BIAS, SOURCE_FORCE_BIAS, SOURCE_RATE_BIAS = (
    0,
    3,
    6,
    10,
    13,
    16,
    19,
)
NOMINAL = 22

# Error state: the same order with three for the attitude.
E_POSITION, E_VELOCITY, E_ATTITUDE, E_FORCE, E_RATE, E_SOURCE_FORCE, E_SOURCE_RATE = 0, 3, 6, 9, 12, 15, 18
ERRORS = 21
POSE = np.r_[E_POSITION : E_POSITION + 3, E_ATTITUDE : E_ATTITUDE + 3]
"""The errors of the pose, of which an output states the covariance."""
POSE_ERRORS = tuple(POSE.tolist())
"""The same for compiled code."""

# Columns of a sample.
GYROSCOPE, ACCELEROMETER, FIELD, SOURCE_GYROSCOPE, SOURCE_ACCELEROMETER, COIL, CURRENT = (
    0,
    3,
    6,
    9,
    12,
    15,
    16,
)
SAMPLE = 17
MEASURED = COIL
"""The first so many columns are measured; the others state what the source did."""
INERTIAL = np.r_[GYROSCOPE : GYROSCOPE + 6, SOURCE_GYROSCOPE : SOURCE_GYROSCOPE + 6]

# What two samples say of the step between them, less the biases; and the rates among it, as updates take them.
S_RATE, S_FORCE, S_SOURCE_RATE, S_SOURCE_FORCE = 0, 3, 6, 9
SIGNALS = 12
R_SENSOR, R_SOURCE = 0, 3
RATES = 6

# A pulse as it was read; see `pulse.pulse_value`.
(
    PULSE_VALUE,
    PULSE_WHITE,
    PULSE_CURRENT,
    PULSE_LATE,
    PULSE_PATH,
    PULSE_AMBIENT,
    PULSE_TURNING,
    PULSE_LEVER,
) = (0, 3, 4, 5, 6, 7, 10, 11)
PULSE = 12
RING = 128
"""Samples held: the longest pulse and its baseline must fit."""
KEPT_POSITION, KEPT_ATTITUDE = SAMPLE, SAMPLE + 3
RING_COLUMNS = SAMPLE + 7
"""With each sample the pose that was predicted for it: where the sensor was at every moment of a pulse."""
PATH, PATH_COLUMNS, PATH_TURN = 16, 7, 3
"""Samples of a pulse that are predicted one by one at most; place, and turn from the source to the middle's axes."""

# Memory: last used sample, sums of the standstill, references, burst, monitoring, account, budget, watch of the
# moment.
LAST = 0
SUM_RATE, SUM_SOURCE_RATE, SUM_FORCE, SUM_SOURCE_FORCE, SUM_FIELD = 15, 18, 21, 24, 27
REFERENCE_NORM, REFERENCE_DIP = 30, 31
BURST = 32
BURST_VALUE, BURST_POSITION, BURST_ATTITUDE, BURST_CURRENT, BURST_TICK = 0, 3, 6, 10, 11
BURST_COLUMNS = 12
"""Of each of three pulses; position and attitude are the nominal ones at its middle, whose tick is the last column."""
NIS_WINDOW = BURST + 3 * BURST_COLUMNS
NIS_LENGTH = 5
ON_TIME, CHARGE, ENERGY = NIS_WINDOW + NIS_LENGTH, NIS_WINDOW + NIS_LENGTH + 1, NIS_WINDOW + NIS_LENGTH + 2
BUDGET_S = 60
"""What the source may do is limited over this long."""
BUDGET_BINS = BUDGET_S + 1
"""A bin a second; with the one that is being filled they always hold the last minute."""
BUDGET_ON = ENERGY + 1
BUDGET_SQUARED = BUDGET_ON + BUDGET_BINS
SENSITIVITY = BUDGET_SQUARED + BUDGET_BINS
"""Of the errors to a moment of the coils that differs from the stated one, per unit; see `relative.moment`."""
MOMENT_SCORE, MOMENT_INFORMATION, MOMENT_WRONG = range(SENSITIVITY + ERRORS, SENSITIVITY + ERRORS + 3)
MEMORY = MOMENT_WRONG + 1

# Counters.
COUNTERS = 25
(
    TICK,
    PHASE,
    STILL,
    PULSE_LENGTH,
    QUIET,
    PENDING,
    REQUESTED_TICK,
    STREAK,
    BURST_COIL,
    WAIT_UNTIL,
    ALARM_UNTIL,
    FIELD_BAD,
    PULSES,
    MISSED,
    SATURATED_UNTIL,
    EVENT,
    STARTED,
    MISSED_RUN,
    LAST_REQUEST,
    FAILURES,
    AT_REST,
    GAP_LENGTH,
    REFUSED,
    RESTARTED,
    WIDE_AFTER,
) = range(COUNTERS)

# Phases.
CALIBRATE, GATHER, TRACK, WAIT = 0, 1, 2, 3

# Settings.
SETTINGS = 51
(
    TIME_STEP,
    GRAVITY,
    FORCE_SIGMA,
    RATE_SIGMA,
    FIELD_SIGMA,
    FORCE_BIAS_SIGMA,
    RATE_BIAS_SIGMA,
    BIAS_DECAY,
    POSITION_LIMIT,
    ATTITUDE_LIMIT,
    ON_TICKS,
    OFF_TICKS,
    START_ON_TICKS,
    START_OFF_TICKS,
    CURRENT_SETTING,
    LEAST_CURRENT,
    CURRENT_SHARE,
    ADAPTIVE_CURRENT,
    SCALE_BY_DISTANCE,
    EARTH_FIELD,
    GAIN_SIGMA,
    PASSES,
    CALIBRATE_TICKS,
    GATE_FORCE,
    GATE_RATE,
    INCLINATION_SIGMA,
    INCLINATION_TICKS,
    FULL_SCALE,
    NIS_SOFT,
    NIS_STREAK,
    FIELD_NORM_LIMIT,
    FIELD_DIP_LIMIT,
    DISTURBED_FACTOR,
    RETRY_TICKS,
    RESPONSE_TICKS,
    ALARM_TICKS,
    FIXED_TICKS,
    PUBLISHED,
    COILS,
    STILL_RATE,
    USE_INCLINATION,
    LONGEST_RETRY_TICKS,
    MOST_ON_TIME,
    MOST_SQUARED,
    SECOND_TICKS,
    MOMENT_LIMIT,
    MOMENT_KEEP,
    NIS_ALARM,
    STREAK_PULSES,
    UNCERTAIN_POSITION,
    UNCERTAIN_ATTITUDE,
) = range(SETTINGS)

# Columns of the output.
(
    O_POSITION,
    O_ATTITUDE,
    O_VELOCITY,
    O_COVARIANCE,
    O_NIS,
    O_COIL,
    O_CURRENT,
    O_FLAGS,
    O_SCORES,
    O_TICKS,
) = (0, 3, 7, 10, 46, 47, 48, 49, 50, 53)
OUTPUT = 54
