"""Rows of live walks: ticks that wait in rooms of fixed size, what a session's next step depends on, a pool's rows."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.balance import _live_balance_kernel as balance
from estimators.errors import ShapeError
from estimators.gait import _live_steps_kernel as steps
from estimators.gait.foot.live.rows import PIECE_TICKS, Sizes
from estimators.kernels import record
from estimators.kernels.slots import sparse_zeros
from estimators.kinetics import _live_shoes_kernel as shoe
from estimators.orientation._screen import MEMORY
from estimators.recording import Float

FIRST, COUNT = range(2)
"""Of what waits in a room: where it begins, and how many ticks."""

SESSION: Final = record(
    [
        # The tick that its pipeline has not seen; -1 before there was one.
        ("next_tick", "i8"),
        # Only `GaitPipeline.step` knows what to do with its ticks as it stands.
        ("is_general", "i8"),
        # A stretch of it was left in this call: so are those after it.
        ("waits", "i8"),
    ]
)
"""What is known of a session beside its arrays."""


class Queue:
    """Ticks that wait in their order in a room of fixed size, which compiled code may fill and empty as well.

    Parameters
    ----------
    room : ndarray, shape (R, N, W)
        R rows of W numbers a tick.
    place : ndarray of int64, shape (2,)
        `FIRST` and `COUNT`; carried on in place.
    """

    def __init__(self, room: Float, place: NDArray[np.int64]) -> None:
        self._room, self._place = room, place

    @property
    def count(self) -> int:
        """How many ticks wait."""
        return int(self._place[COUNT])

    @property
    def values(self) -> Float:
        """What waits, shape (R, K, W), a view."""
        first = int(self._place[FIRST])
        return self._room[:, first : first + self.count]

    def append(self, ticks: int) -> Float:
        """Return the place of further ticks, shape (R, K, W), which is to be filled.

        Raises
        ------
        ShapeError
            When there is no room for so many.
        """
        waiting, count = self.values, self.count
        if count + ticks > self._room.shape[1]:
            raise ShapeError(f"{count + ticks} ticks wait; there is room for {self._room.shape[1]}")
        if self._place[FIRST] + count + ticks > self._room.shape[1]:
            self._room[:, :count] = waiting
            self._place[FIRST] = 0
        stop = int(self._place[FIRST]) + count
        self._place[COUNT] += ticks
        return self._room[:, stop : stop + ticks]

    def drop(self, ticks: int) -> None:
        """Forget the first ticks."""
        self._place[FIRST] += ticks
        self._place[COUNT] -= ticks

    def refill(self, values: Float) -> None:
        """Let these ticks wait, shape (R, K, W), and no others."""
        self._place[:] = 0
        self.append(values.shape[1])[...] = values

    def go_on_in(self, room: Float, place: NDArray[np.int64]) -> None:
        """Wait in another room from now on; nothing happens in the one that it is in already."""
        if room.ctypes.data != self._room.ctypes.data:
            values = self.values
            self._room, self._place = room, place
            self.refill(values)

    def own(self) -> None:
        """Wait in a room of its own again."""
        self.go_on_in(np.zeros_like(self._room), np.zeros(2, dtype=np.int64))


def queue_room(rows: int, delay_ticks: int, width: int) -> tuple[int, int, int]:
    """Return the shape of the room in which up to `delay_ticks` wait while the next are taken.

    Twice as much as is needed, so that what waits is moved rarely.
    """
    return rows, 2 * (delay_ticks + 2 * PIECE_TICKS), width


class WalkRows(NamedTuple):
    """Rows of N sessions of S sensors on F feet, beside `FootRows`; arrays by sensor or foot have a session's together.

    Attributes
    ----------
    session : ndarray of SESSION, shape (N,)
    screen : ndarray, shape (N * S, MEMORY)
        What judging the next sample depends on.
    steps_settings : ndarray, shape (N, SETTINGS)
    steps : ndarray, shape (N * F, FOOT)
        As `LiveStepTracker`.
    waiting : ndarray, shape (N, 1, K, W)
        Released and not yet shown; with `waiting_place` a `Queue`.
    waiting_place : ndarray of int64, shape (N, 2)
    loads : ndarray, shape (N, 2, K, LOADS)
        Of the ticks that are not released; with `loads_place` a `Queue`. This and what follows as `LiveShoes`.
    loads_place : ndarray of int64, shape (N, 2)
    shoe_settings, balance_settings : ndarray, shape (N, SETTINGS) each
    shoes : ndarray, shape (N * 2, SHOE)
    balance_memory : ndarray, shape (N, MEMORY)
    x, p : ndarray, shapes (N, 2, STATES), (N, STATES, STATES)
    """

    session: NDArray[np.void]
    screen: Float
    steps_settings: Float
    steps: Float
    waiting: Float
    waiting_place: NDArray[np.int64]
    loads: Float
    loads_place: NDArray[np.int64]
    shoe_settings: Float
    balance_settings: Float
    shoes: Float
    balance_memory: Float
    x: Float
    p: Float


class WalkTables(NamedTuple):
    """What all sessions of a pool share.

    Attributes
    ----------
    channels : int
        Two, or three with a magnetometer.
    sensors : int
        Worn; `order` says which of them the filter follows.
    order : ndarray of int64, shape (S,)
    screen_step_s : float
        Seconds of a tick, for judging samples.
    sizes, step_s, coast, scales, decision, noise, settings
        As of `ordinary_kernel.release`.
    heels, right, offset_m : ndarray
        As `released_kernel.Feet`.
    has_shoes : int
        1 with forces.
    width, force_at, moment_at : int
        Columns of what comes beside motion; -1 where no force or no moment comes.
    take, release, write : int
        Where the kernels of `ordinary_kernel` are, and that of `released_kernel` (`address_of`).
    """

    channels: int
    sensors: int
    order: NDArray[np.int64]
    screen_step_s: float
    sizes: Sizes
    step_s: float
    coast: float
    scales: Float
    decision: Float
    noise: Float
    settings: Float
    heels: NDArray[np.int64]
    right: NDArray[np.uint8]
    offset_m: Float
    has_shoes: int
    width: int
    force_at: int
    moment_at: int
    take: int
    release: int
    write: int


class WalkWork(NamedTuple):
    """Room for one stretch of the sensors that are followed.

    Attributes
    ----------
    rate, force, field : ndarray, shape (values,)
    quality, wild : ndarray of uint8, shape (samples,)
    screen : ndarray, shape (S, MEMORY)
        As it was before, for a stretch that is left.
    """

    rate: Float
    force: Float
    field: Float
    quality: NDArray[np.uint8]
    wild: NDArray[np.uint8]
    screen: Float


def walk_rows(sessions: int, sensors: int, feet: int, delay_ticks: int, width: int) -> WalkRows:
    """Return rows for so many sessions; memory is used only where a session is."""
    return WalkRows(
        np.zeros(sessions, dtype=SESSION),
        np.zeros((sessions * sensors, MEMORY)),
        np.zeros((sessions, steps.SETTINGS)),
        np.zeros((sessions * feet, steps.FOOT)),
        sparse_zeros((sessions, *queue_room(1, delay_ticks, width))),
        np.zeros((sessions, 2), dtype=np.int64),
        sparse_zeros((sessions, *queue_room(2, delay_ticks, shoe.LOADS))),
        np.zeros((sessions, 2), dtype=np.int64),
        np.zeros((sessions, shoe.SETTINGS)),
        np.zeros((sessions, balance.SETTINGS)),
        np.zeros((2 * sessions, shoe.SHOE)),
        np.zeros((sessions, balance.MEMORY)),
        np.zeros((sessions, 2, balance.STATES)),
        np.zeros((sessions, balance.STATES, balance.STATES)),
    )


def walk_work(sensors: int) -> WalkWork:
    """Return room for a stretch of up to `PIECE_TICKS`."""
    samples = sensors * PIECE_TICKS
    return WalkWork(
        np.empty(3 * samples),
        np.empty(3 * samples),
        np.empty(3 * samples),
        np.empty(samples, dtype=np.uint8),
        np.empty(samples, dtype=np.uint8),
        np.empty((sensors, MEMORY)),
    )
