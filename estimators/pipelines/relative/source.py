"""The source of a relative-pose session: where it is worn, its coils, and where sensors are from it."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np

from estimators.conventions import PLACEMENTS, Placement
from estimators.errors import SetupError
from estimators.magnetic import (
    CURRENT_SPAN_A,
    Coil,
    RelativePoseParameters,
    Source,
    perpendicular_source,
)
from estimators.pipelines._contract import SessionSetup
from estimators.recording import Float
from estimators.sentences import say

_USUAL_SOURCES: Final[tuple[Placement, ...]] = ("pelvis", "sternum", "foot_left")
_PLACE_M: Final[dict[str, tuple[float, float, float]]] = {
    "head": (0.05, 0.0, 1.65),
    "sternum": (0.10, 0.0, 1.30),
    "pelvis": (-0.10, 0.0, 1.00),
    "shoulder": (0.0, 0.15, 1.40),
    "upper_arm": (0.0, 0.25, 1.20),
    "forearm": (0.05, 0.28, 0.95),
    "hand": (0.08, 0.28, 0.78),
    "thigh": (0.08, 0.13, 0.75),
    "shank": (0.05, 0.10, 0.30),
    "foot": (0.10, 0.09, 0.06),
}
"""Where modules sit on a standing person with hanging arms, left side: x forward, y left, z up. Only the direction
from the source to a sensor is used, to choose between a place and its mirror image through the source."""
MOST_MOMENT_AM2: Final = 3.0
"""Four times that of the usual coils; more is no source to be worn."""
NOMINAL_GAIN_SIGMA: Final = 0.04
"""How wrong the field of coils is that nobody has measured, one sigma an axis, as a share of it.

At arm's length: 2 % of the moment (a millimetre of radius is 4 %), 2 mm of the centre (1 %), 1.5 degrees of the axis
(2 to 3 % across the field), 3.4 % together; a little more, because it lasts and pulses count it as new each time."""
MOST_LOOPS: Final = 100
"""That stand for one winding: more add nothing but time."""
ROUND_TRIP_S: Final = 0.5
"""A request is given up after this: the way to the network and back takes a good tenth of a second."""


@dataclass(frozen=True)
class SourceSettings:
    """The part of the setup's `orientation_parameters` that is not the filter's own.

    `source` is the placement that carries the coils; by default the pelvis, else the sternum, else the left foot.
    Coils are along the axes of their module, their centres `coil_offset_m` out. The source is worn with x forward
    and z up. `coil_length_m` along the axis, `coil_depth_m` along the radius and `coil_layers` (thin loops along and
    across) describe a winding that is not thin.

    `calibrated_coils` are those of a source that was measured, as `Coil.to_dict` gives them: they take the place of
    the other coil settings, and `gain_sigma` says how well they are known. `source_name`, `source_serial` and
    `calibrated_on` tell people which source that is.
    """

    source: str = ""
    coil_offset_m: float = 0.06
    coil_turns: float = 50.0
    coil_radius_m: float = 0.055
    current_limit_a: float = 1.5
    coil_length_m: float = 0.0
    coil_depth_m: float = 0.0
    coil_layers: tuple[int, int] = (1, 1)
    calibrated_coils: tuple[Mapping[str, Any], ...] = ()
    source_name: str = ""
    source_serial: str = ""
    calibrated_on: str = ""

    @property
    def is_calibrated(self) -> bool:
        """Whether the coils were measured."""
        return len(self.calibrated_coils) > 0

    @property
    def coils(self) -> Source:
        """The source that the settings describe."""
        if self.is_calibrated:
            return Source(
                tuple(Coil.from_dict(one) for one in self.calibrated_coils),
                current_limit_a=self.current_limit_a,
            )
        return perpendicular_source(
            self.coil_offset_m,
            self.coil_turns,
            self.coil_radius_m,
            self.current_limit_a,
            length_m=self.coil_length_m,
            depth_m=self.coil_depth_m,
            layers=self.coil_layers,
        )


def settings_of(setup: SessionSetup) -> tuple[SourceSettings, dict[str, Any]]:
    """Return what the setup says of the source, and the overrides of the filter.

    Coils that nobody has measured are believed to `NOMINAL_GAIN_SIGMA`.

    Raises
    ------
    SetupError
        For placements without a source and a sensor, and parameters that do not exist or describe no source.
    """
    given: Mapping[str, Any] = setup.orientation_parameters
    own = {field.name for field in fields(SourceSettings)}
    filters = {field.name for field in fields(RelativePoseParameters)}
    if unknown := sorted(set(given) - own - filters):
        raise SetupError(say("setup.unknown_parameters", unknown=unknown, known=sorted(own | filters)))
    settings = _read({name: value for name, value in given.items() if name in own})
    if len(setup.placements) < 2 or len(set(setup.placements)) != len(setup.placements):
        raise SetupError(say("setup.source_sensor"))
    source = settings.source or next((name for name in _USUAL_SOURCES if name in setup.placements), "")
    if source not in setup.placements:
        raise SetupError(say("setup.source_place", places=list(setup.placements)))
    numbers = (settings.coil_turns, settings.coil_radius_m, settings.current_limit_a)
    if min(numbers) <= 0.0 or settings.coil_offset_m < 0.0:
        raise SetupError(say("setup.coil_numbers"))
    overrides = {name: value for name, value in given.items() if name in filters}
    if settings.is_calibrated and "gain_sigma" not in overrides:
        raise SetupError(say("setup.gain_sigma"))
    coils = settings.coils.coils
    if len(coils) != 3:
        raise SetupError(say("setup.three_coils", coils=len(coils)))
    if max(coil.layers[0] * coil.layers[1] for coil in coils) > MOST_LOOPS:
        raise SetupError(say("setup.loops", most=MOST_LOOPS))
    moment_am2 = max(abs(coil.moment_m2) for coil in coils) * settings.current_limit_a
    if settings.current_limit_a >= CURRENT_SPAN_A or moment_am2 > MOST_MOMENT_AM2:
        raise SetupError(say("setup.coil_limit", current_a=CURRENT_SPAN_A, moment_am2=MOST_MOMENT_AM2))
    overrides.setdefault("gain_sigma", NOMINAL_GAIN_SIGMA)
    return replace(settings, source=source), overrides


def _read(given: Mapping[str, Any]) -> SourceSettings:
    """Return settings from what JSON holds."""
    values = dict(given)
    if "coil_layers" in values:
        try:
            along, across = values["coil_layers"]
            values["coil_layers"] = (int(along), int(across))
        except (TypeError, ValueError) as error:
            raise SetupError(say("setup.coil_layers")) from error
    if "calibrated_coils" in values:
        coils = values["calibrated_coils"]
        if not isinstance(coils, list | tuple) or not all(isinstance(one, Mapping) for one in coils):
            raise SetupError(say("setup.coil_list"))
        values["calibrated_coils"] = tuple(dict(one) for one in coils)
    return SourceSettings(**values)


def relative_source(setup: SessionSetup) -> SourceSettings:
    """Return where a relative-pose session wears its source, and its coils; `SetupError` as `settings_of`."""
    return settings_of(setup)[0]


def direction_between(source: str, sensor: str) -> tuple[float, float, float]:
    """Return the rough direction from one placement to another on a standing person; zero for unknown names."""
    way = way_between(source, sensor)
    if way is None:
        return (0.0, 0.0, 0.0)
    x, y, z = (way / np.linalg.norm(way)).tolist()
    return x, y, z


def way_between(source: str, sensor: str) -> Float | None:
    """Return roughly how far one placement is from another on a standing person, m; None for unknown names."""
    if source not in PLACEMENTS or sensor not in PLACEMENTS:
        return None
    return _place(sensor) - _place(source)


def _place(name: str) -> Float:
    base, _, side = name.rpartition("_")
    if side not in ("left", "right"):
        return np.array(_PLACE_M[name])
    mirror = -1.0 if side == "right" else 1.0
    return np.asarray(np.array(_PLACE_M[base]) * np.array([1.0, mirror, 1.0]))
