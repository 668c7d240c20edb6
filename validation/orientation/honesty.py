"""Whether our filter and smoother say what they do not know, in scenes that fool an orientation filter."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.stats import chi2

from estimators import orientation, rotation
from estimators.orientation import OrientationFlag
from estimators.recording import Float, ImuChunk
from validation.orientation.honesty_scenes import SCENES, STEP_S, frozen_ticks, scene
from validation.protocol import Data, Figure, Protocol, Values

_METHODS: Final = {"our filter": "telemotion", "our smoother": "telemotion_smoother"}
_REGION: Final = float(chi2.ppf(0.95, 3))
_SETTLED_S, _APART_S = 10.0, 0.5
_LEAST, _MOST, _MOST_NEES = 90.0, 99.0, 4.5
_NO_SENSOR_SHOWS: Final = "whole field off"
_LOST: Final = int(OrientationFlag.BRIDGED | OrientationFlag.INVALID)


def _estimated(name: str, chunk: ImuChunk) -> orientation.OrientationResult:
    if name in orientation.smoothers():
        return orientation.smooth(name, chunk).orientation
    return orientation.create(name, chunk.sensor_count, chunk.time_step_s).update(chunk)


def _scored(found: orientation.OrientationResult, truth: Float) -> tuple[list[Float], list[float]]:
    """Return of each sensor the squared errors over their variances, and the error, degrees, where one is given."""
    assert found.sigma_rad is not None
    error = rotation.log(rotation.multiply(found.q_earth_sensor, rotation.conjugate(truth)))
    squares = ((error / found.sigma_rad) ** 2).sum(axis=-1)
    given = (found.flags & int(OrientationFlag.INVALID)) == 0
    ticks = np.zeros(truth.shape[1], dtype=np.bool_)
    ticks[round(_SETTLED_S / STEP_S) :: round(_APART_S / STEP_S)] = True
    each = [squares[s, ticks & given[s]] for s in range(len(squares))]
    size = [
        float(np.degrees(np.sqrt((error[s, ticks & given[s]] ** 2).sum(axis=-1).mean())))
        for s in range(len(squares))
    ]
    return each, size


def _measured(seeds: Sequence[int], data: Data) -> Values:
    values: Values = {}
    pooled: dict[str, list[float]] = {method: [] for method in _METHODS}
    for title in SCENES:
        chunk, truth = scene(title, seeds)
        for method, name in _METHODS.items():
            found = _estimated(name, chunk)
            squares, size = _scored(found, truth)
            key = f"{title}, {method}"
            inside = [100.0 * float(np.mean(run < _REGION)) for run in squares]
            values[f"{key}, inside the 95 % region"] = np.array([np.mean(inside)])
            values[f"{key}, NEES of a run"] = np.array([run.mean() for run in squares])
            values[f"{key}, error"] = np.array(size)
            if title != _NO_SENSOR_SHOWS:
                pooled[method] += inside
            if _is_lost(title):
                flagged = [
                    100.0 * float(np.mean((found.flags[s, frozen_ticks(seed)] & _LOST) != 0))
                    for s, seed in enumerate(seeds)
                ]
                values[f"{key}, frozen samples flagged"] = np.array(flagged)
    for method, each in pooled.items():
        for bound in ("at least", "at most"):
            values[f"{_together(method)}, {bound}"] = np.array([np.mean(each)])
    return values


def _is_lost(title: str) -> bool:
    """Say whether the sensor as a whole is lost in the scene, and flagged."""
    return ("frozen" in title and "magnetometer" not in title) or "repeated" in title


def _together(method: str) -> str:
    return f"all scenes but the whole field off, {method}, inside the 95 % region"


def _figures() -> tuple[Figure, ...]:
    figures = []
    for title in SCENES:
        for method in _METHODS:
            key = f"{title}, {method}"
            figures += [
                Figure(f"{key}, inside the 95 % region", "%", _LEAST, at_most=False, judged_by="mean"),
                Figure(f"{key}, NEES of a run", "1", _MOST_NEES, 3.0, judged_by="mean"),
                Figure(f"{key}, error", "deg", judged_by="median"),
            ]
            if _is_lost(title):
                name = f"{key}, frozen samples flagged"
                figures.append(Figure(name, "%", _LEAST, at_most=False, judged_by="mean"))
    for method in _METHODS:
        name = _together(method)
        figures.append(Figure(f"{name}, at least", "%", _LEAST, at_most=False, judged_by="mean"))
        figures.append(Figure(f"{name}, at most", "%", _MOST, judged_by="mean"))
    return tuple(figures)


HONESTY = Protocol(
    name="orientation_honesty",
    title="What our filter and smoother state where readings mislead them",
    source="Bar-Shalom et al. 2001, 5.4.2 (average NEES); scenes ours",
    what="One sensor on a limb, 90 s at 100 Hz, of good, common and poor devices in turn: swings and circles at "
    "constant length, a gyroscope cut off at 250 deg/s or more, a triad, the sensor or a block of samples frozen for "
    "4 s, a field that is turned by 5 degrees as a whole, or by 40 for 45 s. Scored twice a second from 10 s on, where "
    "an orientation is given: squared error over reported variance, inside the 95 % region of three axes, and its "
    "mean (3 when honest). A field that is off everywhere and always shows in no reading; it falls short by what the "
    "stated sigma of the heading, relative to the field of the place, leaves out: where the field is the same all "
    "along the way, the smoother's holds (90 % inside) for fields turned as a whole by up to 0.3 degrees.",
    figures=_figures(),
    measure=_measured,
)
