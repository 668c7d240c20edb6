"""Curves of a session of the arms; see `app.recordings.analysis.series`."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from app.recordings.analysis.curve import Curve, Series
from app.recordings.points import described
from estimators.arm import ACCELERATION_WINDOW_S
from estimators.balance import MASS_SCALARS
from estimators.pipelines import Frames, SessionSetup
from estimators.sentences import say

_PLACES: Final = MASS_SCALARS[:3]


def _points(frames: Frames, setup: SessionSetup) -> list[Curve]:
    """Elbows, wrists and hands in the room, x where the patient faces and z up; speed and acceleration of their own."""
    found = described(frames, setup.body)
    curves = []
    for p, name in enumerate(found.names):
        curves += [
            Curve(f"{name}.{axis}", "m", found.position_m[:, p, i], found.sigma_m[:, p, i])
            for i, axis in enumerate("xyz")
        ]
        for quantity, unit, values in (
            ("speed", "m/s", found.velocity_mps),
            ("acceleration", "m/s²", found.acceleration_mps2),
        ):
            curves.append(Curve(f"{name}.{quantity}", unit, np.linalg.norm(values[:, p], axis=1)))
    return curves


def _mass_centre(frames: Frames, setup: SessionSetup) -> list[Curve]:
    """Ahead and left of the middle between the ankles, as the trunk faces, and above the floor.

    Sigma is of the sensors, of segments that are assumed, and of the table of the body.
    """
    columns = [frames.layout.scalars.index(name) for name in MASS_SCALARS]
    values = frames.scalar[:, columns].astype(np.float64)
    return [Curve(name, "m", values[:, i], values[:, len(_PLACES) + i]) for i, name in enumerate(_PLACES)]


def _lacks_mass_centre(_: SessionSetup, layout: Mapping[str, Any]) -> str:
    return "" if MASS_SCALARS[0] in layout["scalars"] else say("mass_centre.sensors")


SERIES: Final = (
    Series("arm_points", _points, margin_s=ACCELERATION_WINDOW_S),
    Series("mass_centre", _mass_centre, _lacks_mass_centre),
)
