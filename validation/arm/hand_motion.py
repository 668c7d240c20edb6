"""V4 orientation of a hand-moved module, V5 its bias states, V6 through the singularity (Marzouk 2009)."""

from collections.abc import Sequence

import numpy as np

from estimators.recording import Float
from published.marzouk._quaternion import PUBLISHED_TUNING
from validation.arm.thesis import (
    GYROSCOPE_BIAS_DEGPS,
    HANDLE,
    Module,
    angle_errors_deg,
    calibrate_still,
    estimate,
    hand_motion,
    measure_module,
    raw_angles,
    steep_motion,
)
from validation.plots import error_over_time
from validation.protocol import Data, Figure, Plot, Protocol, Values

_AXES = ("roll", "pitch", "yaw")
_FILTERS = {
    "quaternion filter, published tuning": ("marzouk_quaternion_ekf", dict(PUBLISHED_TUNING)),
    "quaternion filter": ("marzouk_quaternion_ekf", {}),
    "error-state filter": ("marzouk_error_state_ekf", {}),
    "VQF": ("vqf", {}),
    "our filter": ("telemotion", {}),
}
_PUBLISHED = dict(zip(_AXES, (1.7051, 1.8102, 8.9811), strict=True))
_REQUIRED = {
    ("quaternion filter, published tuning", "clean"): (1.7051, 1.8102, 8.9811),
    ("quaternion filter, published tuning", "iron"): (1.7051, 1.8102, 8.9811),
    ("quaternion filter", "clean"): (1.5, 1.2, 2.0),
    ("quaternion filter", "iron"): (1.7, 1.8, 8.98),
    ("error-state filter", "clean"): (0.6, 0.6, 1.5),
    ("error-state filter", "iron"): (0.6, 0.6, 8.98),
    ("our filter", "clean"): (1.5, 1.2, 2.0),
    ("our filter", "iron"): (1.7, 1.8, 8.98),
}


def _hand(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    tilt: dict[str, list[tuple[float, float]]] = {}
    for condition, iron in (("clean", None), ("iron", HANDLE)):
        modules = [calibrate_still(measure_module(hand_motion, 130.0, s, body_field=iron)) for s in seeds]
        for module in modules:
            errors = angle_errors_deg(raw_angles(module.gravity_g, module.field), module)
            for axis, error in zip(_AXES, errors[::-1], strict=True):
                values.setdefault(f"single samples, {condition}, {axis}", []).append(error)
        for title, (name, parameters) in _FILTERS.items():
            found, _ = estimate(modules, name, parameters)
            for module, attitude in zip(modules, found, strict=True):
                errors = angle_errors_deg(attitude.as_euler("ZYX"), module)
                for axis, error in zip(_AXES, errors[::-1], strict=True):
                    values.setdefault(f"{title}, {condition}, {axis}", []).append(error)
                if title == "error-state filter":
                    tilt.setdefault(condition, []).append((errors[2], errors[1]))
    values["error-state filter, change of tilt by iron"] = list(
        np.abs(np.array(tilt["clean"]) - np.array(tilt["iron"])).max(axis=1)
    )
    return {name: np.array(found) for name, found in values.items()}


def _hand_figures() -> tuple[Figure, ...]:
    figures = []
    for condition in ("clean", "iron"):
        figures += [Figure(f"single samples, {condition}, {axis}", "deg") for axis in _AXES]
        for title in _FILTERS:
            required = _REQUIRED.get((title, condition), (None, None, None))
            published = _PUBLISHED if "published" in title else {}
            figures += [
                Figure(f"{title}, {condition}, {axis}", "deg", limit, published.get(axis))
                for axis, limit in zip(_AXES, required, strict=True)
            ]
    figures.append(Figure("error-state filter, change of tilt by iron", "deg", 0.2))
    return tuple(figures)


def _rotation_errors(module: Module) -> dict[str, Float]:
    """Angle of the rotation error of every filter over time, degrees."""
    errors = {}
    for title, (name, parameters) in _FILTERS.items():
        found, _ = estimate([module], name, parameters)
        errors[title] = np.degrees((module.attitude.inv() * found[0]).magnitude())
    return errors


def _hand_plots(data: Data) -> tuple[Plot, ...]:
    plots = []
    for condition, iron in (("without iron", None), ("with the iron handle", HANDLE)):
        module = calibrate_still(measure_module(hand_motion, 130.0, 0, body_field=iron))
        plots.append(error_over_time(f"Moved by hand, {condition}", module.time_s, _rotation_errors(module)))
    return tuple(plots)


HAND_MOTION = Protocol(
    name="arm_orientation",
    title="V4 Orientation of a module moved by hand",
    source="Marzouk 2009, table 3.2 (P4), section 5.3; method page V4, errata E-10 to E-16",
    what="Two minutes of turning by hand at 17 Hz with the published noise, without and with the iron handle; mean "
    "absolute error of roll, pitch and yaw after a static calibration.",
    figures=_hand_figures(),
    measure=_hand,
    plots=_hand_plots,
)


def _bias(seeds: Sequence[int], data: Data) -> Values:
    modules = [calibrate_still(measure_module(hand_motion, 130.0, seed), gyroscope=False) for seed in seeds]
    values = {}
    for title in ("quaternion filter", "error-state filter", "VQF"):
        name, parameters = _FILTERS[title]
        _, bias = estimate(modules, name, parameters)
        error = np.degrees(bias[:, -1]) - GYROSCOPE_BIAS_DEGPS
        values[f"{title}, largest error of an axis"] = np.abs(error).max(axis=1)
    return values


BIAS_STATES = Protocol(
    name="arm_bias_states",
    title="V5 Gyroscope bias found in motion",
    source="Marzouk 2009, 3.3; method page V5",
    what="The motion of V4 without a gyroscope calibration: after two minutes the filter must know the bias "
    "(-0.82, 0.79, 0.56 degrees/s) by itself.",
    figures=(
        Figure("quaternion filter, largest error of an axis", "deg/s", 0.3),
        Figure("error-state filter, largest error of an axis", "deg/s", 0.3),
        Figure("VQF, largest error of an axis", "deg/s"),
    ),
    measure=_bias,
)

_STEEP = {
    "quaternion filter": (4.0, 10.0),
    "error-state filter": (1.0, 2.0),
    "VQF": (None, None),
}


def _steep(seeds: Sequence[int], data: Data) -> Values:
    modules = [measure_module(steep_motion, 72.0, seed, with_bias=False) for seed in seeds]
    values = {}
    for title in _STEEP:
        found, _ = estimate(modules, *_FILTERS[title])
        errors = [
            np.degrees((module.attitude.inv() * attitude).magnitude())[module.time_s > 12.0]
            for module, attitude in zip(modules, found, strict=True)
        ]
        values[f"{title}, mean error"] = np.array([e.mean() for e in errors])
        values[f"{title}, largest error"] = np.array([e.max() for e in errors])
    return values


def _steep_plots(data: Data) -> tuple[Plot, ...]:
    module = measure_module(steep_motion, 72.0, 0, with_bias=False)
    return (error_over_time("Pitch through 90 degrees", module.time_s, _rotation_errors(module)),)


SINGULARITY = Protocol(
    name="arm_singularity",
    title="V6 Through the singularity of Euler angles",
    source="Marzouk 2009, 3.2.2 and 3.3, erratum E-16; method page V6",
    what="Pitch swings through 90 degrees both ways: the angle of the rotation error must stay small, although "
    "measurement by Euler angles is singular there.",
    figures=tuple(
        Figure(f"{title}, {kind} error", "deg", limit)
        for title, limits in _STEEP.items()
        for kind, limit in zip(("mean", "largest"), limits, strict=True)
    ),
    measure=_steep,
    plots=_steep_plots,
)
