"""V11 to V13 of Luinge and Veltink (2005): honest covariance, exact integration, reference alignment."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError
from estimators.orientation.published import align_marker_frame
from estimators.recording import Float, ImuChunk
from published._strapdown_estimator import StrapdownResult
from validation.inclination.scenes import (
    ACCELEROMETER_SD_MPS2,
    CONSISTENT,
    GYROSCOPE_SD_RADPS,
    STEP_S,
    inclination_errors_deg,
    root_mean_square,
    seconds,
    vertical_in_sensor,
)
from validation.protocol import Curve, Data, Figure, Plot, Protocol, Values

_SECONDS = 300
_SCORED_AFTER = 1000
_UP = np.array([0.0, 0.0, 1.0])


def _model_exact(seeds: Sequence[int]) -> tuple[ImuChunk, Float]:
    """S7: acceleration by the filter's own model, turning at random with 3 rad/s; one sensor a seed."""
    generators = [np.random.default_rng([seed, 11]) for seed in seeds]
    ticks = round(_SECONDS / STEP_S)
    noise = np.stack([generator.normal(size=(4, ticks, 3)) for generator in generators], axis=1)
    rate, acceleration = np.zeros_like(noise[0]), np.zeros_like(noise[1])
    q = np.empty((len(seeds), ticks, 4))
    q[:, 0] = [rotation.normalize(generator.normal(size=4)) for generator in generators]
    memory = 0.98
    for k in range(1, ticks):
        rate[:, k] = memory * rate[:, k - 1] + 3.0 * np.sqrt(1.0 - memory**2) * noise[0, :, k]
        acceleration[:, k] = 0.6 * acceleration[:, k - 1] + 0.4 * noise[1, :, k]
    turns = rotation.exp(rate * STEP_S)
    for k in range(1, ticks):
        q[:, k] = rotation.multiply(q[:, k - 1], turns[:, k])
    force = rotation.rotate(rotation.conjugate(q), acceleration + GRAVITY_MPS2 * _UP)
    return (
        ImuChunk(
            0,
            STEP_S,
            rate + GYROSCOPE_SD_RADPS * noise[2],
            force + ACCELEROMETER_SD_MPS2 * noise[3],
            None,
            np.zeros((len(seeds), ticks), dtype=np.uint8),
        ),
        q,
    )


def _consistency(seeds: Sequence[int], data: Data) -> Values:
    chunk, truth = _model_exact(seeds)
    bias = np.zeros((len(seeds), 3))
    filter_ = orientation.create(
        "luinge_inclination", len(seeds), STEP_S, CONSISTENT | {"report_details": True}
    )
    filter_.set_gyroscope_bias(bias, 5e-4)
    found = filter_.update(chunk)
    # Heading is arbitrary: what counts is how far the true vertical, seen by the estimate, leans.
    tilt = np.cross(
        np.broadcast_to(_UP, (*truth.shape[:2], 3)),
        rotation.rotate(found.q_earth_sensor, vertical_in_sensor(truth)),
    )[..., :2]
    if (
        not isinstance(found, StrapdownResult)
        or found.sigma_rad is None
        or found.whitened_innovations is None
    ):
        raise SetupError("the filter stated neither covariance nor innovations")
    squares = ((tilt / found.sigma_rad[..., :2]) ** 2).sum(axis=-1)[:, _SCORED_AFTER:]
    innovations = found.whitened_innovations[:, _SCORED_AFTER:]
    scaled = innovations - innovations.mean(axis=1, keepdims=True)
    variance = innovations.var(axis=1).mean(axis=-1)
    correlations = [
        np.abs((scaled[:, lag:] * scaled[:, :-lag]).mean(axis=1) / scaled.var(axis=1)).max(axis=-1)
        for lag in range(1, 6)
    ]
    inclination = inclination_errors_deg(vertical_in_sensor(found.q_earth_sensor), truth)[:, _SCORED_AFTER:]
    return {
        # Tilt errors last for tens of seconds, so that five minutes are a small sample: the runs count together.
        "squared tilt error over its variance, mean of the runs, off 2": np.array(
            [abs(squares.mean() - 2.0)]
        ),
        "variance of the whitened innovations, off 1": np.abs(variance - 1.0),
        "correlation of the innovations, lags 1 to 5": np.max(correlations, axis=0),
        "inclination": np.array([root_mean_square(run) for run in inclination]),
        "coning, mean rates": np.array([_coning_deg(instantaneous=False)]),
        "coning, instantaneous rates": np.array([_coning_deg(instantaneous=True)]),
    } | _alignment(seeds)


def _cone(time_s: Float) -> Float:
    """Return a turn of 20 degrees about a level axis that goes round once a second."""
    turn = 2.0 * np.pi * time_s
    return rotation.exp(np.radians(20.0) * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1))


def _coning_deg(*, instantaneous: bool) -> float:
    """V12: largest error of a minute of noiseless coning, gravity left out."""
    time_s = seconds(6001)
    q, h = _cone(time_s), 1e-5
    rate = np.zeros((len(time_s), 3))
    if instantaneous:
        rate = rotation.log(rotation.multiply(rotation.conjugate(_cone(time_s - h)), _cone(time_s + h))) / (
            2 * h
        )
    else:
        rate[1:] = rotation.log(rotation.multiply(rotation.conjugate(q[:-1]), q[1:])) / STEP_S
    force = rotation.rotate(rotation.conjugate(q), np.broadcast_to(GRAVITY_MPS2 * _UP, (len(q), 3)))
    parameters = {
        "instantaneous_rate": instantaneous,
        "start_samples": 1.0,
        "use_gravity": False,
        "use_field": False,
    }
    quality = np.zeros((1, len(time_s)), dtype=np.uint8)
    found = orientation.create("roetenberg_disturbance", 1, STEP_S, parameters).update(
        ImuChunk(0, STEP_S, rate[None], force[None], None, quality)
    )
    since = [rotation.multiply(rotation.conjugate(p[:1]), p) for p in (found.q_earth_sensor[0], q)]
    return float(np.degrees(rotation.angle_between(since[0], since[1]).max()))


def _alignment(seeds: Sequence[int]) -> Values:
    """V13: two poses a right angle apart, one accelerometer axis off by 0.2 m/s^2; 25 cases a seed."""
    means, worst = [], []
    for seed in seeds:
        generator = np.random.default_rng([seed, 13])
        errors = []
        for _ in range(25):
            true, first = (Rotation.random(rng=generator) for _ in range(2))
            lean = generator.normal(size=3)
            lean[2] = 0.0
            second = Rotation.from_rotvec(np.pi / 2.0 * lean / np.linalg.norm(lean)) * first
            poses = [first, second]
            bias = 0.2 * np.eye(3)[generator.integers(3)]
            force = np.array([(pose * true).inv().apply(GRAVITY_MPS2 * _UP) + bias for pose in poses])
            found = align_marker_frame(force, np.array([rotation.from_scipy(pose) for pose in poses]))
            errors.append(np.degrees((rotation.to_scipy(found) * true.inv()).magnitude()))
        means.append(np.mean(errors))
        worst.append(np.max(errors))
    return {
        "reference alignment, mean error": np.array(means),
        "reference alignment, largest error": np.array(worst),
    }


def _plots(data: Data) -> tuple[Plot, ...]:
    chunk, _ = _model_exact([0])
    filter_ = orientation.create("luinge_inclination", 1, STEP_S, CONSISTENT | {"report_details": True})
    filter_.set_gyroscope_bias(np.zeros((1, 3)), 5e-4)
    innovations = filter_.update(chunk).whitened_innovations[0, _SCORED_AFTER:]  # type: ignore[attr-defined]
    edges = np.linspace(-4.0, 4.0, 41)
    middle = 0.5 * (edges[:-1] + edges[1:])
    shares = np.histogram(innovations, edges, density=True)[0]
    normal = np.exp(-0.5 * middle**2) / np.sqrt(2.0 * np.pi)
    curves = (Curve("innovations", middle, shares), Curve("normal distribution", middle, normal))
    return (Plot("Residuals over their predicted deviation", "residual", "1", "share", "1", curves),)


CONSISTENCY = Protocol(
    name="inclination_consistency",
    title="V11 to V13 Honest covariance, integration and alignment",
    source="Luinge and Veltink 2005, 2.2 to 2.4 and 3.1 (P8); method page E-7, S7, V11 to V13",
    what="Five minutes in which acceleration obeys the filter's own model: squared error over reported variance "
    "must be 2 (two tilt angles), innovations white with variance 1. Then a minute of coning through the "
    "strapdown integration, and the alignment of optical markers with a sensor from two still poses "
    "(published reference below 1 and 1.1 degrees).",
    figures=(
        Figure("squared tilt error over its variance, mean of the runs, off 2", "1", 0.4),
        Figure("variance of the whitened innovations, off 1", "1", 0.05),
        Figure("correlation of the innovations, lags 1 to 5", "1", 0.06),
        Figure("inclination", "deg", 0.5),
        Figure("coning, mean rates", "deg", 1e-6),
        Figure("coning, instantaneous rates", "deg", 1.0),
        Figure("reference alignment, mean error", "deg", 1.2, 1.1),
        Figure("reference alignment, largest error", "deg", 1.8),
    ),
    measure=_consistency,
    plots=_plots,
)
