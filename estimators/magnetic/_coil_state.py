"""One number for what a source does: which coil is on, and with which current; as packets carry it."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.errors import SetupError
from estimators.recording import Float

CURRENT_SPAN_A = 10.0
"""Currents stay below this; the decimals of a coil state are a current in parts of it."""
HIGHEST_COIL = 31
"""Above this a state is no coil state but a wrong channel."""


def coil_state(coil: ArrayLike, current_a: ArrayLike) -> Float:
    """Return coil states: 0 for off, else the coil's number from 1, and the current as a tenth of it in the decimals.

    Parameters
    ----------
    coil : array_like of int
        0 for off, 1 for the first coil.
    current_a : array_like
        Below 10 A. Its sign is that of the state: 2.13 is the second coil at 1.3 A, -2.13 at -1.3 A.

    Returns
    -------
    ndarray
        As 32-bit floats these hold the current to a few microamperes.

    Raises
    ------
    SetupError
        For numbers that no state can say.
    """
    number, current = np.broadcast_arrays(np.asarray(coil), np.asarray(current_a, dtype=np.float64))
    if (number < 0).any() or (number > HIGHEST_COIL).any():
        raise SetupError(f"coils are numbered 1 to {HIGHEST_COIL}, 0 is off")
    if not (np.abs(current) < CURRENT_SPAN_A).all():
        raise SetupError(f"a coil state can say currents below {CURRENT_SPAN_A:g} A")
    sign = np.where(current < 0.0, -1.0, 1.0)
    return np.asarray(np.where(number > 0, sign * (number + np.abs(current) / CURRENT_SPAN_A), 0.0))


def read_coil_state(state: ArrayLike) -> tuple[NDArray[np.int64], Float, NDArray[np.bool_]]:
    """Read coil states.

    Parameters
    ----------
    state : array_like

    Returns
    -------
    coil : ndarray of int
        0 for off, else from 1.
    current_a : ndarray
        Signed; 0 while off.
    wrong : ndarray of bool
        Where the number is none that a source can send: it is read as off.
    """
    values = np.asarray(state, dtype=np.float64)
    size = np.abs(values)
    wrong = ~(size < HIGHEST_COIL + 1.0) | ((size > 0.0) & (size < 1.0))
    size = np.where(wrong, 0.0, size)
    number = np.floor(size)
    current = np.copysign((size - number) * CURRENT_SPAN_A, values)
    return number.astype(np.int64), np.where(number > 0.0, current, 0.0), wrong
