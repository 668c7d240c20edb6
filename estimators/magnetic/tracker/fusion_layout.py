"""Where the compiled parts of the tracker fusion find state, samples, memory, settings and output."""

# Nominal state.
POSITION, VELOCITY, ATTITUDE, FORCE_BIAS, RATE_BIAS = 0, 3, 6, 10, 13
FILTER_ERROR, SOURCE_ERROR, SOURCE_FORCE_BIAS = 16, 19, 22
NOMINAL = 25

# Errors, truth minus estimate: the published 21 (eq. 6.9), the published 22 to 24 (eq. 6.19), what the source's filter
# is off (feature 16), and the offset of the source's accelerometer.
(
    E_POSITION,
    E_VELOCITY,
    E_ATTITUDE,
    E_FORCE,
    E_RATE,
    E_FIX_POSITION,
    E_FIX_ATTITUDE,
    E_FILTER,
    E_SOURCE_FILTER,
    E_SOURCE_FORCE,
) = range(0, 30, 3)
ERRORS = 30

# Columns of a sample.
GYROSCOPE, FORCE, SOURCE_FORCE, SOURCE_ATTITUDE, FILTER_ATTITUDE = 0, 3, 6, 9, 13
FIX_POSITION, FIX_ATTITUDE, FIX_COVARIANCE, FIX_VELOCITY, FIX_EFFECT = 17, 20, 24, 60, 63
SAMPLE = 81

# Memory: last sample (to the end of the source's attitude), sum of the rates at rest.
LAST, SUM_RATE = 0, 13
MEMORY = 16

# Counters.
TICK, STARTED, STILL, SINCE_ATTITUDE, STREAK, RESTARTED = range(6)
COUNTERS = 6

# Settings.
(
    TIME_STEP,
    FORCE_SIGMA,
    RATE_SIGMA,
    FORCE_WALK,
    RATE_WALK,
    FIX_POSITION_SIGMA,
    FIX_DISTANCE,
    FIX_ATTITUDE_SIGMA,
    FILTER_SIGMA,
    FILTER_TIME,
    FLOOR_POSITION,
    FLOOR_ATTITUDE,
    USE_FIX_ATTITUDE,
    USE_FILTER_ATTITUDE,
    ATTITUDE_TICKS,
    GATE,
    FIX_GATE,
    STILL_RATE,
    FORCE_START,
    RATE_START,
    BURST_MOTION,
) = range(21)
SETTINGS = 21

# Columns of the output.
O_POSITION, O_ATTITUDE, O_WORLD_POSITION, O_WORLD_VELOCITY, O_WORLD_ATTITUDE, O_COVARIANCE = (
    0,
    3,
    7,
    10,
    13,
    17,
)
O_NIS, O_STATUS = 53, 54
OUTPUT = 55

# Status bits.
INVALID, GATED, RESTART, GAP = 1, 2, 4, 8
