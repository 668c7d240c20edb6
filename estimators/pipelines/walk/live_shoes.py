"""Two instrumented shoes while somebody walks: ground reaction, pressure, centre of mass and what is wrong."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.balance import MassCentreParameters
from estimators.balance import _live_balance_kernel as balance
from estimators.balance._stability import SOLE_HALF_WIDTH_M
from estimators.conventions import GRAVITY_MPS2
from estimators.kernels.slots import into_row
from estimators.kinetics import ShoeGeometry
from estimators.kinetics import _live_shoes_kernel as shoe
from estimators.pipelines.walk.released_kernel import Shoes
from estimators.pipelines.walk.rows import Queue, WalkRows, queue_room
from estimators.recording import Float

_APART_SIGMA_M: Final = {True: 0.01, False: 0.04}
"""Of the distance of the feet at the start: measured, or only the usual one."""
_WANDER_M_PER_ROOT_S: Final = 0.01
"""The ways of the two feet drift apart; what is lost in a stride is 1 to 2 cm."""


_HEELS, _FOREFEET = slice(0, 4, 2), slice(1, 4, 2)
assert (shoe.HEEL_FORCE, shoe.HEEL_MOMENT, shoe.FOREFOOT_FORCE, shoe.FOREFOOT_MOMENT) == (0, 3, 6, 9)


class LiveShoes:
    """Forces of two shoes on their way behind the feet; chunks give the same as one batch, bit for bit.

    Parameters
    ----------
    height_m : float
        Of the centre of mass of the person who stands.
    is_apart_measured : bool
        Whether somebody measured how far the feet stand apart at the start.
    ahead_ticks : int
        How far the forces are always known beyond what is released of the feet.
    delay_ticks : int
        Most ticks between a sample and its release.
    """

    version = "1"

    def __init__(
        self,
        time_step_s: float,
        height_m: float,
        *,
        is_apart_measured: bool,
        ahead_ticks: int,
        delay_ticks: int,
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
        self._loads = Queue(np.zeros(queue_room(2, delay_ticks, shoe.LOADS)), np.zeros(2, dtype=np.int64))

    def take(self, force_n: Float | None, moment_nm: Float | None, ticks: int) -> None:
        """Take the loads of the next ticks, shape (4, K, 3): left heel and forefoot, right heel and forefoot.

        Parameters
        ----------
        force_n, moment_nm : ndarray or None
            Sensor axes; None where no sensor sent any: missing.
        """
        new = self._loads.append(ticks)
        if force_n is None or moment_nm is None:
            new[...] = np.nan
        else:
            cells = (force_n[_HEELS], moment_nm[_HEELS], force_n[_FOREFEET], moment_nm[_FOREFEET])
            np.concatenate(cells, axis=2, out=new)

    @property
    def shoes(self) -> Shoes:
        """What compiled code carries on."""
        return Shoes(self._shoe_settings, self._shoes, self._settings, self._memory, self._x, self._p)

    @property
    def loads(self) -> Float:
        """Of the ticks that are not released, shape (2, K, LOADS)."""
        return np.ascontiguousarray(self._loads.values)

    def released(self, ticks: int) -> None:
        """Forget the loads of the ticks that were released."""
        self._loads.drop(ticks)

    def go_on_over(self, rows: WalkRows, slot: int) -> None:
        """Hold everything in a session's rows of a pool from now on."""
        rows.shoe_settings[slot], rows.balance_settings[slot] = self._shoe_settings, self._settings
        self._shoes = into_row(self._shoes, rows.shoes[2 * slot : 2 * slot + 2])
        self._memory = into_row(self._memory, rows.balance_memory[slot])
        self._x, self._p = into_row(self._x, rows.x[slot]), into_row(self._p, rows.p[slot])
        self._loads.go_on_in(rows.loads[slot], rows.loads_place[slot])

    def own(self) -> None:
        """Hold everything in arrays of its own again."""
        self._shoes, self._memory = self._shoes.copy(), self._memory.copy()
        self._x, self._p = self._x.copy(), self._p.copy()
        self._loads.own()

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next call depends on."""
        return {
            "shoe_memory": self._shoes.copy(),
            "shoe_loads": self._loads.values.copy(),
            "balance_memory": self._memory.copy(),
            "balance_x": self._x.copy(),
            "balance_p": self._p.copy(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        self._shoes = np.array(state["shoe_memory"])
        self._loads.refill(state["shoe_loads"])
        self._memory = np.array(state["balance_memory"])
        self._x, self._p = np.array(state["balance_x"]), np.array(state["balance_p"])
