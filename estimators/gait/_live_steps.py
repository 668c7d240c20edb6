"""Footholds, course and foot angle of both feet while somebody walks."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.gait import _live_steps_kernel as at
from estimators.gait.foot.live import FootChunk
from estimators.gait.foot.trajectory import FootFlag
from estimators.recording import Float

USUAL_APART_M: Final = 0.15
"""Feet are put this far apart where nobody says how far they are."""
_LEAST_MOVE_M, _FIRST_WAY_M, _SURE_WAY_M = 0.08, 0.3, 3.0
_STRAIGHT_RAD, _GAIN, _FLAT_S = 0.25, 0.3, 0.12


@dataclass(frozen=True)
class LiveSteps:
    """What K released samples of F feet say.

    Attributes
    ----------
    place_m : ndarray, shape (K, F, 3)
        Of the sensors in the room: x along the course of the first strides, the feet side by side at the start.
        Before a foot is placed, in its own world.
    course_rad : ndarray, shape (K, F)
        By which each foot's world is turned against the room.
    is_placed : ndarray of bool, shape (K, F)
        Whether the foot has gone far enough to say where the course is.
    toe_out_rad, stride_length_m : ndarray, shape (K, F)
        Of the last stride; NaN before the first.
    q_room_sensor : ndarray, shape (K, F, 4)
    is_lost : ndarray of bool, shape (K, F)
        Where the foot is in the room of before is not known, since a long gap. A foot that goes beside one that was
        not lost is found again, to half a step.
    is_joined : ndarray of bool, shape (K, F)
        Ticks at which a foot that was lost was put beside the other.
    """

    place_m: Float
    course_rad: Float
    is_placed: NDArray[np.bool_]
    toe_out_rad: Float
    stride_length_m: Float
    q_room_sensor: Float
    is_lost: NDArray[np.bool_]
    is_joined: NDArray[np.bool_]


class LiveStepTracker:
    """Follows footholds of one or both feet; chunks give the same as one batch, bit for bit.

    Each foot's world has the heading of its sensor at its first sample. The course of the first metres turns it into
    the room; from then on each foot's heading is its own, and on straight ways, where both feet go one course, the
    two are held together. Nothing is rewritten: a place that was given stays as it was given.

    After a long gap a foot begins anew where it was lost, in a frame of its own that its first strides turn to the
    room's x axis. On a straight way it is then put beside the other foot, where feet go that walk: on the same course,
    half a stride off, as far aside as at the start. If only one was lost, it is thereby found again.

    Parameters
    ----------
    apart_m : float, optional
        Distance of the heels at the start.
    height_m : float
        Of the sensors above the floor.
    has_foot_axes : bool
        Whether sensor axes are those of the foot, as in instrumented shoes; else they are found from the walk.
    """

    version = "2"

    def __init__(
        self,
        sides: tuple[Side, ...],
        time_step_s: float,
        apart_m: float | None = None,
        *,
        height_m: float = 0.0,
        has_foot_axes: bool = False,
    ) -> None:
        self._settings = np.zeros(at.SETTINGS)
        self._settings[at.S_STEP] = time_step_s
        self._settings[at.S_LEAST_M], self._settings[at.S_FIRST_M] = _LEAST_MOVE_M, _FIRST_WAY_M
        self._settings[at.S_SURE_M], self._settings[at.S_STRAIGHT_RAD] = _SURE_WAY_M, _STRAIGHT_RAD
        self._settings[at.S_GAIN], self._settings[at.S_FLAT_S] = _GAIN, _FLAT_S
        self._settings[at.S_KNOWN_AXES] = float(has_foot_axes)
        self._settings[at.S_APART_M] = USUAL_APART_M if apart_m is None else apart_m
        self._feet = np.zeros((len(sides), at.FOOT))
        for number, side in enumerate(sides):
            aside = 0.5 * self._settings[at.S_APART_M]
            self._feet[number, at.ANCHOR_ROOM + 1] = aside if side == "left" else -aside
            self._feet[number, at.ANCHOR_ROOM + 2] = height_m
        self._right = np.array([[4 * (side == "right")] for side in sides], dtype=np.uint8)

    @property
    def settings(self) -> Float:
        """Constants of the loop, shape (SETTINGS,)."""
        return self._settings

    @property
    def memory(self) -> Float:
        """What the next update depends on, shape (F, FOOT): carried on in place."""
        return self._feet

    @property
    def right(self) -> NDArray[np.uint8]:
        """4 for a right foot, shape (F, 1)."""
        return self._right

    def update(self, released: FootChunk, rows: "list[int] | slice" = slice(None)) -> LiveSteps:
        """Take the next released samples; `rows` are those of the feet among the sensors."""
        nothing = (released.flags[rows] & FootFlag.INVALID) != 0
        anew = (released.flags[rows] & FootFlag.BEGINS_ANEW) != 0
        bits = np.asarray(released.is_stance[rows] + 2 * nothing + 8 * anew, dtype=np.uint8) | self._right
        out = np.empty((released.tick_count, len(self._feet), at.OUT))
        at.follow(
            self._settings,
            np.ascontiguousarray(released.q_world_sensor[rows]),
            np.ascontiguousarray(released.position_m[rows]),
            bits,
            self._feet,
            out,
        )
        return LiveSteps(
            out[:, :, at.O_PLACE : at.O_PLACE + 3],
            out[:, :, at.O_COURSE],
            out[:, :, at.O_PLACED] > 0.0,
            out[:, :, at.O_TOE_OUT],
            out[:, :, at.O_LENGTH],
            out[:, :, at.O_Q : at.O_Q + 4],
            out[:, :, at.O_LOST] > 0.0,
            out[:, :, at.O_JOINED] > 0.0,
        )

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next update depends on."""
        return {"steps": self._feet.copy()}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        self._feet = np.array(state["steps"], dtype=np.float64)
