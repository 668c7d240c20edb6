"""Plots of protocols: error over time and Allan deviation."""

from collections.abc import Mapping

import numpy as np

from estimators.recording import Float
from validation.protocol import Curve, Plot, thinned


def error_over_time(title: str, time_s: Float, errors_deg: Mapping[str, Float]) -> Plot:
    """Return the plot of errors in degrees over time; peaks survive the thinning.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
    errors_deg : mapping of curve name to ndarray, shape (N,)
    """
    curves = tuple(thinned(name, time_s, errors) for name, errors in errors_deg.items())
    return Plot(title, "time", "s", "orientation error", "deg", curves)


def allan_deviation(values: Float, time_step_s: float, points: int = 40) -> tuple[Float, Float]:
    """Overlapping Allan deviation of a signal at rest.

    Parameters
    ----------
    values : ndarray, shape (N,)
    points : int
        Averaging times, evenly spread on a logarithmic scale from one sample to a third of the record.

    Returns
    -------
    averaging_time_s, deviation : ndarray, shape (P,)
        P at most `points`; the deviation has the unit of `values`.

    Notes
    -----
    With theta the running sum of `values` times the step, the variance at m steps is the mean of
    `(theta[k+2m] - 2 theta[k+m] + theta[k])**2 / (2 (m T)**2)`. White noise of standard deviation s gives
    s sqrt(T / tau).
    """
    theta = np.concatenate([[0.0], np.cumsum(values)]) * time_step_s
    lengths = np.unique(np.geomspace(1, len(values) // 3, points).astype(int))
    deviations = []
    for m in lengths:
        second = theta[2 * m :] - 2.0 * theta[m:-m] + theta[: -2 * m]
        deviations.append(np.sqrt(np.mean(second**2) / 2.0) / (m * time_step_s))
    return lengths * time_step_s, np.array(deviations)


def allan_plot(title: str, unit: str, signals: Mapping[str, Float], time_step_s: float) -> Plot:
    """Return the logarithmic plot of the Allan deviations of named signals at rest, shape (N,) each."""
    curves = tuple(Curve(name, *allan_deviation(values, time_step_s)) for name, values in signals.items())
    return Plot(title, "averaging time", "s", "Allan deviation", unit, curves, logarithmic=True)
