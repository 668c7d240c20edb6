"""Where things stand in the arrays of the foot filter; compiled loops and their callers share these numbers.

State (STATE values): position (3, m) and velocity (3, m/s) in the world, quaternion world <- sensor (4), biases of
gyroscope (3, rad/s) and accelerometer (3, m/s^2), and the pivot: the vector from the contact point to the sensor
(3, m), the last three in sensor axes. Errors (ERRORS values) in the same order with a rotation vector in the
world for the attitude, `q_true = exp(error) * q`.
"""

from typing import Final

P, V, Q, GYROSCOPE_BIAS, ACCELEROMETER_BIAS, PIVOT = 0, 3, 6, 10, 13, 16
STATE: Final = 19
E_P, E_V, E_Q, E_GYROSCOPE_BIAS, E_ACCELEROMETER_BIAS, E_PIVOT = 0, 3, 6, 9, 12, 15
ERRORS: Final = 18

# A tick as it is released: the state, sigmas, statistic and whether the foot stands.
POSITION_SIGMA, ATTITUDE_SIGMA, STATISTIC, STANDS, COLUMNS = STATE, STATE + 3, STATE + 6, STATE + 7, STATE + 8
SIGMAS: Final = slice(POSITION_SIGMA, STATISTIC)
SIGMA_POSITION, SIGMA_ATTITUDE, SIGMA_HEADING = 0, 3, 5
"""Places among the six sigmas: of position, of attitude about x, y and z."""

# What one step looked like, for the way back: sensor-to-world matrix at mid-step, force in the world, step.
STEP_MATRIX, STEP_FORCE, STEP_TIME, STEP = 0, 9, 12, 13

# Bits of what is measured at a sample.
STANCE, STANDSTILL, HEIGHT, HEADING = 1, 2, 4, 8
MOST_ROWS: Final = 8
"""Velocity (3), standstill (3), height and heading."""

# Memory beside the state: floor level, whether it is known, the last sample, whether there was one, and the
# magnetic reference of the first stance (heading, strength, vertical part, whether it is known).
FLOOR, FLOOR_KNOWN, LAST_GYROSCOPE, LAST_ACCELEROMETER, STARTED = 0, 1, 2, 5, 8
FIELD_HEADING, FIELD_STRENGTH, FIELD_VERTICAL, FIELD_KNOWN = 9, 10, 11, 12
# Time since a stance was last believed, and the least standard deviation of that stance; zero before the first.
SINCE, BELIEVED_SIGMA, MEMORY = 13, 14, 15

# Derived constants in the order the kernel reads them.
(
    S_STANDSTILL,
    S_HEIGHT_SIGMA,
    S_HEIGHT_SCALE,
    S_HEIGHT_GATE,
    S_PIVOT_DENSITY2,
    S_GYROSCOPE_BIAS_DENSITY2,
    S_ACCELEROMETER_BIAS_DENSITY2,
    S_FIELD_SIGMA,
    S_FIELD_TOLERANCE,
    S_FLAT,
    S_GATE,
    S_GATE_RATIO,
    S_GATE_TIME,
    SETTINGS,
) = range(14)
