"""The stochastic measurement model of one coil (Schepers and Veltink 2010) against the published bench."""

from collections.abc import Sequence

import numpy as np

from estimators import rotation
from estimators.magnetic import Coil, IronSphere, Source, extract_pulses
from estimators.magnetic.published import (
    curvature_per_m2,
    linearisation_error_percent,
    noise_covariance,
    predict,
    range_m,
    update,
)
from estimators.recording import Float
from validation.magnetic.map_plots import map_plots
from validation.protocol import Data, Figure, Protocol, Values

BENCH = Source((Coil(axis=(1.0, 0.0, 0.0)),))
"""The coil of the positioning table: axis along x."""
_CURRENT_A, _SIGMA_T = 0.91, 3e-8
_POINT = np.array([0.3, 0.1, 0.0])
_MILLIGAUSS = 1e7
_REFERENCE_M = 1e-3 * float(np.linalg.norm([1.60, 2.84, 3.25]))


def _one(value: float) -> Float:
    return np.array([value])


def _bench(seeds: Sequence[int], data: Data) -> Values:
    x, y = np.meshgrid(np.arange(0.20, 0.801, 0.05), np.arange(0.0, 0.51, 0.1))
    points = np.stack([x, y, np.zeros_like(x)], axis=-1)
    truth = BENCH.field(0, _CURRENT_A, points)
    rows: dict[str, list[float]] = {"x": [], "y": []}
    for seed in seeds:
        rng = np.random.default_rng([seed, 31])
        means = [rng.normal(0.0, _SIGMA_T, (count, *truth.shape)).mean(axis=0) for count in (8, 88)]
        measured = truth + means[0] - means[1]
        error = np.sqrt(np.mean((measured - truth) ** 2, axis=1)) * _MILLIGAUSS
        rows["x"].append(float(error[:, 0].mean()))
        rows["y"].append(float(error[:, 1].mean()))
    far = x[0] > 0.299
    dipole = BENCH.with_model("dipole").field(0, _CURRENT_A, points[:, far])
    excess = np.sqrt(np.mean((dipole - truth[:, far]) ** 2, axis=1)) * _MILLIGAUSS
    # Pulses through the extraction: 10 on, 90 off, 8 and 88 used.
    state = np.zeros(2000 * 20, dtype=np.int64)
    state.reshape(-1, 100)[:, 45:55] = 1
    deviations = []
    for seed in seeds:
        field = np.random.default_rng([seed, 37]).normal(0.0, _SIGMA_T, (len(state), 3))
        pulses = extract_pulses(field, state, _CURRENT_A, None, before=4, after=4)
        values = np.array([pulse.field_sensor_t for pulse in pulses])
        deviations.append(float(values.std() * _MILLIGAUSS))
    return {
        "exact model, axial, rms": np.array(rows["x"]),
        "exact model, radial, rms": np.array(rows["y"]),
        "dipole, axial, rms over the lines": _one(float(excess[:, 0].mean())),
        "dipole, radial, rms over the lines": _one(float(excess[:, 1].mean())),
        "noise of a pulse of 8 on 8 samples, off theory": np.abs(np.array(deviations) / 0.150 - 1.0) * 100.0,
    }


_MAP_X = {
    0.1: (6.42, 3.89, 2.53, 1.75, 1.28, 0.76),
    0.3: (2.42, 1.53, 1.19, 0.99, 0.83, 0.58),
    0.5: (1.36, 1.01, 0.73, 0.57, 0.48, 0.38),
}
_MAP_Y = {
    0.1: (4.37, 2.23, 1.38, 0.94, 0.68, 0.40),
    0.3: (3.67, 2.13, 1.25, 0.80, 0.56, 0.33),
    0.5: (1.90, 1.52, 1.12, 0.80, 0.57, 0.32),
}
_IRON = {
    (0.2, 0.1): 41.9,
    (0.2, 0.05): 46.2,
    (0.1, 0.1): 13.6,
    (0.3, 0.2): 9.9,
    (0.4, 0.1): 8.3,
    (0.5, 0.1): 0.56,
    (0.3, 0.3): 0.79,
    (0.1, 0.3): 0.52,
    (0.6, 0.1): 0.10,
}


def _maps(seeds: Sequence[int], data: Data) -> Values:
    worst = 0.0
    places = (0.2, 0.3, 0.4, 0.5, 0.6, 0.8)
    for table, step in ((_MAP_X, (0.03, 0.0, 0.0)), (_MAP_Y, (0.0, 0.03, 0.0))):
        for y, row in table.items():
            points = np.array([[x, y, 0.0] for x in places])
            found = linearisation_error_percent(BENCH, 0, points, step)
            worst = max(worst, float(np.abs(found - row).max()))
    halved = linearisation_error_percent(BENCH, 0, _POINT, [0.015, 0.0, 0.0])
    ratio = float(linearisation_error_percent(BENCH, 0, _POINT, [0.03, 0.0, 0.0]) / halved)
    curvature = curvature_per_m2(BENCH, 0, np.array([_POINT, [0.6, 0.3, 0.0]]))[:, :2]
    bend = float(np.abs(curvature / [[98.4, 52.6], [19.4, 12.8]] - 1.0).max()) * 100.0
    grid = np.stack(np.meshgrid(np.linspace(0.1, 0.9, 33), np.linspace(0.0, 0.6, 25)), axis=-1)
    points = np.concatenate([grid, np.zeros((*grid.shape[:2], 1))], axis=-1).reshape(-1, 3)
    points = points[np.linalg.norm(points, axis=1) > 0.2]
    errors = linearisation_error_percent(BENCH, 0, points, [0.03, 0.0, 0.0])
    predicted = 50.0 * 0.03**2 * curvature_per_m2(BENCH, 0, points)[:, 0]
    alike = float(np.corrcoef(np.log(errors), np.log(predicted))[0, 1])
    sphere = IronSphere.of_cylinder(0.05, 0.05)
    field = BENCH.field(0, 1.0, _POINT)
    amiss = 0.0
    for place, percent in _IRON.items():
        at = np.array([*place, 0.0])
        found_percent = (
            100.0
            * float(np.linalg.norm(sphere.disturbance(BENCH.field(0, 1.0, at), _POINT - at)))
            / float(np.linalg.norm(field))
        )
        # The table is rounded to two or three digits.
        amiss = max(amiss, max(0.0, abs(found_percent - percent) - 0.05) / percent * 100.0)
    plane = float(np.linalg.norm(BENCH.field(0, _CURRENT_A, [0.0, 0.8, 0.0]))) / _SIGMA_T
    axis = float(np.linalg.norm(BENCH.field(0, _CURRENT_A, [0.8, 0.0, 0.0]))) / _SIGMA_T
    reach = range_m(BENCH.coils[0].moment_m2 * _CURRENT_A, 2.8, _SIGMA_T)
    return {
        "linearisation map, largest difference": _one(worst),
        "error ratio of a step and its half, at least": _one(ratio),
        "error ratio of a step and its half, at most": _one(ratio),
        "curvature, largest difference": _one(bend),
        "curvature against error, log correlation": _one(alike),
        "iron positions, largest difference": _one(amiss),
        "signal to noise at 0.8 m in the plane, off 2.83": _one(abs(plane / 2.83 - 1.0) * 100.0),
        "signal to noise at 0.8 m on the axis, off 5.59": _one(abs(axis / 5.59 - 1.0) * 100.0),
        "range for a ratio of 2.8, at least": _one(reach),
        "range for a ratio of 2.8, at most": _one(reach),
    }


def _updates(seeds: Sequence[int], data: Data) -> Values:
    prior, noise = 1e-4 * np.eye(6), noise_covariance(np.zeros(3), 1, 0)
    q = np.array([1.0, 0.0, 0.0, 0.0])
    clean = predict(BENCH, 0, _CURRENT_A, _POINT, q).field_sensor_t
    reference = {
        (1, 1): (10.8, 16.1, 12.3),
        (-1, 1): (6.2, 24.1, 7.2),
        (1, 5): (7.3, 23.1, 1.9),
        (-1, 5): (7.0, 12.1, 18.9),
    }
    off = 0.0
    for (sign, passes), percent in reference.items():
        error = np.array([0.01] * 3 + [sign * 0.01] * 3)
        found = update(
            BENCH, 0, _CURRENT_A, _POINT + error[:3], rotation.exp(error[3:]), prior, clean, noise, passes
        )
        off = max(off, float(np.abs(np.abs(found.position_m - _POINT) * 1e4 - percent).max()))
    nees: dict[int, list[float]] = {1: [], 5: []}
    left = []
    for seed in seeds:
        rng = np.random.default_rng([seed, 41])
        errors = rng.normal(0.0, 0.01, (1500, 6))
        measured = clean + rng.normal(0.0, _SIGMA_T, (1500, 3))
        for passes, values in nees.items():
            found = update(
                BENCH,
                0,
                _CURRENT_A,
                _POINT + errors[:, :3],
                rotation.exp(errors[:, 3:]),
                prior,
                measured,
                noise,
                passes,
            )
            after = np.concatenate([found.position_m - _POINT, rotation.log(found.q_source_sensor)], axis=1)
            solved = np.linalg.solve(found.covariance, after[..., None])[..., 0]
            values.append(float(np.mean(np.sum(after * solved, axis=1)) / 6.0))
        # In space: the reference is one draw and its axes have their own chance.
        left.append(float(np.sqrt(np.mean(np.sum(after[:, :3] ** 2, axis=1)))) / _REFERENCE_M)
    return {
        "one update, off the reference": _one(off),
        "iterated update, NEES, largest": np.array(nees[5]),
        "iterated update, NEES, least": np.array(nees[5]),
        "single update, NEES": np.array(nees[1]),
        "iterated update, position over reference": _one(float(np.mean(left))),
        **_beside_iron(clean, prior, noise),
    }


def _beside_iron(clean: Float, prior: Float, noise: Float) -> Values:
    """Return what a piece of iron near the sensor does to one update."""
    sphere = IronSphere.of_cylinder(0.05, 0.05)
    at = np.array([0.1, 0.1, 0.0])
    bent = clean + sphere.disturbance(BENCH.field(0, _CURRENT_A, at), _POINT - at)
    share, plain, nis, same = [], [], [], True
    for turned in (0.01, -0.01):
        error = np.array([0.01] * 3 + [turned] * 3)
        start = (_POINT + error[:3], rotation.exp(error[3:]))
        disturbed = update(BENCH, 0, _CURRENT_A, *start, prior, bent, noise, 1)
        undisturbed = update(BENCH, 0, _CURRENT_A, *start, prior, clean, noise, 1)
        share.append(np.abs(disturbed.position_m - _POINT) * 1e4)
        plain.append(np.abs(undisturbed.position_m - _POINT) * 1e4)
        nis.append(float(disturbed.nis))
        same = same and bool(np.array_equal(disturbed.covariance, undisturbed.covariance))
    return {
        "iron, largest position error over the prior": _one(float(np.min([s.max() for s in share]))),
        "iron, mean error over the undisturbed": _one(float(np.mean(share) / np.mean(plain))),
        "iron, normalised innovation": _one(min(nis)),
        "iron, covariance the same": _one(float(same)),
    }


MAGNETIC_BENCH = Protocol(
    name="magnetic_bench",
    title="Coil model on the positioning table",
    source="Schepers and Veltink 2010, 3.1, fig. 4, 5; method page 8.1, 8.2",
    what="Positions of the table, pulses of 10 on and 90 off samples with 0.3 mG noise; rms per line and axis. "
    "The dipole from 0.3 m without noise (reference 0.148 and 0.074 mG), and the noise of a pulse value.",
    figures=(
        Figure("exact model, axial, rms", "mG", 0.14, 0.50, judged_by="median"),
        Figure("exact model, radial, rms", "mG", 0.14, 0.14, judged_by="median"),
        Figure("dipole, axial, rms over the lines", "mG", 0.151, 0.53),
        Figure("dipole, radial, rms over the lines", "mG", 0.0755, 0.18),
        Figure("noise of a pulse of 8 on 8 samples, off theory", "%", 3.0, judged_by="median"),
    ),
    measure=_bench,
)
MAGNETIC_MAPS = Protocol(
    name="magnetic_maps",
    title="Validity of the linear model, iron, range",
    source="Schepers and Veltink 2010, fig. 6 to 9; method page 8.4, 8.5, 8.7, 8.8",
    what="Linearisation error for a step of 3 cm over the measuring volume, curvature as its predictor, the "
    "change of the field by an iron cylinder, and the range.",
    figures=(
        Figure("linearisation map, largest difference", "%", 0.02),
        Figure("error ratio of a step and its half, at least", "1", 3.6, at_most=False),
        Figure("error ratio of a step and its half, at most", "1", 4.1),
        Figure("curvature, largest difference", "%", 1.0),
        Figure("curvature against error, log correlation", "1", 0.999, at_most=False),
        Figure("iron positions, largest difference", "%", 2.0),
        Figure("signal to noise at 0.8 m in the plane, off 2.83", "%", 0.5),
        Figure("signal to noise at 0.8 m on the axis, off 5.59", "%", 0.5),
        Figure("range for a ratio of 2.8, at least", "m", 0.75, 0.80, at_most=False),
        Figure("range for a ratio of 2.8, at most", "m", 0.85, 0.80),
    ),
    measure=_maps,
    plots=map_plots,
)
MAGNETIC_UPDATES = Protocol(
    name="magnetic_updates",
    title="One update of a pose, with and without iron",
    source="Schepers and Veltink 2010, 3.3; method page 8.6",
    what="Errors of 1 cm and 0.01 rad at (0.3, 0.1) m; 1500 random draws a seed for consistency; iron at (0.1, 0.1) m.",
    figures=(
        Figure("one update, off the reference", "%", 0.5),
        Figure("iterated update, NEES, largest", "1", 1.10),
        Figure("iterated update, NEES, least", "1", 0.90, at_most=False),
        Figure("single update, NEES", "1"),
        Figure("iterated update, position over reference", "1", 1.05),
        Figure("iron, largest position error over the prior", "%", 47.0, 92.0, at_most=False),
        Figure("iron, mean error over the undisturbed", "1", 5.0, at_most=False),
        Figure("iron, normalised innovation", "1", 11.34, at_most=False),
        Figure("iron, covariance the same", "1", 1.0, at_most=False),
    ),
    measure=_updates,
)
