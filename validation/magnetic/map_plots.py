"""Maps of a coil as lines through them: where the linear model holds, and what iron changes."""

import numpy as np

from estimators.magnetic import Coil, IronSphere, Source
from estimators.magnetic.published import linearisation_error_percent
from validation.protocol import Curve, Data, Plot

_BENCH = Source((Coil(axis=(1.0, 0.0, 0.0)),))
_STEP_M = 0.03
_SENSOR_M = np.array([0.3, 0.1, 0.0])


def map_plots(data: Data) -> tuple[Plot, ...]:
    """Return linearisation errors over the measuring volume, and the disturbance by an iron cylinder in it."""
    x = np.linspace(0.1, 0.9, 81)
    plots = []
    for name, step in (("along the axis", (_STEP_M, 0.0, 0.0)), ("across the axis", (0.0, _STEP_M, 0.0))):
        curves = []
        for y in (0.0, 0.1, 0.2, 0.3, 0.5):
            points = np.stack([x, np.full_like(x, y), np.zeros_like(x)], axis=-1)
            error = linearisation_error_percent(_BENCH, 0, points, step)
            # Nearer than this the sensor would touch the coil.
            error = np.where(np.linalg.norm(points, axis=1) > 0.15, error, np.nan)
            curves.append(Curve(f"{100 * y:.0f} cm off the axis", x, error))
        plots.append(
            Plot(
                f"Error of the linear model for a step of 3 cm {name}",
                "distance along the axis",
                "m",
                "error of the predicted field",
                "%",
                tuple(curves),
            )
        )
    sphere = IronSphere.of_cylinder(0.05, 0.05)
    size = np.linalg.norm(_BENCH.field(0, 1.0, _SENSOR_M))
    aside = np.linspace(-0.6, 0.6, 121)
    curves = []
    for along in (0.1, 0.2, 0.3, 0.4, 0.5):
        iron = np.stack([np.full_like(aside, along), aside, np.zeros_like(aside)], axis=-1)
        added = sphere.disturbance(_BENCH.field(0, 1.0, iron), _SENSOR_M - iron)
        changed = 100.0 * np.linalg.norm(added, axis=1) / size
        # Iron touches neither the coil nor the sensor.
        free = np.linalg.norm(iron - _SENSOR_M, axis=1) > 0.075
        free &= np.linalg.norm(iron, axis=1) > 0.11
        curves.append(
            Curve(f"iron {100 * along:.0f} cm along the axis", aside, np.where(free, changed, np.nan))
        )
    plots.append(
        Plot(
            "Disturbance by an iron cylinder (5 cm) of the field at 30 cm along, 10 cm off the axis",
            "iron off the axis",
            "m",
            "change of the field",
            "%",
            tuple(curves),
        )
    )
    return tuple(plots)
