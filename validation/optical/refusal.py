"""Markers that do not belong to their sensor are refused, and why is reported; sound recordings never are."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.interpolate import make_interp_spline

from estimators import rotation
from estimators.errors import ComparisonError, ContradictionError
from estimators.optical import fuse_markers
from estimators.recording import Float
from validation.optical.scenes import MARKER_SIGMA_M, STEP_S, Scene, free_motion, walking_foot
from validation.protocol import Data, Figure, Protocol, Values

_AXES: Final[dict[str, tuple[Float, str, bool]]] = {
    "columns y and z exchanged": (np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]), "y", True),
    "columns x and y exchanged": (np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]]), "z", True),
    "x with the wrong sign": (np.diag([-1.0, 1.0, 1.0]), "z", True),
    "y up": (np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), "y", False),
    "z down": (np.diag([1.0, -1.0, -1.0]), "-z", False),
}
"""What is done to the columns, which axis then points up, and whether the file is a mirror image."""
_SCALES: Final = (2.54, 1.5, 10.0, 0.1, 1.0 / 25.4)
_SECONDS: Final = 25.0


def cameras(scene: Scene, seed: int, rate_hz: float = 120.0, ghosts: float = 0.0) -> tuple[Float, Float]:
    """Return times of cameras of their own clock and a marker, hidden twice, in a laboratory of any heading.

    Parameters
    ----------
    seed : int
        Of heading, offset, lever arm and noise.
    ghosts : float
        Part of the frames that show something else, 5 to 50 cm away.
    """
    rng = np.random.default_rng([seed, 211])
    turn = rotation.about_z(rng.uniform(-np.pi, np.pi))
    attitude = rotation.multiply(turn, scene.q_room_sensor)
    arm = rotation.rotate(attitude, rng.uniform(-0.06, 0.06, 3))
    time_s = np.arange(0.3, scene.time_s[-1] - 0.3, 1.0 / rate_hz)
    path = rotation.rotate(turn, scene.position_m) + arm
    marker = np.asarray(make_interp_spline(scene.time_s, path, k=5)(time_s))
    marker += rng.normal(0.0, MARKER_SIGMA_M, marker.shape)
    off = rng.normal(size=marker.shape)
    off *= rng.uniform(0.05, 0.5, (len(off), 1)) / np.linalg.norm(off, axis=1, keepdims=True)
    marker += np.where(rng.random((len(off), 1)) < ghosts, off, 0.0)
    for start, stop in ((9.0, 10.5), (13.0, 13.2)):
        marker[(time_s >= start) & (time_s < stop)] = np.nan
    return time_s + rng.uniform(-5.0, 5.0), marker


def _sound(seed: int) -> list[tuple[Scene, Float, Float]]:
    free, slow = free_motion(seed, _SECONDS), free_motion(seed, 40.0, 0.25)
    foot, _ = walking_foot(seed, 20.0)
    return [
        (free, *cameras(free, seed)),
        (free, *cameras(free, seed + 1, 30.0)),
        (free, *cameras(free, seed + 2, ghosts=0.02)),
        (slow, *cameras(slow, seed)),
        (foot, *cameras(foot, seed)),
    ]


def _refused(scene: Scene, time_s: Float, marker_m: Float) -> ComparisonError | None:
    chunk = scene.chunk
    try:
        fuse_markers(
            time_s, marker_m, STEP_S, chunk.gyroscope_radps, chunk.accelerometer_mps2, gap_checks=False
        )
    except ComparisonError as error:
        return error
    return None


def _measure(seeds: Sequence[int], data: Data) -> Values:
    sound, refused, named, other = [], [], [], []
    for seed in seeds:
        sound.append(np.mean([_refused(*one) is not None for one in _sound(seed)]))
        scene = free_motion(seed, _SECONDS)
        time_s, marker = cameras(scene, seed)
        stated, right = [], []
        for mixed, up, is_mirrored in _AXES.values():
            error = _refused(scene, time_s, marker @ mixed.T)
            stated.append(error is not None)
            # A mirror image with y up is one with y down as well: x may be the one of the wrong sign.
            right.append(
                isinstance(error, ContradictionError)
                and error.is_mirrored == is_mirrored
                and error.up[-1] == up[-1]
                and error.scale is None
            )
        for scale in _SCALES:
            error = _refused(scene, time_s, scale * marker)
            stated.append(error is not None)
            found = error.scale if isinstance(error, ContradictionError) else None
            right.append(found is not None and abs(found / scale - 1.0) < 0.05)
        refused.append(np.mean(stated))
        named.append(np.mean(right))
        other.append(_refused(free_motion(seed + 1000, _SECONDS), time_s, marker) is not None)
    return {
        "contradictory files refused": 100.0 * np.array(refused),
        "refused for the right reason": 100.0 * np.array(named),
        "markers of another movement refused": 100.0 * np.array(other, dtype=np.float64),
        "sound recordings refused": 100.0 * np.array(sound),
    }


OPTICAL_REFUSAL = Protocol(
    name="optical_refusal",
    title="Markers that contradict their sensor",
    source="no published figures; method page 1.2 features 16 and 22 leave it open",
    what="Free movement with columns exchanged or of the wrong sign, another axis up, lengths 2.54, 1.5, 10, 0.1 and "
    "1/25.4 times too long, and markers of another movement: refused, with the reason. Sound recordings: free, slow "
    "(0.25 Hz), cameras at 30 Hz, 2 % ghosts, a walking foot; each with two gaps.",
    figures=(
        Figure("contradictory files refused", "%", 100.0, at_most=False),
        Figure("refused for the right reason", "%", 95.0, at_most=False, judged_by="median"),
        Figure("markers of another movement refused", "%", 100.0, at_most=False),
        Figure("sound recordings refused", "%", 0.0),
    ),
    measure=_measure,
)
