"""What a magnetic session is told about its coils: nominal ones, windings, and those of a source that was measured."""

import json
from dataclasses import replace

import numpy as np
import pytest

from estimators import pipelines
from estimators.errors import SetupError
from estimators.magnetic import Coil, RelativePoseFilter, Source, perpendicular_source
from estimators.pipelines import SessionSetup, relative_source
from estimators.pipelines.relative.source import NOMINAL_GAIN_SIGMA
from estimators.simulation.coils import relative_motion, relative_scene, run_closed_loop

NOMINAL = perpendicular_source(0.06)


def setup(**parameters):
    return SessionSetup("relative_pose", ("pelvis", "sternum"), 100.0, orientation_parameters=parameters)


def gain_of(one):
    return pipelines.create(one).filters["sternum"].parameters["gain_sigma"]


def made(seed):
    """Coils as they are wound by hand: 2 % of the moment, 2 mm of the place, 1.7 degrees of the axis."""
    rng = np.random.default_rng([seed, 5])
    return Source(
        tuple(
            replace(
                coil,
                turns=coil.turns * (1.0 + rng.normal(0.0, 0.02)),
                centre_m=tuple((np.array(coil.centre_m) + rng.normal(0.0, 0.002, 3)).tolist()),
                axis=tuple((np.array(coil.axis) + rng.normal(0.0, 0.021, 3)).tolist()),
            )
            for coil in NOMINAL.coils
        )
    )


def test_coils_that_nobody_measured_are_believed_less():
    assert gain_of(setup()) == NOMINAL_GAIN_SIGMA == 0.04
    assert gain_of(setup(gain_sigma=0.01)) == 0.01


def test_calibrated_coils_take_the_place_of_nominal_ones_and_survive_json():
    true = made(1)
    wanted = setup(
        calibrated_coils=[coil.to_dict() for coil in true.coils],
        gain_sigma=0.004,
        source_serial="S-7",
        coil_turns=999.0,
    )
    again = SessionSetup.from_dict(json.loads(json.dumps(wanted.to_dict())))
    told = relative_source(again)
    assert (told.is_calibrated, told.source_serial) == (True, "S-7")
    assert told.coils.coils == true.coils
    assert gain_of(again) == 0.004


def test_a_winding_is_reached_by_the_setup():
    told = relative_source(setup(coil_length_m=0.012, coil_depth_m=0.008, coil_layers=[3, 2])).coils
    coil = told.coils[1]
    assert (coil.length_m, coil.depth_m, coil.layers) == (0.012, 0.008, (3, 2))
    assert told.loops.shape == (18, 10)
    near = np.array([0.03, 0.0, 0.12])
    wide, thin = told.field(2, 1.0, near), NOMINAL.field(2, 1.0, near)
    # Of the order of (length / distance)^2: a per cent this near, and less farther out.
    assert 2e-4 < np.linalg.norm(wide - thin) / np.linalg.norm(thin) < 2e-2
    assert pipelines.create(setup(coil_length_m=0.012, coil_layers=[3, 1])).source.coil_layers == (3, 1)


@pytest.mark.parametrize(
    ("parameters", "match"),
    [
        ({"calibrated_coils": [Coil().to_dict()] * 3}, "gain_sigma"),
        ({"calibrated_coils": [Coil().to_dict()] * 2, "gain_sigma": 0.01}, "three coils"),
        ({"calibrated_coils": [{"turns": 50, "colour": 1}] * 3, "gain_sigma": 0.01}, "colour"),
        ({"calibrated_coils": [{"turns": "many"}] * 3, "gain_sigma": 0.01}, "needs numbers"),
        ({"calibrated_coils": "coils", "gain_sigma": 0.01}, "list of coils"),
        ({"calibrated_coils": [Coil(turns=-900.0).to_dict()] * 3, "gain_sigma": 0.01}, "A m²"),
        ({"coil_layers": [2]}, "whole numbers"),
        ({"coil_layers": [0, 2]}, "one layer"),
        ({"coil_layers": [50, 50]}, "at most 100"),
        ({"coil_depth_m": 0.2}, "below its diameter"),
    ],
)
def test_what_describes_no_source_is_refused(parameters, match):
    with pytest.raises(SetupError, match=match):
        pipelines.create(setup(**parameters))


@pytest.mark.slow
def test_a_source_wound_by_hand_starts_and_its_error_is_within_what_is_said():
    errors, starts = [], []
    for gain in (0.002, NOMINAL_GAIN_SIGMA):
        started, normalised = 0, []
        for seed in (1, 2, 3, 4):
            scene = relative_scene(made(seed), relative_motion("shoulder", 10.0, seed), 10.0, seed=seed)
            own = {"mounting_direction": tuple(scene.position_m[0].tolist()), "gain_sigma": gain}
            result, _ = run_closed_loop(scene, RelativePoseFilter(NOMINAL, scene.time_step_s, own), seed=seed)
            known = (scene.time_s > 5.0) & ((result.flags & 1) == 0)
            started += bool(known.any())
            off = (result.position_m - scene.position_m)[known]
            sigma = np.sqrt(np.einsum("kii->ki", result.covariance[known, :3, :3]))
            normalised += [np.mean((off / sigma) ** 2)] if len(off) else []
        starts.append(started)
        errors.append(np.mean(normalised) if normalised else np.inf)
    # To 0.2 % most of these sources fit no pose at all.
    assert starts[1] == 4 > starts[0]
    assert errors[1] < 1.5
