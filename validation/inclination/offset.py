"""V7 to V10 of Luinge and Veltink (2005): the gyroscope offset found in motion and at rest."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from estimators import orientation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk
from published.luinge import PUBLISHED
from validation.inclination.scenes import (
    ACCELEROMETER_SD_MPS2,
    CONSISTENT,
    GYROSCOPE_SD_RADPS,
    STEP_S,
    STILL_SAMPLES,
    inclination_errors_deg,
    lifting,
    record,
    root_mean_square,
    to_chunk,
    vertical_in_sensor,
)
from validation.plots import allan_plot
from validation.protocol import Curve, Data, Figure, Plot, Protocol, Values, thinned

_END = STILL_SAMPLES + 12_000
"""Two minutes of lifting."""
_FILTERS: dict[str, tuple[str, dict[str, Any]]] = {
    "published structure": ("luinge_inclination", PUBLISHED),
    "consistent filter": ("luinge_inclination", CONSISTENT),
    "our filter": ("telemotion", {}),
}


def _with_start(parameters: dict[str, Any], name: str, sigma_degps: float) -> dict[str, Any]:
    """Tell the filter how large the unmeasured offset may be."""
    key = "initial_bias_sigma_degps" if name == "luinge_inclination" else "bias_start_sigma_degps"
    return parameters | {key: sigma_degps}


def _lifted(generator: np.random.Generator, intervals: Sequence[float]) -> tuple[ImuChunk, Float]:
    """Each pace seen at trunk and pelvis."""
    trials = [
        record(lifting(interval_s, pelvis, generator), 120.0, generator)
        for interval_s in intervals
        for pelvis in (False, True)
    ]
    return to_chunk(trials), np.stack([trial.attitude for trial in trials])


def _injected(chunk: ImuChunk, size_radps: float) -> tuple[ImuChunk, Float]:
    """Repeat every trial with an offset on each axis in turn; also returns the offsets, shape (S, 3)."""
    offsets = np.tile(size_radps * np.eye(3), (chunk.sensor_count, 1))
    return (
        ImuChunk(
            0,
            chunk.time_step_s,
            np.repeat(chunk.gyroscope_radps, 3, axis=0) + offsets[:, None],
            np.repeat(chunk.accelerometer_mps2, 3, axis=0),
            None,
            np.repeat(chunk.quality, 3, axis=0),
        ),
        offsets,
    )


def _recovery(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}

    def add(name: str, value: float) -> None:
        values.setdefault(name, []).append(float(value))

    for seed in seeds:
        generator = np.random.default_rng([seed, 7])
        chunk, _ = _lifted(generator, (7.0, 5.0, 3.5))
        turned, offsets = _injected(chunk, 1.0)
        for title, (name, parameters) in _FILTERS.items():
            parameters = _with_start(parameters, name, 57.3)
            found = orientation.create(name, len(offsets), STEP_S, parameters).update(turned)
            percent = 100.0 * np.linalg.norm(found.gyroscope_bias_radps[:, _END - 1] - offsets, axis=1)
            add(f"{title}, 1 rad/s, mean of 18 runs", percent.mean())
            add(f"{title}, 1 rad/s, worst of 18 runs", percent.max())
        chunk, attitude = _lifted(generator, (7.0, 5.0, 3.5, 2.0))
        turned, offsets = _injected(chunk, 1.0)
        with_rest = _with_start(CONSISTENT | {"rest_update": True}, "luinge_inclination", 57.3)
        found = orientation.create("luinge_inclination", len(offsets), STEP_S, with_rest).update(turned)
        percent = 100.0 * np.linalg.norm(found.gyroscope_bias_radps[:, _END - 1] - offsets, axis=1)
        add("consistent filter with rest update, 1 rad/s, worst of 24 runs", percent.max())
        errors = inclination_errors_deg(
            vertical_in_sensor(found.q_earth_sensor), np.repeat(attitude, 3, axis=0)
        )[:, STILL_SAMPLES:_END]
        worst = max(root_mean_square(run) for run in errors)
        add("consistent filter with rest update, 1 rad/s, worst inclination", worst)
        trunk = to_chunk([record(lifting(5.0, False, generator), 120.0, generator)])
        ten, offset = _injected(trunk, np.radians(10.0))
        for title, (name, parameters) in _FILTERS.items():
            filter_ = orientation.create(name, 1, STEP_S, _with_start(parameters, name, 10.0))
            result = filter_.update(
                ImuChunk(0, STEP_S, ten.gyroscope_radps[:1], ten.accelerometer_mps2[:1], None, trunk.quality)
            )
            left = result.gyroscope_bias_radps[0, _END - 1] - offset[0]
            add(f"{title}, 10 degrees/s on x, left over", np.degrees(np.linalg.norm(left)))
            if name == "luinge_inclination":
                sigma = np.sqrt(np.diag(filter_.state()["covariance"][0])[3:6])
                add(
                    f"{title}, order y < x < z of the offset's deviations",
                    float(sigma[1] < sigma[0] < sigma[2]),
                )
    return {name: np.array(found) for name, found in values.items()}


def _recovery_plots(data: Data) -> tuple[Plot, ...]:
    generator = np.random.default_rng([0, 7])
    trunk = to_chunk([record(lifting(5.0, False, generator), 120.0, generator)])
    ten, offsets = _injected(trunk, np.radians(10.0))
    curves = []
    for title, (name, parameters) in _FILTERS.items():
        found = orientation.create(name, 3, STEP_S, _with_start(parameters, name, 10.0)).update(ten)
        left = np.degrees(np.linalg.norm(found.gyroscope_bias_radps[0] - offsets[0], axis=1))
        curves.append(thinned(title, trunk.time_s, left))
    return (
        Plot(
            "Offset of 10 degrees/s on x, lifting every 5 s",
            "time",
            "s",
            "offset error",
            "deg/s",
            tuple(curves),
        ),
    )


OFFSET_RECOVERY = Protocol(
    name="inclination_offset_recovery",
    title="V7 to V9 Gyroscope offset found while lifting",
    source="Luinge and Veltink 2005, abstract, 4.4, figures 9 and 10 (P6, P7); method page S4, S5, V7 to V9",
    what="1 rad/s is added to one axis of the gyroscope during two minutes of lifting, unknown to the filter (18 "
    "runs a seed: three paces, trunk and pelvis, three axes): what is left of it in percent, published about "
    "5. With the rest update also at the fastest pace. Then the paper's example of 10 degrees/s on the x "
    "axis. Our filter corrects five times a second, too seldom for an offset of 57 degrees/s: a third of it "
    "is what is asked; of 10 degrees/s all.",
    figures=(
        # A run in a hundred starts so far off that no linear correction finds back within two minutes (page, V8).
        Figure("published structure, 1 rad/s, mean of 18 runs", "%", 5.0, 5.0, judged_by="median"),
        Figure("published structure, 1 rad/s, worst of 18 runs", "%"),
        Figure("consistent filter, 1 rad/s, mean of 18 runs", "%", 5.0, 5.0, judged_by="median"),
        Figure("consistent filter, 1 rad/s, worst of 18 runs", "%", 7.0, judged_by="median"),
        Figure("our filter, 1 rad/s, mean of 18 runs", "%", 100.0 / 3.0, 5.0),
        Figure("our filter, 1 rad/s, worst of 18 runs", "%"),
        Figure("consistent filter with rest update, 1 rad/s, worst of 24 runs", "%", 0.5),
        Figure("consistent filter with rest update, 1 rad/s, worst inclination", "deg", 1.0),
        Figure("published structure, 10 degrees/s on x, left over", "deg/s", 2.0, judged_by="median"),
        Figure("published structure, order y < x < z of the offset's deviations", "1", 1.0, at_most=False),
        Figure("consistent filter, 10 degrees/s on x, left over", "deg/s", 0.5),
        Figure("consistent filter, order y < x < z of the offset's deviations", "1", 1.0, at_most=False),
        Figure("our filter, 10 degrees/s on x, left over", "deg/s", 0.5),
    ),
    measure=_recovery,
    plots=_recovery_plots,
)

_STILL_S = 600.0


def _still_chunk(seed: int) -> ImuChunk:
    generator = np.random.default_rng([seed, 10])
    shape = (1, round(_STILL_S / STEP_S), 3)
    rate = generator.normal(size=shape) * GYROSCOPE_SD_RADPS + np.radians([0.4, -0.3, 0.5])
    force = generator.normal(size=shape) * ACCELEROMETER_SD_MPS2 + [0.0, 0.0, GRAVITY_MPS2]
    return ImuChunk(0, STEP_S, rate, force, None, np.zeros(shape[:2], dtype=np.uint8))


def _still(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}

    def add(name: str, value: float) -> None:
        values.setdefault(name, []).append(float(value))

    for seed in seeds:
        chunk = _still_chunk(seed)
        bias = chunk.gyroscope_radps[:, :STILL_SAMPLES].mean(axis=1)
        true = np.radians([0.4, -0.3, 0.5])
        up = np.tile([1.0, 0.0, 0.0, 0.0], (chunk.tick_count, 1))
        for title, (name, parameters) in _FILTERS.items():
            if title == "published structure":
                continue
            filter_ = orientation.create(name, 1, STEP_S, parameters)
            filter_.set_gyroscope_bias(bias, GYROSCOPE_SD_RADPS / np.sqrt(STILL_SAMPLES))
            result = filter_.update(chunk)
            errors = inclination_errors_deg(vertical_in_sensor(result.q_earth_sensor[0]), up)
            add(f"{title}, inclination", root_mean_square(errors[STILL_SAMPLES:]))
            off = np.degrees(np.abs(result.gyroscope_bias_radps[0, 6000:, :2] - true[:2])).max()
            add(f"{title}, offset error of x and y after a minute", off)
            if name == "luinge_inclination":
                sigma = np.degrees(np.sqrt(np.diag(filter_.state()["covariance"][0])[3:6]))
                start = np.degrees(GYROSCOPE_SD_RADPS / np.sqrt(STILL_SAMPLES))
                add(
                    f"{title}, deviation of the offset's x and y, share of the start", sigma[:2].max() / start
                )
                add(f"{title}, deviation of the offset's z, share of the start", sigma[2] / start)
    return {name: np.array(found) for name, found in values.items()}


def _still_plots(data: Data) -> tuple[Plot, ...]:
    chunk = _still_chunk(0)
    found = orientation.create("luinge_inclination", 1, STEP_S, CONSISTENT).update(chunk)
    residual = np.degrees(found.gyroscope_bias_radps[0] - np.radians([0.4, -0.3, 0.5]))
    time_s = chunk.time_s[::200]
    curves = tuple(Curve(axis, time_s, residual[::200, column]) for column, axis in enumerate("xyz"))
    rate = {axis: np.degrees(chunk.gyroscope_radps[0, :, column]) for column, axis in enumerate("xyz")}
    return (
        Plot("Offset left over at rest", "time", "s", "offset error", "deg/s", curves),
        allan_plot("Simulated gyroscope at rest", "deg/s", rate, STEP_S),
    )


STILL_SENSOR = Protocol(
    name="inclination_still_sensor",
    title="V10 Ten minutes at rest without a rest update",
    source="Luinge and Veltink 2005, 4.2 (noise); method page S6, V10",
    what="A still sensor whose offset was measured over four seconds: inclination must hold, the offset of the "
    "level axes must become known, and that of the vertical axis must be reported as ever less known, since "
    "nothing shows it.",
    figures=(
        Figure("consistent filter, inclination", "deg", 0.3),
        Figure("consistent filter, offset error of x and y after a minute", "deg/s", 0.1),
        Figure("consistent filter, deviation of the offset's x and y, share of the start", "1", 1.0),
        Figure("consistent filter, deviation of the offset's z, share of the start", "1", 1.0, at_most=False),
        Figure("our filter, inclination", "deg", 0.3),
        Figure("our filter, offset error of x and y after a minute", "deg/s", 0.1),
    ),
    measure=_still,
    plots=_still_plots,
)
