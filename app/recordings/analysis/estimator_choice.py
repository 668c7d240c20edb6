"""The orientation estimators as a choice for people: a sentence each, parameters with units and defaults."""

from typing import Any, Final

from app.recordings.schemas import EstimatorOut, ParameterOut
from estimators import orientation

_UNITS: Final[tuple[tuple[str, str], ...]] = (
    ("_degps_per_sqrt_s", "deg/s/√s"),
    ("_degps_sqrt_s", "deg/s·√s"),
    ("_deg_per_sqrt_s", "deg/√s"),
    ("_mps_per_sqrt_s", "m/s/√s"),
    ("_m_per_sqrt_s", "m/√s"),
    ("_mps_sqrt_s", "m/s·√s"),
    ("_ut_sqrt_s", "µT·√s"),
    ("_m_sqrt_s", "m·√s"),
    ("_sqrt_s", "√s"),
    ("_degps", "deg/s"),
    ("_radps", "rad/s"),
    ("_mps2", "m/s²"),
    ("_mps", "m/s"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_hz", "Hz"),
    ("_ut", "µT"),
    ("_m", "m"),
    ("_s", "s"),
)
"""Suffix of a parameter's name and the unit it stands for; the longest that fits counts."""


def estimators_out() -> list[EstimatorOut]:
    """Return the orientation estimators that a session can run with; the recommended one says so."""
    known = orientation.available(with_offline=True)
    made = {name: orientation.create(name, 1, 0.01).parameters for name in known}
    return [
        EstimatorOut(
            name=name,
            version=kind.version,
            title=kind.title,
            description=kind.description,
            parameters=made[name],
            parameter_list=[parameter_out(key, value) for key, value in made[name].items()],
            is_offline=kind.is_offline,
        )
        for name, kind in known.items()
    ]


def parameter_out(name: str, default: Any) -> ParameterOut:
    """Return one parameter with the unit that its name carries."""
    for suffix, unit in _UNITS:
        if name.endswith(suffix):
            return ParameterOut(
                name=name, label=_words(name.removesuffix(suffix)), unit=unit, default=default
            )
    return ParameterOut(name=name, label=_words(name), unit="", default=default)


def _words(name: str) -> str:
    return name.replace("_", " ").capitalize()
