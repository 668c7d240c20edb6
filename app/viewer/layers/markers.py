"""A marker fused with a sensor, as it is prepared for drawing: path, what the cameras saw, gaps, doubt."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from app.recordings.marker_motion import Motion

Float32 = NDArray[np.float32]

_RATE_HZ: Final = 60.0
_FOLLOWED_S: Final = 2.0
_FITS_M: Final = 3.0
"""A path that goes farther is followed by the picture."""
_LEAST_M: Final = 0.5
_SIGMAS: Final = 2.0


@dataclass(frozen=True)
class MarkerTrack:
    """Marker and module over K ticks; laboratory with z up, shifted so that the path lies around the middle.

    Attributes
    ----------
    place_m, module_m : ndarray of float32, shape (K, 3)
        Of the fused marker and of the sensor beside it; NaN where nothing is known.
    wxyz : ndarray of float32, shape (K, 4)
        Of the sensor.
    measured_m : ndarray of float32, shape (K, 3)
        The marker as the cameras saw it; NaN where they did not.
    is_gap : ndarray of bool, shape (K,)
        Filled by the sensor alone.
    spread_m : ndarray of float32, shape (K,)
        Two standard deviations of the place, its longest axis.
    followed_m : ndarray of float32, shape (K, 2)
        Where the middle of the picture is.
    height_m, size_m : float
        Middle height and largest extent of what the picture shows at once.
    """

    place_m: Float32
    module_m: Float32
    wxyz: Float32
    measured_m: Float32
    is_gap: NDArray[np.bool_]
    spread_m: Float32
    followed_m: Float32
    height_m: float
    size_m: float

    def __len__(self) -> int:
        """Return the number of ticks K."""
        return len(self.place_m)


def markers_of(motion: Motion) -> tuple[NDArray[np.float64], MarkerTrack]:
    """Prepare stored motion: session times and the track, with an empty tick before and after."""
    step_s = float(motion.time_s[1] - motion.time_s[0]) if len(motion.time_s) > 1 else 1.0 / _RATE_HZ
    every = max(1, int(1.0 / (step_s * _RATE_HZ) + 1e-6))
    seen = _first_seen(motion.three("measured"), every)
    motion = motion.every(every)
    step_s *= every
    # Before and after nothing is shown, not the first and last place.
    time_s = np.concatenate([[motion.time_s[0] - step_s], motion.time_s, [motion.time_s[-1] + step_s]])
    place, module = motion.three("marker"), motion.three("position")
    wxyz = np.nan_to_num(np.stack([motion.column(f"q_room_sensor_{part}") for part in "wxyz"], axis=1))
    known = place[np.isfinite(place).all(axis=1)]
    low, high = (known.min(axis=0), known.max(axis=0)) if len(known) else (np.zeros(3), np.zeros(3))
    # Some laboratories have their zero above the floor.
    shift = np.array([*(-0.5 * (low + high)[:2]), max(0.0, -float(low[2]))], dtype=np.float32)
    place, module, seen = place + shift, module + shift, seen + shift
    level = float(np.max((high - low)[:2], initial=0.0))
    size = min(max(level, float(high[2] - low[2]), _LEAST_M), _FITS_M)
    track = MarkerTrack(
        _with_ends(place, np.nan),
        _with_ends(module, np.nan),
        _with_ends(wxyz, 0.0),
        _with_ends(seen, np.nan),
        _with_ends(motion.column("is_gap")[:, None], 0.0)[:, 0] > 0,
        _with_ends(_SIGMAS * motion.three("position_sigma").max(axis=1)[:, None], np.nan)[:, 0],
        _followed(_with_ends(place, np.nan), step_s, level),
        0.5 * float(low[2] + high[2]) + float(shift[2]),
        size,
    )
    return time_s, track


def _first_seen(seen: Float32, every: int) -> Float32:
    """Return of each n ticks the first frame: every n-th tick alone may never hold one."""
    count = -(-len(seen) // every)
    padded = np.full((count * every, 3), np.nan, dtype=np.float32)
    padded[: len(seen)] = seen
    blocks = padded.reshape(count, every, 3)
    first = np.isfinite(blocks).all(axis=2).argmax(axis=1)
    return np.asarray(blocks[np.arange(count), first])


def _with_ends(values: Float32, beyond: float) -> Float32:
    end = np.full((1, values.shape[1]), beyond, dtype=np.float32)
    return np.concatenate([end, values, end]).astype(np.float32)


def _followed(place: Float32, step_s: float, level_m: float) -> Float32:
    middle = np.zeros((len(place), 2), dtype=np.float32)
    known = np.flatnonzero(np.isfinite(place).all(axis=1))
    if level_m <= _FITS_M or not len(known):
        return middle
    for axis in range(2):
        whole = np.interp(np.arange(len(place)), known, place[known, axis])
        middle[:, axis] = scipy.ndimage.uniform_filter1d(
            whole, max(1, round(_FOLLOWED_S / step_s)), mode="nearest"
        )
    return middle
