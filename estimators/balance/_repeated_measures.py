"""Whether people differ between conditions, as the analysis of variance for repeated measures has it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import scipy

from estimators.errors import ShapeError
from estimators.recording import Float


@dataclass(frozen=True)
class Effect:
    """One effect of a repeated-measures design.

    Attributes
    ----------
    name : str
        A factor, or factors joined by ` x ` for their interaction.
    degrees : (float, float)
        Of effect and error.
    p : float
        Probability of an F at least as large if there were no effect.
    epsilon, p_corrected : float
        Greenhouse and Geisser's departure from sphericity (1 for two levels) and p with it.
    partial_eta_squared : float
        Part of the effect's and error's variation that is the effect's.
    """

    name: str
    f: float
    degrees: tuple[float, float]
    p: float
    epsilon: float
    p_corrected: float
    partial_eta_squared: float

    def is_significant(self, alpha: float = 0.05) -> bool:
        """Return whether the corrected p is below alpha."""
        return self.p_corrected < alpha


def repeated_measures(values: Float, factors: Sequence[str]) -> tuple[Effect, ...]:
    """Analyse a within-subject design, for instance eyes open and closed by two systems.

    Parameters
    ----------
    values : ndarray, shape (subjects, levels of factor 1, levels of factor 2, ...)
        One number a person and combination of conditions: the mean of that person's strides. Every person
        must have been in every condition.
    factors : sequence of str
        Names, in the order of the axes.

    Returns
    -------
    tuple of Effect
        Each factor, then interactions of two, and so on.

    Raises
    ------
    ShapeError
        For missing values, fewer than two people, a factor with one level, or names that do not fit.

    Notes
    -----
    The repeated-measures general linear model that Schepers (2009) section 3.2.4 uses. For every effect the
    values are projected on orthonormal contrasts of its cells; the sum of squares of their means over people
    against their spread is F. With two levels a factor it is the square of a paired t, `F(1, n - 1) = t^2`.
    """
    table = np.asarray(values, dtype=np.float64)
    if table.ndim != len(factors) + 1 or len(set(factors)) != len(factors) or not factors:
        raise ShapeError(f"values of shape {table.shape} need {table.ndim - 1} different factor names")
    subjects, levels = table.shape[0], table.shape[1:]
    if subjects < 2 or min(levels) < 2:
        raise ShapeError(f"shape {table.shape}: at least two people, and two levels of every factor")
    if not np.isfinite(table).all():
        raise ShapeError("a value is missing: leave out people who were not in every condition")
    flat = table.reshape(subjects, -1)
    return tuple(
        _effect(flat, levels, chosen, " x ".join(factors[i] for i in chosen))
        for size in range(1, len(factors) + 1)
        for chosen in combinations(range(len(factors)), size)
    )


def _effect(flat: Float, levels: tuple[int, ...], chosen: tuple[int, ...], name: str) -> Effect:
    contrast = np.ones((1, 1))
    for number, count in enumerate(levels):
        mean = np.full((count, 1), 1.0 / np.sqrt(count))
        # Columns that sum to zero for a factor of the effect, the mean of the others.
        contrast = np.kron(contrast, scipy.linalg.null_space(mean.T) if number in chosen else mean)
    scores = flat @ contrast
    subjects, width = scores.shape
    of_effect = subjects * float(np.sum(scores.mean(axis=0) ** 2))
    spread = scores - scores.mean(axis=0)
    of_error = float(np.sum(spread**2))
    degrees = (float(width), float(width * (subjects - 1)))
    with np.errstate(divide="ignore", invalid="ignore"):
        f = float(np.divide(of_effect / degrees[0], of_error / degrees[1]))
    covariance = spread.T @ spread
    squares = float(np.sum(covariance**2))
    epsilon = float(np.trace(covariance)) ** 2 / (width * squares) if squares > 0.0 else 1.0
    total = of_effect + of_error
    return Effect(
        name,
        f,
        degrees,
        float(scipy.stats.f.sf(f, *degrees)),
        epsilon,
        float(scipy.stats.f.sf(f, epsilon * degrees[0], epsilon * degrees[1])),
        of_effect / total if total > 0.0 else 0.0,
    )
