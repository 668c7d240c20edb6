"""Where the compiled parts of the tracker fusion find state, samples, memory, settings and output."""

# Nominal state.
POSITION, VELOCITY, ATTITUDE, FORCE_BIAS, RATE_BIAS, LEAK = 0, 3, 6, 10, 13, 16
NOMINAL = 19

# Errors, truth minus estimate: the published 21 (eq. 6.9), and an acceleration that the attitudes leak.
(
    E_POSITION,
    E_VELOCITY,
    E_ATTITUDE,
    E_FORCE,
    E_RATE,
    E_FIX_POSITION,
    E_FIX_ATTITUDE,
    E_LEAK,
) = range(0, 24, 3)
ERRORS = 24

# Columns of a sample.
GYROSCOPE, FORCE, SOURCE_FORCE, SOURCE_ATTITUDE, FILTER_ATTITUDE = 0, 3, 6, 9, 13
FIX_POSITION, FIX_ATTITUDE, FIX_COVARIANCE = 17, 20, 24
SAMPLE = 60

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
    LEAK_SIGMA,
    LEAK_TIME,
    FIX_POSITION_SIGMA,
    FIX_DISTANCE,
    FIX_ATTITUDE_SIGMA,
    FILTER_ATTITUDE_SIGMA,
    FLOOR_POSITION,
    FLOOR_ATTITUDE,
    USE_FIX_ATTITUDE,
    USE_FILTER_ATTITUDE,
    ATTITUDE_TICKS,
    GATE,
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
