"""The posture of whatever moves, as a point in a space whose axes can be compared."""

from typing import Final

import numpy as np

from estimators.comparison._contract import Trajectory
from estimators.comparison.channels.mirror import check_side, other_side
from estimators.comparison.channels.sided import TRUNK_CHANNELS, limb_measured, not_measured
from estimators.errors import ComparisonError
from estimators.recording import Float
from estimators.sentences import say

_ANGLE_WEIGHT: Final = 0.5
"""One radian counts as half a reach: a right angle at the elbow moves the hand about that far."""
_REACH_M: Final = 0.55
"""Of an arm whose wrist was not measured, and of everything else."""
_FOLLOWS_THE_WRIST: Final = ("shoulder", "elbow", "hand")
"""Points that say nothing that the wrist relative to its shoulder and the angles do not."""
_SINGULAR_AT_REST: Final = ("plane_of_elevation", "axial_rotation")
"""Of the shoulder: they have no meaning while the arm hangs."""


def posture(source: Trajectory, side: str) -> Float:
    """Return the angles and places that describe a posture.

    Parameters
    ----------
    side : {"left", "right"}
        The side that exercised.

    Returns
    -------
    ndarray, shape (N, D)
        Joint angles of that side and of the trunk, of an arm its wrist relative to the shoulder, and every point that
        belongs to that side or to none, in units of the reach. NaN where nothing was measured.

    Raises
    ------
    ComparisonError
        If nothing of that side was measured.
    """
    check_side(side)
    columns_of = {
        name: column for column, name in enumerate(source.channels) if source.valid[:, column].any()
    }
    own = [name for name in columns_of if _is_of(name, side)]
    is_other = [_is_of(name, other_side(side)) for name in columns_of]
    # Points of the trunk have a side too: what is measured of a side is its limb.
    if not columns_of or (not limb_measured(source, side) and limb_measured(source, other_side(side))):
        raise ComparisonError(not_measured(source, side))
    shared = [
        name for name, other in zip(columns_of, is_other, strict=True) if not other and not _is_of(name, side)
    ]
    measured = {
        name: np.where(source.valid[:, columns_of[name]], source.values[:, columns_of[name]], np.nan)
        for name in (*own, *shared)
    }
    columns = [_ANGLE_WEIGHT * measured[name] for name in (*own, *shared) if _is_angle(name, side)]
    columns.extend(_wrist(measured, side))
    has_wrist = f"wrist_{side}.x" in measured
    columns.extend(
        measured[name] / _REACH_M
        for name in (*own, *shared)
        if "." in name
        and not name.startswith("wrist")
        and not (has_wrist and name.startswith(_FOLLOWS_THE_WRIST))
    )
    if not columns:
        raise ComparisonError(say("compare.no_signal", side=side))
    return np.stack(columns, axis=1)


def _is_of(name: str, side: str) -> bool:
    return f"_{side}" in name


def _is_angle(name: str, side: str) -> bool:
    if name.startswith("thorax_humerus") and name.endswith(_SINGULAR_AT_REST):
        return False
    return name in TRUNK_CHANNELS or (
        f"_{side}_" in name and "." not in name and not name.endswith(("_mps", "_m"))
    )


def _wrist(measured: dict[str, Float], side: str) -> list[Float]:
    """Return the wrist relative to the shoulder, in units of how far it ever was from it."""
    axes = [axis for axis in "xyz" if f"wrist_{side}.{axis}" in measured]
    if not axes:
        return []
    zero = np.zeros(1)
    place = np.stack(
        [measured[f"wrist_{side}.{axis}"] - measured.get(f"shoulder_{side}.{axis}", zero) for axis in axes],
        axis=1,
    )
    reach_m = float(np.nanpercentile(np.linalg.norm(place, axis=1), 99))
    columns = list((place / (reach_m if reach_m > 0 else _REACH_M)).T)
    # Of the hand what it does beyond the wrist.
    columns.extend(
        (measured[f"hand_{side}.{axis}"] - measured[f"wrist_{side}.{axis}"]) / _REACH_M
        for axis in axes
        if f"hand_{side}.{axis}" in measured
    )
    return columns
