"""Parameters carry unit, bound and meaning, and are held to their bounds."""

import pytest

from estimators.errors import SetupError
from estimators.orientation._parameters import meaning_of, read_parameters
from estimators.orientation.smoother import SmootherParameters
from estimators.orientation.telemotion._parameters import TelemotionParameters
from estimators.orientation.vqf import VqfParameters
from published.luinge import LuingeParameters
from published.marzouk._error_state import ErrorStateParameters
from published.marzouk._euler import EulerParameters
from published.marzouk._quaternion import QuaternionParameters
from published.roetenberg import RoetenbergParameters


@pytest.mark.parametrize(
    "kind",
    [
        LuingeParameters,
        RoetenbergParameters,
        ErrorStateParameters,
        EulerParameters,
        QuaternionParameters,
        VqfParameters,
        TelemotionParameters,
        SmootherParameters,
    ],
)
def test_every_number_says_its_unit_and_meaning(kind):
    meanings = meaning_of(kind)
    assert set(meanings) == set(vars(kind()))
    for name, said in meanings.items():
        assert said.meaning
        for tail, unit in (
            ("_s", "s"),
            ("_deg", "deg"),
            ("_degps", "deg/s"),
            ("_mps2", "m/s^2"),
            ("_ut", "uT"),
        ):
            if name.endswith(tail) and not name.endswith("sqrt_s"):
                assert said.unit == unit, name


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gyroscope_sigma_radps", 0.0),
        ("start_samples", 0.0),
        ("acceleration_correlation", 1.0),
        ("coast_s", -0.1),
        ("magnetometer_sigma", 0.0),
    ],
)
def test_what_is_out_of_bounds_is_refused(name, value):
    with pytest.raises(SetupError, match=name):
        read_parameters(RoetenbergParameters, {name: value})
