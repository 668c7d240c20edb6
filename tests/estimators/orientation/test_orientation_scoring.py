"""The split of an orientation error into heading and inclination."""

import subprocess
import sys

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.orientation import available, create, orientation_errors


def test_known_errors_are_split():
    truth = rotation.normalize(np.random.default_rng(1).standard_normal((50, 4)))
    turned = rotation.multiply(rotation.about_z(0.2), truth)
    errors = orientation_errors(turned, truth)
    assert errors.total_rad == pytest.approx(0.2)
    assert errors.heading_rad == pytest.approx(0.2)
    assert errors.inclination_rad == pytest.approx(0.0, abs=1e-12)
    tilted = orientation_errors(-rotation.multiply(rotation.about_x(0.1), truth), truth)
    assert tilted.inclination_rad == pytest.approx(0.1)
    assert tilted.heading_rad == pytest.approx(0.0, abs=1e-12)


def test_samples_without_truth_or_outside_the_mask_do_not_count():
    truth = np.tile(rotation.identity(), (10, 1))
    estimate = truth.copy()
    estimate[5:] = rotation.about_z(1.0)
    truth[0] = np.nan
    errors = orientation_errors(estimate, truth, np.arange(10) < 5)
    assert (errors.total_rad, errors.sample_count) == (0.0, 4)
    with pytest.raises(ShapeError):
        orientation_errors(estimate, truth, np.zeros(10, dtype=bool))
    with pytest.raises(ShapeError):
        orientation_errors(estimate, truth[:3])


def test_registry_names_and_refuses():
    assert set(available()) >= {
        "vqf",
        "marzouk_quaternion_ekf",
        "marzouk_error_state_ekf",
        "marzouk_euler_ekf",
        "luinge_inclination",
        "roetenberg_disturbance",
    }
    titles = [kind.title for kind in available().values()]
    assert len(set(titles)) == len(titles)
    with pytest.raises(SetupError, match=r"known are .*\bvqf\b"):
        create("madgwick", 1, 0.01)


def test_a_published_filter_is_loaded_when_it_is_chosen():
    program = (
        "import sys; from estimators.orientation import create;"
        "create('telemotion', 1, 0.01); print('published' in sys.modules);"
        "print(create('luinge_inclination', 1, 0.01).name, 'published.marzouk' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "luinge_inclination", "False"]
