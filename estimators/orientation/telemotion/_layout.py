"""Where the numbers of our own filter stand: error states, memory per sensor, counts, settings.

The error state is earth-fixed and left (R_true = Exp(turn) R). Earth here is the *start frame*: z up, heading
as the first sample had it. The magnetic field is a state in this frame with all three components, so that an
unknown heading is no large angle in the filter: north is where the estimated field points.
"""

# Positions in the error state and, from VELOCITY on, in the nominal state (the bias has its own array).
TURN = 0
"""Attitude error about the axes of the start frame, rad."""
VELOCITY, POSITION = 3, 6
"""m/s and m in the start frame; they exist to weigh specific force, not to be used."""
BIAS = 9
"""Gyroscope bias, rad/s."""
GAIN = 12
"""Gyroscope scale and axis errors K, nine, column-major: rate = (I + K) measured - bias."""
FIELD = 21
"""Mean magnetic field of the surroundings in the start frame, microtesla."""
IRON = 24
"""Hard iron in sensor axes, microtesla."""
DELAY = 27
"""Delay of the magnetometer against the gyroscope, s."""
START = 28
"""Field at the place of the first rest minus FIELD, microtesla."""
STATES = 31

# Memory of a sensor: the nominal state, then sums over the present block.
SUM_ROTATION = STATES
SUM_GAIN = SUM_ROTATION + 9
SUM_FORCE = SUM_GAIN + 27
SUM_FIELD = SUM_FORCE + 3
SUM_DELAY = SUM_FIELD + 3
SUM_RATE2 = SUM_DELAY + 3
GAP_TURN_VARIANCE, GAP_SPEED_VARIANCE = SUM_RATE2 + 1, SUM_RATE2 + 4
# Rest: exponential means and total variances; gravity measured at rest.
MEAN_RATE = GAP_SPEED_VARIANCE + 3
MEAN_FORCE = MEAN_RATE + 3
RATE_SPREAD, FORCE_SPREAD, REST_S, GRAVITY, GRAVITY_COUNT = range(MEAN_FORCE + 3, MEAN_FORCE + 8)
# Magnetic surroundings: share of START in the field, level of disturbance, test for a new hard iron.
START_SHARE, DISTURBANCE, MISFIT, IRON_S = range(GRAVITY_COUNT + 1, GRAVITY_COUNT + 5)
SENSOR_MEAN = IRON_S + 1
EARTH_MEAN = SENSOR_MEAN + 3
SENSOR_SPREAD, EARTH_SPREAD = EARTH_MEAN + 3, EARTH_MEAN + 4
IRON_KNOWN = EARTH_SPREAD + 1
IRON_KNOWN_VARIANCE = IRON_KNOWN + 3
# Output: correction of the start frame to north, offset that is being taken back, variances.
CORRECTION = IRON_KNOWN_VARIANCE + 1
OFFSET = CORRECTION + 4
HEADING_VARIANCE = OFFSET + 3
TILT_VARIANCE = HEADING_VARIANCE + 1
# Gaps: last and previous measured sample (gyroscope, accelerometer, magnetometer), first one after.
LAST_SAMPLE = TILT_VARIANCE + 2
SLOPE = LAST_SAMPLE + 9
AFTER_SAMPLE = SLOPE + 6
COAST = AFTER_SAMPLE + 9
# Odds of the nine hypotheses on hard iron and start place.
ODDS = COAST + 4
SHOWN = ODDS + 9
"""The last output, held where there is no estimate."""
# Clip levels (infinite until reached), and the largest component seen so far, of rate and of force.
CLIP_LEVEL = SHOWN + 4
LARGEST = CLIP_LEVEL + 2
# First rest: raw field that was last seen steady, for how long, and whether it changed before it was trusted;
# mean squared residual of the field where the sensor moves.
STEADY_FIELD = LARGEST + 2
STEADY_S, RESTLESS, REGION = STEADY_FIELD + 3, STEADY_FIELD + 4, STEADY_FIELD + 5
# How far the field is from the model's where turning does not explain it, mean square of a component.
QUIET = REGION + 1
# Rest: mean rate of this rest, and how far the mean of half a second sways about it, squared.
REST_MEAN, REST_SWAY = QUIET + 1, QUIET + 4
# Start in movement: whether it is one, sum of the squared force; speed gained since the start in the start frame,
# summed up, summed up times its place, and its square summed up.
START_MOVING, START_FORCE2 = REST_SWAY + 1, REST_SWAY + 2
START_SPEED = START_FORCE2 + 1
START_LEVER = START_SPEED + 3
START_SPEED2 = START_LEVER + 3
# Whether force contradicts the tilt: its sum over the window in the start frame, and the time it holds.
UP_SUM = START_SPEED2 + 1
UP_S = UP_SUM + 3
# First field met in movement: for how long it has fitted; another one, and for how long that has.
SUPPORT_S, OTHER, OTHER_S = UP_S + 1, UP_S + 2, UP_S + 5
MEMORY = OTHER_S + 1

# Counts of a sensor.
TICK, PHASE, COUNT, FIELD_COUNT, GAP, PENDING, SINCE_START, CLIPPED, FIELD_KNOWN, OPENED, FILTERED = range(11)
AT_LARGEST = 11
"""Number of the next tick; IDLE, COLLECTING or RUNNING; samples, and samples with a field, in the block; ticks
since the last measured sample; one sample has come after a gap (the next gives its slope); ticks since the
(re)start; consecutive saturated samples; a field was seen; hard irons found; the filter has
run. AT_LARGEST: samples that were exactly the largest rate, and force."""
COUNTERS = 13
IDLE, COLLECTING, RUNNING = 0, 1, 2

# One prepared sample: raw rate, specific force, field (microtesla), has a field, is saturated.
RATE, FORCE, MAGNETIC, HAS_FIELD, SATURATED = 0, 3, 6, 9, 10
SAMPLE = 11

# Settings: derived constants in the units above.
(
    STEP_S,
    BLOCK_TICKS,
    HYPOTHESIS_BLOCKS,
    START_TICKS,
    MOVING_TICKS,
    FALLING_TICKS,
    COAST_TICKS,
    CONVERGENCE_TICKS,
    TILT_START,
    TILT_RESTART,
    HEADING_RESTART,
    SPEED_START,
    FIELD_START,
    BIAS_DRIFT,
    RATE_NOISE,
    RATE_NOISE_PER_RATE,
    SPEED_NOISE,
    POSITION_NOISE,
    POSITION_PRIOR,
    REST_RATE,
    REST_FORCE,
    REST_MINIMUM_S,
    REST_SPEED,
    REST_BIAS,
    REST_GAIN,
    FIELD_NOISE_MOVING,
    FIELD_NOISE_REST,
    FIELD_NOISE_START,
    FIELD_SCALE,
    FIELD_LEVEL_S,
    START_LEAVING_S,
    IRON_WINDOW_S,
    IRON_RATIO,
    IRON_WIDE,
    IRON_NARROW,
    IRON_MIDDLE,
    IRON_NARROW_ODDS,
    IRON_MIDDLE_ODDS,
    START_WIDE,
    START_NARROW,
    START_MIDDLE,
    START_NARROW_ODDS,
    START_MIDDLE_ODDS,
    GAP_SHARE,
    CLIP_RATE,
    CLIP_FORCE,
    RETURN_GAIN,
    RETURN_STEP,
    LEAD_S,
    FORCE_TOLERANCE,
    TILT_SCALE,
    HEADING_SCALE,
    TILT_FLOOR,
    HEADING_FLOOR,
    HEADING_LOST,
    STEADY_CHANGE,
    STEADY_TRUSTED_S,
    FIELD_SAME_S,
    REGION_BASE,
    REGION_SHARE,
    REGION_S,
    TURN_FREE,
    QUIET_LEVEL,
    QUIET_S,
    QUIET_LEAST,
    REST_SURPRISE,
    REST_SURE_S,
    REST_SWAY_S,
    BIAS_START,
    UP_WINDOW_S,
    UP_LIMIT,
) = range(71)
SETTINGS = 71
