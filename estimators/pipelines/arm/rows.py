"""Records and rows of pooled arm sessions: what differs between sessions, what they share, where a step works."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.arm import ArmModel
from estimators.balance import MASS_SCALARS
from estimators.balance.mass_centre._worn_kernel import SETTINGS, TARGETS
from estimators.kernels import record
from estimators.leg._kernel import LegTable
from estimators.orientation._screen import MEMORY
from estimators.orientation.telemotion._records import STATE, STATES
from estimators.recording import Float

LENGTHS: Final = 7
ANGLES: Final = 18
"""Of the arm model, see `ArmModel.initial_previous`."""

SESSION: Final = record(
    [
        ("has_force_bias", "i8"),
        ("has_mounting", "i8"),
        ("memory_stride", "i8"),
        ("step_s", "f8"),
    ]
)
"""What is known of a session beside arrays by sensor."""


class ArmRows(NamedTuple):
    """Rows of N sessions of S sensors; arrays by sensor have N * S rows, so that a session's are one piece.

    Attributes
    ----------
    session : ndarray of SESSION, shape (N,)
    state : ndarray of the filter's STATE, shape (N * S,)
    covariance : ndarray, shape (N * S, STATES, STATES)
    screen : ndarray, shape (N * S, MEMORY)
        What judging the next sample depends on.
    q_room_earth, q_sensor_segment : ndarray, shape (N * S, 4)
    mounting_variance, force_bias : ndarray, shape (N * S, 3)
    more_flags : ndarray of uint8, shape (N * S,)
    previous_angle : ndarray, shape (N, 18)
    memory_tick : ndarray of int64, shape (N, M)
        Orientation remembered for a calibration pose.
    memory_q : ndarray, shape (N, M, S, 4)
    memory_flags : ndarray of uint8, shape (N, M, S)
    lever : ndarray, shape (N, TARGETS, S, 3)
        Of the centre of mass, with `doubt`, `has_doubt` and `feet`; see `WornMassCentre`.
    doubt : ndarray, shape (N, TARGETS, S, 3, 3)
    has_doubt : ndarray of uint8, shape (N, S)
    feet : ndarray, shape (N, 2, 3)
    mass_middle : ndarray, shape (N, 3)
    mass_settings : ndarray, shape (N, SETTINGS)
    lengths : ndarray, shape (N, 7)
        Of the arm model.
    """

    session: NDArray[np.void]
    state: NDArray[np.void]
    covariance: Float
    screen: Float
    q_room_earth: Float
    q_sensor_segment: Float
    mounting_variance: Float
    force_bias: Float
    more_flags: NDArray[np.uint8]
    previous_angle: Float
    memory_tick: NDArray[np.int64]
    memory_q: Float
    memory_flags: NDArray[np.uint8]
    lever: Float
    doubt: Float
    has_doubt: NDArray[np.uint8]
    feet: Float
    mass_middle: Float
    mass_settings: Float
    lengths: Float


class ArmTables(NamedTuple):
    """What all sessions of a pool share.

    Attributes
    ----------
    channels : int
        Two, or three with a magnetometer.
    settings : ndarray of the filter's SETTINGS, shape (1,)
    source, point_column, angle_column, scalar_column : ndarray of int64
        Of the arm model.
    mass_source : ndarray of int64
        Of the centre of mass; empty where the sensors worn give none.
    legs : LegTable
        Without joints where the sensors worn show none of a leg.
    filter_at, model_at, legs_at, mass_at : int
        Addresses of the kernels of filter, arm model, legs and centre of mass, see `estimators.kernels.by_address`.
    """

    channels: int
    settings: NDArray[np.void]
    source: NDArray[np.int64]
    point_column: NDArray[np.int64]
    angle_column: NDArray[np.int64]
    scalar_column: NDArray[np.int64]
    mass_source: NDArray[np.int64]
    legs: LegTable
    filter_at: int
    model_at: int
    legs_at: int
    mass_at: int


class ArmWork(NamedTuple):
    """Room for one stretch: samples that were corrected, by the samples of a sensor; the filter's estimates.

    Attributes
    ----------
    rate, force, field, q, bias, sigma : ndarray, shape (values,)
    wild, quality, flags : ndarray of uint8, shape (samples,)
    omega : ndarray, shape (values,)
    """

    rate: Float
    force: Float
    field: Float
    q: Float
    bias: Float
    sigma: Float
    omega: Float
    wild: NDArray[np.uint8]
    quality: NDArray[np.uint8]
    flags: NDArray[np.uint8]


def arm_rows(sessions: int, sensors: int, memory_ticks: int) -> ArmRows:
    """Return rows for so many sessions; memory is used only where a session is."""
    both = sessions * sensors
    return ArmRows(
        np.zeros(sessions, dtype=SESSION),
        np.zeros(both, dtype=STATE),
        np.zeros((both, STATES, STATES)),
        np.zeros((both, MEMORY)),
        np.zeros((both, 4)),
        np.zeros((both, 4)),
        np.zeros((both, 3)),
        np.zeros((both, 3)),
        np.zeros(both, dtype=np.uint8),
        np.zeros((sessions, ANGLES)),
        np.zeros((sessions, memory_ticks), dtype=np.int64),
        np.zeros((sessions, memory_ticks, sensors, 4)),
        np.zeros((sessions, memory_ticks, sensors), dtype=np.uint8),
        np.zeros((sessions, TARGETS, sensors, 3)),
        np.zeros((sessions, TARGETS, sensors, 3, 3)),
        np.zeros((sessions, sensors), dtype=np.uint8),
        np.zeros((sessions, 2, 3)),
        np.zeros((sessions, 3)),
        np.zeros((sessions, SETTINGS)),
        np.zeros((sessions, LENGTHS)),
    )


def arm_work(sensors: int, most_ticks: int) -> ArmWork:
    """Return room for a stretch of up to so many ticks."""
    samples = sensors * most_ticks
    vectors = 3 * samples
    return ArmWork(
        rate=np.empty(vectors),
        force=np.empty(vectors),
        field=np.empty(vectors),
        q=np.empty(4 * samples),
        bias=np.empty(vectors),
        sigma=np.empty(vectors),
        omega=np.empty(vectors),
        wild=np.empty(samples, dtype=np.uint8),
        quality=np.empty(samples, dtype=np.uint8),
        flags=np.empty(samples, dtype=np.uint8),
    )


assert len(ArmModel.initial_previous()) == ANGLES
assert len(MASS_SCALARS) == 6
