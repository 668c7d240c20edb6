"""The channels of one side, of which only some show how the limb is meant to move."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._contract import Repetition, Trajectory
from estimators.comparison.channels.mirror import check_side, other_side
from estimators.comparison.channels.names import foot_channels
from estimators.comparison.measures.places import ARM_POINTS
from estimators.errors import ComparisonError
from estimators.recording import Float
from estimators.sentences import Sentence, say

TRUNK_CHANNELS: Final = ("trunk_lean_forward_rad", "trunk_lean_lateral_rad", "trunk_axial_rotation_rad")
"""Scalars that show compensation with the trunk; the last two change sign in a mirror."""
_HIKES: Final = "shoulder_hike"
_OF_THE_TRUNK: Final = ("shoulder_", "hip_")


@dataclass(frozen=True)
class SideChannels:
    """The comparable channels of one side.

    Attributes
    ----------
    channels : tuple of str
        Joint angles of the side, trunk scalars, hikes and channels of strides, then elbow, wrist and hand as
        `<point>.x|y|z`.
    values, sigma : ndarray, shape (N, C)
        Angles and leans in rad. Positions in m relative to the shoulder of the same side, times
        `reach_to / reach_from`, so that people of different size can be laid on each other. NaN where
        the trajectory is not valid.
    unseated : ndarray of bool, shape (N, C), or None
        Where a sensor has turned in its strap, see `Trajectory`; the values are NaN there.
    """

    time_s: Float
    channels: tuple[str, ...]
    values: Float
    sigma: Float
    unseated: NDArray[np.bool_] | None = None

    @cached_property
    def step_s(self) -> float:
        """From tick to tick, usually."""
        return float(np.median(np.diff(self.time_s)))

    def column(self, channel: str) -> Float | None:
        """Return one channel, shape (N,), or None when it was not measured."""
        return self.values[:, self.channels.index(channel)] if channel in self.channels else None

    def resized(self, ratio: float) -> "SideChannels":
        """Return the same with the places of a person so many times as large."""
        places = ["." in name for name in self.channels]
        values, sigma = self.values.copy(), self.sigma.copy()
        values[:, places] *= ratio
        sigma[:, places] *= ratio
        return replace(self, values=values, sigma=sigma)

    def cut(self, repetition: Repetition) -> "SideChannels":
        """Return the samples of one repetition, half-open in session time.

        A channel whose sensor turned in its strap during it is NaN in all of it: its range and its peak would be those
        of the part before.
        """
        inside = repetition.ticks(self.time_s)
        values, unseated = self.values[inside], None
        if self.unseated is not None:
            unseated = self.unseated[inside]
            values = np.where(unseated.any(axis=0), np.nan, values)
        return replace(
            self, time_s=self.time_s[inside], values=values, sigma=self.sigma[inside], unseated=unseated
        )


def side_channels(source: Trajectory, side: str, size_ratio: float = 1.0) -> SideChannels:
    """Pick and normalise the channels of one side.

    Parameters
    ----------
    side : {"left", "right"}
    size_ratio : float
        Reach of the person to compare with divided by the reach of the person measured.

    Returns
    -------
    SideChannels
        Only channels with at least one valid sample.

    Raises
    ------
    ComparisonError
        If nothing of that side was measured.
    """
    check_side(side)
    masked = source.measured
    index = {name: column for column, name in enumerate(source.channels)}
    names: list[str] = []
    values: list[Float] = []
    sigma: list[Float] = []
    columns: list[list[int]] = []
    for name in source.channels:
        is_angle = f"_{side}_" in name and not name.endswith(("_mps", "_m", "_lean_forward_rad"))
        is_own = is_angle or name == f"shoulder_hike_{side}_m" or name in foot_channels(side)
        if is_own or name in TRUNK_CHANNELS:
            names.append(name)
            values.append(masked[:, index[name]])
            sigma.append(source.sigma[:, index[name]])
            columns.append([index[name]])
    for point in ARM_POINTS:
        for axis in "xyz":
            name, origin = f"{point}_{side}.{axis}", f"shoulder_{side}.{axis}"
            if name in index and origin in index:
                names.append(name)
                values.append((masked[:, index[name]] - masked[:, index[origin]]) * size_ratio)
                sigma.append(source.sigma[:, index[name]] * size_ratio)
                columns.append([index[name], index[origin]])
    measured = [i for i, column in enumerate(values) if np.isfinite(column).any()]
    if not any(f"_{side}" in names[i] for i in measured):
        raise ComparisonError(not_measured(source, side))
    unseated = source.unseated
    return SideChannels(
        time_s=source.time_s,
        channels=tuple(names[i] for i in measured),
        values=np.ascontiguousarray(np.stack([values[i] for i in measured], axis=1)),
        sigma=np.ascontiguousarray(np.stack([sigma[i] for i in measured], axis=1)),
        unseated=None
        if unseated is None
        else np.stack([unseated[:, columns[i]].any(axis=1) for i in measured], axis=1),
    )


def limb_measured(source: Trajectory, side: str) -> bool:
    """Tell whether anything of a limb of that side was measured: not what a sensor on the trunk says of both sides."""
    is_own = [f"_{side}" in name and not name.startswith(_OF_THE_TRUNK) for name in source.channels]
    return bool(source.valid[:, is_own].any())


def not_measured(source: Trajectory, side: str) -> Sentence:
    """Say that nothing of a side was measured, and where sensors were worn instead."""
    other = other_side(side)
    if limb_measured(source, other):
        return say("compare.other_side_measured", side=side, worn=other)
    return say("compare.side_not_measured", side=side)


def is_compensation(channel: str) -> bool:
    """Tell whether a channel shows how trunk or shoulder help the arm."""
    return channel in TRUNK_CHANNELS or channel.startswith(_HIKES)


def fill_gaps(values: Float) -> tuple[Float, NDArray[np.bool_]]:
    """Interpolate each column linearly over its gaps; also return which columns have any value.

    Parameters
    ----------
    values : ndarray, shape (N, C)
        NaN in gaps.

    Returns
    -------
    filled : ndarray, shape (N, C)
        Ends hold the nearest value; a column without any value is zero.
    usable : ndarray of bool, shape (C,)
    """
    filled = values.copy()
    sound: NDArray[np.bool_] = np.asarray(np.isfinite(values))
    usable = np.asarray(sound.any(axis=0))
    ticks = np.arange(values.shape[0])
    for column in range(values.shape[1]):
        if not usable[column]:
            filled[:, column] = 0.0
        elif not sound[:, column].all():
            good = sound[:, column]
            filled[:, column] = np.interp(ticks, ticks[good], values[good, column])
    return filled, usable
