"""Records of our own filter: settings, memory of a sensor, sums of a block, a sample; and places of its error states.

The error state is earth-fixed and left (R_true = Exp(turn) R). Earth here is the *start frame*: z up, heading
as the first sample had it. The magnetic field is a state in this frame with all three components, so that an
unknown heading is no large angle in the filter: north is where the estimated field points.
"""

from typing import Final

from estimators.kernels import Fields, fields_of, record
from estimators.orientation.telemotion._parameters import TelemotionParameters, settings_of

# Places in the error state and its covariance.
TURN: Final = 0
"""Attitude error about the axes of the start frame, rad."""
VELOCITY: Final = 3
POSITION: Final = 6
"""m/s and m in the start frame; they exist to weigh specific force, not to be used."""
BIAS: Final = 9
"""Gyroscope bias, rad/s."""
GAIN: Final = 12
"""Gyroscope scale and axis errors K, nine, column-major: rate = (I + K) measured - bias."""
FIELD: Final = 21
"""Mean magnetic field of the surroundings in the start frame, microtesla."""
IRON: Final = 24
"""Hard iron in sensor axes, microtesla."""
DELAY: Final = 27
"""Delay of the magnetometer against the gyroscope, s."""
START: Final = 28
"""Field at the place of the first rest minus FIELD, microtesla."""
OFFSET: Final = 31
"""Offset of the accelerometer in sensor axes, m/s^2."""
WEIGHT: Final = 34
"""What the accelerometer shows of gravity at rest, m/s^2: gravity and the common error of its scale."""
STATES: Final = 35
LEAST_LEVEL: Final = 9.0
"""Squared microtesla: a field that points straight down tells no heading."""

IDLE, COLLECTING, RUNNING = 0, 1, 2
"""Phases of a sensor."""


def _floats(*names: str) -> Fields:
    return [(name, "f8") for name in names]


def _vectors(*names: str) -> Fields:
    return [(name, "f8", 3) for name in names]


def _counts(*names: str) -> Fields:
    return [(name, "i8") for name in names]


_SUMS: Fields = [
    ("sum_rotation", "f8", 9),
    ("sum_gain", "f8", 27),
    *_vectors("sum_force", "sum_field", "sum_delay"),
    ("sum_rate2", "f8"),
    *_vectors("gap_turn_variance", "gap_speed_variance"),
    # Samples, and samples with a field.
    *_counts("count", "field_count"),
]
SUMS: Final = record(_SUMS)
"""Sums over a block (see `integrate`), and what gaps and clipping add to its noise."""

STATE: Final = record(
    # The nominal state, in the units of the error state.
    [("q", "f8", 4), ("gain", "f8", 9)],
    _vectors("bias", "velocity", "position", "field", "iron", "start", "force_offset"),
    _floats("delay"),
    # Rest: exponential means and total variances; gravity measured at rest. Mean rate of this rest, and how far the
    # mean of half a second sways about it, squared.
    _vectors("mean_rate", "mean_force", "rest_mean"),
    _floats("rate_spread", "force_spread", "rest_s", "gravity", "rest_sway"),
    # Magnetic surroundings: share of `start` in the field, level of disturbance; mean squared residual of the field
    # where the sensor moves, and of a component where turning does not explain it.
    _floats("start_share", "disturbance", "misfit", "quiet", "wander", "wander_doubted", "moved_s"),
    _vectors("slow_residual"),
    # Test for a new hard iron; the one that was known beforehand.
    _vectors("sensor_mean", "earth_mean", "iron_known"),
    _floats("sensor_spread", "earth_spread", "iron_s", "iron_known_variance"),
    # Output: correction of the start frame to north, offset that is being removed, variances; the last output,
    # held where there is no estimate.
    [("correction", "f8", 4), ("shown", "f8", 4), ("tilt_variance", "f8", 2)],
    _vectors("offset"),
    _floats("heading_variance"),
    # Gaps: last measured sample and its difference from the one before, first sample after, attitude shown inside.
    _vectors("last_rate", "last_force", "last_field", "slope_rate", "slope_force"),
    _vectors("after_rate", "after_force", "after_field"),
    [("coast", "f8", 4)],
    # Odds of the nine hypotheses on hard iron and start place.
    [("odds", "f8", 9)],
    # Of rate and of force: clip level (infinite until reached), largest component so far, and how often it was seen.
    [("clip_level", "f8", 2), ("largest", "f8", 2), ("at_largest", "i8", 2), ("near_largest", "i8", 2)],
    # First rest: raw field that was last seen steady, for how long, and whether it changed before it was trusted.
    _vectors("steady_field"),
    _floats("steady_s", "restless"),
    # Start in movement: whether it is one, sum of the squared force; speed gained since the start in the start frame,
    # summed up, summed up times its place, and its square summed up.
    _vectors("start_speed", "start_lever"),
    _floats("start_moving", "start_force2", "start_speed2"),
    # Whether force contradicts the tilt: its sum over the window in the start frame, and the time it holds.
    _vectors("up_sum"),
    _floats("up_s", "up_square"),
    # First field met in movement: for how long it has fitted; another one, and for how long that has.
    _vectors("other"),
    _floats("support_s", "other_s"),
    # Number of the next tick; phase; ticks since the last measured sample; one sample has come after a gap (the next
    # gives its slope); ticks since the (re)start; consecutive saturated samples; a field was seen; hard irons found;
    # the filter has run; the gains are those of a good device; the last
    # block was at rest.
    _counts("tick", "phase", "gap", "pending", "since_start", "clipped", "field_known", "opened", "filtered"),
    _counts("gains_settled", "rested"),
    # Last, for numba takes a record that only adds to the end of another for a kind of that one.
    _SUMS,
)
"""What is carried from sample to sample, a record a sensor, apart from the covariance (STATES, STATES)."""

SAMPLE: Final = record(_vectors("rate", "force", "field"), _counts("has_field", "saturated"))
"""One tick: raw rate, specific force, field in microtesla."""

SETTINGS: Final = record(fields_of(settings_of(TelemotionParameters(), 1.0)))
"""Constants derived from the parameters, in the units above: those of `settings_of`, in its order."""
