"""The signals that a guide needs of each packet of frames: the bits of `signals(trajectory(frames), ready)`.

A packet is a few ticks. Of these `trajectory` collects every channel that a comparison may ask for, with the sigma of
points that no guide reads; that took ten times as long as the filter itself. Where each channel of the template is in
the frames follows from the layout, which a session retains: it is looked up once.
"""

from typing import Final, NamedTuple, cast

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators.comparison.channels.trajectory import (
    UNUSABLE,
    leaning_channel,
    leaning_segments,
    legs_forward,
    segments_behind,
)
from estimators.compiling import Kernel, compiled, unchecked
from estimators.guidance._contract import GuidanceTemplate
from estimators.guidance._template import is_place, shoulder_of
from estimators.kernels import VOID, bundle
from estimators.orientation._contract import OrientationFlag
from estimators.pipelines import FrameLayout, Frames
from estimators.recording import Float

_MISSING, _ANGLE, _SCALAR, _POINT, _LEG = range(5)
_INVALID: Final = int(OrientationFlag.INVALID)
_UNUSABLE: Final = int(UNUSABLE)


class Places(NamedTuple):
    """Where each of C channels is in frames with G segments.

    Attributes
    ----------
    kind : ndarray of int64, shape (C,)
        Which array of the frames; `_MISSING` where the session does not have the channel.
    column, origin : ndarray of int64, shape (C,)
        In that array; of points also that of the shoulder, from which they are measured.
    needed : ndarray of uint8, shape (C, G)
        1 for the segments without which the channel is unknown; angles carry flags of their own.
    """

    kind: NDArray[np.int64]
    column: NDArray[np.int64]
    origin: NDArray[np.int64]
    needed: NDArray[np.uint8]


def _places(ready: GuidanceTemplate, layout: FrameLayout) -> Places:
    points = [f"{point}.{axis}" for point in layout.points for axis in "xyz"]
    leaning = [layout.segments[column] for column in leaning_segments(layout)]
    legs = [leaning_channel(segment) for segment in leaning]
    channels = len(ready.channels)
    kind, column = np.full(channels, _MISSING), np.zeros(channels, dtype=np.int64)
    origin, needed = np.zeros_like(column), np.zeros((channels, len(layout.segments)), dtype=np.uint8)
    for c, name in enumerate(ready.channels):
        if is_place(name) and name in points and (shoulder := shoulder_of(name)) in points:
            kind[c], column[c], origin[c] = _POINT, points.index(name), points.index(shoulder)
            behind = {*segments_behind(name), *segments_behind(shoulder)}
        elif name in layout.angles:
            kind[c], column[c], behind = _ANGLE, layout.angles.index(name), set()
        elif name in layout.scalars:
            kind[c], column[c], behind = _SCALAR, layout.scalars.index(name), set(segments_behind(name))
        elif name in legs:
            kind[c], column[c] = _LEG, legs.index(name)
            behind = {leaning[column[c]]}
        else:
            continue
        needed[c] = [segment in behind for segment in layout.segments]
    return Places(kind, column, origin, needed)


_TABLE, _ROW, _BITS = types.float64[:, ::1], types.int64[::1], types.uint8[:, ::1]


@compiled(
    VOID(
        *(_TABLE, _TABLE, _BITS, _TABLE, _TABLE, _TABLE, _BITS),
        *(bundle(Places, _ROW, _ROW, _ROW, _BITS), _TABLE, _TABLE),
    )
)
def _pick(
    angle_rad: Float,
    angle_sigma_rad: Float,
    angle_flags: NDArray[np.uint8],
    scalar: Float,
    point_m: Float,
    leg_rad: Float,
    segment_flags: NDArray[np.uint8],
    places: Places,
    values: Float,
    sigma: Float,
) -> None:  # pragma: no cover
    """Write values and sigma, shape (N, C), from arrays of frames, shape (N, columns)."""
    for k in range(values.shape[0]):
        for c in range(values.shape[1]):
            values[k, c] = sigma[k, c] = np.nan
            kind, at = places.kind[c], places.column[c]
            known = kind != _MISSING
            for g in range(segment_flags.shape[1]):
                known &= places.needed[c, g] == 0 or segment_flags[k, g] & _INVALID == 0
            if not known:
                continue
            if kind == _ANGLE:
                if angle_flags[k, at] & _UNUSABLE == 0 and np.isfinite(angle_rad[k, at]):
                    values[k, c] = angle_rad[k, at]
                    sigma[k, c] = angle_sigma_rad[k, at]
                continue
            value, origin = 0.0, 0.0
            if kind == _SCALAR:
                value = scalar[k, at]
            elif kind == _LEG:
                value = leg_rad[k, at]
            else:
                value, origin = point_m[k, at], point_m[k, places.origin[c]]
            if np.isfinite(value) and np.isfinite(origin):
                values[k, c] = value - origin


class ChannelSelector:
    """Picks what `Guide.feed` takes out of the frames of a session, packet by packet."""

    def __init__(self, ready: GuidanceTemplate) -> None:
        self._ready = ready
        self._write = _pick
        self._layout: FrameLayout | None = None

    @staticmethod
    def prepare() -> None:
        """Compile or load what `pick` runs; blocks."""
        cast(Kernel, _pick).prepare()

    def pick(self, frames: Frames) -> tuple[Float, Float]:
        """Return values and sigma, shape (N, C), as `estimators.guidance.signals` does of their trajectory."""
        layout = frames.layout
        if layout is not self._layout and layout != self._layout:
            self._layout, self._places = layout, _places(self._ready, layout)
            self._write = _pick
            self._legs = leaning_segments(layout) if (self._places.kind == _LEG).any() else []
        ticks = len(frames.angle_rad)
        leg_rad = legs_forward(frames, self._legs) if self._legs else np.empty((ticks, 0))
        values, sigma = np.empty((2, ticks, len(self._ready.channels)))
        self._write(
            np.ascontiguousarray(frames.angle_rad, float),
            np.ascontiguousarray(frames.angle_sigma_rad, float),
            np.ascontiguousarray(frames.angle_flags, np.uint8),
            np.ascontiguousarray(frames.scalar, float),
            np.ascontiguousarray(frames.point_room_m, float).reshape(ticks, -1),
            np.ascontiguousarray(leg_rad, float),
            np.ascontiguousarray(frames.segment_flags, np.uint8),
            self._places,
            values,
            sigma,
        )
        if self._write is _pick:
            # The first was checked; what comes with this layout is of the same types.
            self._write = unchecked(_pick)
        return values, sigma
