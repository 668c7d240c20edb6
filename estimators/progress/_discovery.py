"""Many measures on one page: which of them may be said to have changed."""

import numpy as np
from numpy.typing import NDArray

from estimators.recording import Float

_LEVEL = 0.05


def discoveries(probability: Float, main: int | None = 0, level: float = _LEVEL) -> NDArray[np.bool_]:
    """Return which measures changed: the main one by itself, the others by their false discovery rate.

    Parameters
    ----------
    probability : ndarray, shape (M,)
        That each change is above zero; NaN where nothing can be said.
    main : int, optional
        The measure judged alone at `level`, two-sided; None for none.

    Returns
    -------
    ndarray of bool, shape (M,)

    Notes
    -----
    Benjamini and Hochberg 1995, J R Stat Soc B 57:289: of the sorted p of m others all up to the last with
    p_(k) <= k level / m.
    """
    p = 2.0 * np.minimum(probability, 1.0 - probability)
    found = np.zeros(len(p), dtype=np.bool_)
    others = np.array([k for k in range(len(p)) if k != main and np.isfinite(p[k])], dtype=np.int64)
    if main is not None and len(p):
        found[main] = p[main] <= level
    if len(others):
        order = others[np.argsort(p[others], kind="stable")]
        holds = p[order] <= level * np.arange(1, len(order) + 1) / len(order)
        if holds.any():
            found[order[: np.flatnonzero(holds)[-1] + 1]] = True
    return found
