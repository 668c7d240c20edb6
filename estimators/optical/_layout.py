"""Where the compiled parts of the optical-inertial filter find its state, settings and outputs."""

# Nominal state: position and velocity in the laboratory, attitude (wxyz), biases and lever arm in sensor axes.
POSITION, VELOCITY, ATTITUDE, FORCE_BIAS, RATE_BIAS, LEVER = 0, 3, 6, 10, 13, 16
NOMINAL = 19
# Errors, true minus estimate: position, velocity, attitude in the laboratory frame, biases, lever arm.
E_POSITION, E_VELOCITY, E_ATTITUDE, E_FORCE, E_RATE, E_LEVER = 0, 3, 6, 9, 12, 15
ERRORS = 18
# A sample: gyroscope, accelerometer, marker, by how much the marker's frame is later than the tick, and how many times
# noisier than assumed the rate and the force are.
GYROSCOPE, ACCELEROMETER, MARKER, DELAY, RATE_NOISE, FORCE_NOISE = 0, 3, 6, 9, 10, 11
SAMPLE = 12
# Memory: the last sample, markers shut out in a row, ticks since one was taken.
STREAK, COASTING = SAMPLE, SAMPLE + 1
MEMORY = SAMPLE + 2
(
    TIME_STEP,
    GRAVITY,
    FORCE_SIGMA,
    RATE_SIGMA,
    MARKER_SIGMA,
    FORCE_WALK,
    RATE_WALK,
    GATE,
    RECOVER_TICKS,
) = range(9)
SETTINGS = 9
O_ACCELERATION, O_NIS, O_STATE, O_GROWTH, O_INNOVATION, O_SIGMA = 0, 3, 4, 5, 6, 9
OUTPUT = O_SIGMA + ERRORS
RECOVER_COUNT = 3
# What became of a tick.
BEFORE, COASTED, MEASURED, REJECTED, RECOVERED = 0, 1, 2, 3, 4
