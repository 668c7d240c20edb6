"""Two instrumented shoes while somebody walks: ground reaction, pressure, centre of mass and what is wrong."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.balance import MassCentreParameters
from estimators.balance import _live_balance_kernel as balance
from estimators.balance._stability import SOLE_HALF_WIDTH_M
from estimators.conventions import GRAVITY_MPS2
from estimators.gait import FootChunk, FootFlag, LiveSteps
from estimators.kinetics import ShoeGeometry
from estimators.kinetics import _live_shoes_kernel as shoe
from estimators.recording import Float

_APART_SIGMA_M: Final = {True: 0.01, False: 0.04}
"""Of the distance of the feet at the start: measured, or only the usual one."""
_WANDER_M_PER_ROOT_S: Final = 0.01
"""The ways of the two feet drift apart; what is lost in a stride is 1 to 2 cm."""


_HEELS, _FOREFEET = [0, 2], [1, 3]
_CELLS = [[0, 1], [2, 3]]


class LiveShoes:
    """Forces of two shoes on their way behind the feet; chunks give the same as one batch, bit for bit.

    Parameters
    ----------
    time_step_s : float
    height_m : float
        Of the centre of mass of the person who stands.
    is_apart_measured : bool
        Whether somebody measured how far the feet stand apart at the start.
    ahead_ticks : int
        How far the forces are always known beyond what is released of the feet.
    geometry : ShoeGeometry, optional
    """

    version = "1"

    def __init__(
        self,
        time_step_s: float,
        height_m: float,
        *,
        is_apart_measured: bool,
        ahead_ticks: int,
        geometry: ShoeGeometry | None = None,
    ) -> None:
        size, noise = geometry or ShoeGeometry(), MassCentreParameters()
        self._shoe_settings = np.zeros(shoe.SETTINGS)
        for place, value in (
            (shoe.S_STEP, time_step_s),
            (shoe.S_SENSOR_HEIGHT, size.sensor_height_m),
            (shoe.S_HINGE, size.hinge_m),
            (shoe.S_FOREFOOT, size.forefoot_sensor_m),
            (shoe.S_REAR, size.rear_edge_m),
            (shoe.S_TOE, size.toe_edge_m),
            (shoe.S_HALF_WIDTH, SOLE_HALF_WIDTH_M),
        ):
            self._shoe_settings[place] = value
        self._settings = np.zeros(balance.SETTINGS)
        for place, value in (
            (balance.S_STEP, time_step_s),
            (balance.S_GRAVITY, GRAVITY_MPS2),
            (balance.S_HEIGHT, height_m),
            (balance.S_FORCE2, noise.acceleration_density**2),
            (balance.S_BIAS2, noise.acceleration_walk**2),
            (balance.S_ANCHOR2, noise.anchor_density**2),
            (balance.S_STANDING2, noise.standing_density**2),
            (balance.S_APART2, _APART_SIGMA_M[is_apart_measured] ** 2),
            (balance.S_WANDER2, _WANDER_M_PER_ROOT_S**2),
            (balance.S_PULL, 0.25 * 2.0 * np.pi * noise.vertical_cutoff_hz),
            (balance.S_AHEAD, float(ahead_ticks)),
        ):
            self._settings[place] = value
        self._shoes = np.zeros((2, shoe.SHOE))
        self._memory = np.zeros(balance.MEMORY)
        self._x, self._p = np.zeros((2, balance.STATES)), np.zeros((balance.STATES, balance.STATES))
        self._loads = np.empty((2, 0, shoe.LOADS))

    def take(self, force_n: Float | None, moment_nm: Float | None, ticks: int) -> None:
        """Take the loads of the next ticks, shape (4, K, 3): left heel and forefoot, right heel and forefoot.

        Parameters
        ----------
        force_n, moment_nm : ndarray or None
            Sensor axes; None where no sensor sent any: missing.
        ticks : int
        """
        new = np.full((2, ticks, shoe.LOADS), np.nan)
        if force_n is not None and moment_nm is not None:
            for first, load, cells in (
                (shoe.HEEL_FORCE, force_n, _HEELS),
                (shoe.HEEL_MOMENT, moment_nm, _HEELS),
                (shoe.FOREFOOT_FORCE, force_n, _FOREFEET),
                (shoe.FOREFOOT_MOMENT, moment_nm, _FOREFEET),
            ):
                new[:, :, first : first + 3] = load[cells]
        self._loads = np.concatenate([self._loads, new], axis=1)

    def release(self, feet: FootChunk, steps: LiveSteps, speed_mps: Float) -> tuple[list[Float], Float]:
        """Bring the loads of what was released of the feet into the room.

        Parameters
        ----------
        feet : FootChunk
            Of the four sensors.
        steps : LiveSteps
            Of the heels.
        speed_mps : ndarray, shape (2, K)
            Of the heels.

        Returns
        -------
        points : list of ndarray, shape (K, 3)
            Both soles, `BALANCE_POINTS` and `PRESSURE_POINTS`, room.
        scalars : ndarray, shape (K, 11)
            `FORCE_SCALARS` of both feet and `LIVE_BALANCE_SCALARS`.
        """
        ticks = feet.tick_count
        nothing = (feet.flags & FootFlag.INVALID) != 0
        bits = np.asarray(feet.is_stance[_HEELS] + 2 * (nothing[_HEELS] | nothing[_FOREFEET]), dtype=np.uint8)
        out = np.empty((2, ticks, shoe.OUT))
        corners = np.empty((2, ticks, 8, 2))
        zero = np.empty((2, ticks))
        shoe.shoes_live(
            self._shoe_settings,
            self._loads,
            feet.q_world_sensor[_CELLS],
            np.ascontiguousarray(steps.place_m.transpose(1, 0, 2)),
            np.ascontiguousarray(steps.course_rad.T),
            speed_mps,
            bits,
            self._shoes,
            out,
            corners,
            zero,
        )
        state = out[:, :, shoe.STATE]
        usable = np.where(state == shoe.MEASURED, np.where(steps.is_placed.T, 2, 1), state == shoe.UNTARED)
        usable = usable + 4 * steps.is_joined.T
        found = np.empty((ticks, balance.OUT))
        balance.balance_live(
            self._settings,
            out,
            corners,
            np.ascontiguousarray(usable, dtype=np.uint8),
            np.ascontiguousarray(
                self._loads[:, :, shoe.HEEL_FORCE + 2] + self._loads[:, :, shoe.FOREFOOT_FORCE + 2]
            ),
            zero,
            self._memory,
            self._x,
            self._p,
            found,
        )
        self._loads = np.ascontiguousarray(self._loads[:, ticks:])
        shift = np.nan_to_num(found[:, balance.SHIFT : balance.SHIFT + 2])
        soles = [
            steps.place_m[:, foot] - [0.0, 0.0, self._shoe_settings[shoe.S_SENSOR_HEIGHT]]
            for foot in range(2)
        ]
        pressed = [out[foot, :, shoe.COP : shoe.COP + 3] for foot in range(2)]
        soles[1][:, :2] += shift
        pressed[1][:, :2] += shift
        whole = [found[:, at : at + 3] for at in (balance.MASS, balance.COP, balance.GOING)]
        forces = [out[foot, :, [0, 1, 2, shoe.STATE]].T for foot in range(2)]
        mass_kg = found[:, balance.WEIGHT] / GRAVITY_MPS2
        stated = np.stack([found[:, balance.MARGIN], found[:, balance.SIGMA], mass_kg], axis=1)
        return [*soles, *whole, *pressed], np.concatenate([*forces, stated], axis=1)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next call depends on."""
        return {
            "shoe_memory": self._shoes.copy(),
            "shoe_loads": self._loads.copy(),
            "balance_memory": self._memory.copy(),
            "balance_x": self._x.copy(),
            "balance_p": self._p.copy(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        self._shoes, self._loads = np.array(state["shoe_memory"]), np.array(state["shoe_loads"])
        self._memory = np.array(state["balance_memory"])
        self._x, self._p = np.array(state["balance_x"]), np.array(state["balance_p"])


__all__ = ["LiveShoes"]
