"""Which triad of a sensor is mistaken, and how: the explanation that gravity and field like best, where one fits."""

from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.plausibility.contradiction import Evidence
from estimators.calibration.plausibility.mistakes import IS_PROPER, SCALES, SIGNED_PERMUTATIONS
from estimators.calibration.plausibility.pace import FITS
from estimators.recording import Float

Triad = Literal["gyroscope", "accelerometer", "magnetometer"]

DOUBT: Final = 4.0
"""Logarithm of the likelihood that another reading must gain before it is named. Of 460 sound recordings, as files and
at each look of a live session, one gained 2.6 and all others less than 1.3."""
CERTAIN: Final = 4.5
"""The same before a recording is refused."""
_LEAST_PACED: Final = 4
"""Windows that a pace must explain to be named: a jump, as where samples are lost without a word, is in three."""
_NEAR: Final = 1.5
"""Explanations this close to the best cannot be distinguished from it."""
_COMPLEX: Final = 1.5
"""What an unlikely mistake must gain more before it is believed: axes and unit at once, or the unit of a gyroscope that
reads what limbs do."""
_ORDINARY_RADPS: Final = (0.5, 35.0)
_POSSIBLE_RADPS: Final = (0.05, 100.0)


@dataclass(frozen=True)
class Explanation:
    """A mistake that would bring gravity, field and gyroscope together.

    Attributes
    ----------
    triads : frozenset of str
        Those of which each alone would explain it; more than one when the movement does not decide.
    scale : float
        What the gyroscope must be multiplied with; 1 when its unit is right.
    mapping : ndarray, shape (3, 3)
        Signed permutation that takes the axes of the first of `triads` to the right ones; the identity when only the
        unit is wrong. Of an accelerometer or magnetometer only up to the sign of all three axes.
    gain : float
        Logarithm of the likelihood against the readings as they are.
    gain_over_silence : float
        The same against a gyroscope that says nothing.
    fits : bool
        With it the readings fit as those of a sound recording do. Otherwise something is wrong that is none of this.
    is_clear : bool
        No other mapping of these triads, and no other unit, does about as well.
    pace : float
        How many times as far as the gyroscope says the sensor turns, where a wrong clock or range explains it; else 1.
    is_brief : bool
        A pace would explain it, of too few windows to be named: a jump looks the same.
    """

    triads: frozenset[Triad]
    scale: float
    mapping: Float
    gain: float
    gain_over_silence: float
    fits: bool
    is_clear: bool
    pace: float = 1.0
    is_brief: bool = False

    @property
    def is_certain(self) -> bool:
        """Whether it may refuse a recording: both the readings as they are and none at all do far worse."""
        return self.fits and self.gain >= CERTAIN and self.gain_over_silence >= DOUBT

    @property
    def is_amiss(self) -> bool:
        """Whether something is certainly wrong that this does not explain: as they are the readings fit far worse."""
        least = DOUBT if self.is_brief else CERTAIN
        return not self.fits and self.gain >= least and self.gain_over_silence >= least


def explain(evidence: Evidence, fastest_radps: float) -> Explanation | None:
    """Return what is wrong with a sensor, or None when the readings as they are do about as well.

    Parameters
    ----------
    fastest_radps : float
        What the gyroscope reads in the fastest moments: a limb turns neither at a thousandth of a radian a second nor
        at a hundred, and where the readings are ordinary a wrong unit is unlikely.

    Notes
    -----
    A mapping Q of the gyroscope shows as its inverse in force and field alike. A mapping P of the accelerometer shows
    as det(P) P in the force alone, which is a rotation whatever P is: a reflected gyroscope differs from it, a
    rotated one only by the field. So with the magnetometer.
    """
    force, field = evidence.costs()
    plain = float(force[0, 0] + field[0, 0])
    costs, is_ordinary = _costs(force, field, fastest_radps)
    best = min(float(cost.min()) for cost in costs.values())
    if (at_pace := _pace(evidence, plain, best)) is not None:
        is_enough = evidence.windows.max() >= _LEAST_PACED
        return at_pace if is_enough else replace(at_pace, fits=False, pace=1.0, is_brief=True)
    if plain - best < DOUBT:
        return None
    near: dict[Triad, tuple[int, int]] = {}
    for triad, cost in costs.items():
        # Only a unit is wrong: that is a matter of the gyroscope, however it was found.
        if float(cost.min()) <= best + _NEAR:
            scale, mapping = divmod(int(np.argmin(cost)), cost.shape[1])
            if mapping != 0 or triad == "gyroscope":
                near[triad] = (scale, mapping)
    units = costs["gyroscope"][:, 0]
    if float(units.min()) <= best + (0.0 if is_ordinary else _NEAR):
        near = {"gyroscope": (int(np.argmin(units)), 0)}
    triads: list[Triad] = sorted(near, key=lambda triad: float(costs[triad].min()))
    scale, mapping = near[triads[0]]
    return Explanation(
        frozenset(triads),
        SCALES[scale],
        SIGNED_PERMUTATIONS[mapping] if triads[0] == "gyroscope" else SIGNED_PERMUTATIONS[mapping].T,
        plain - best,
        float(evidence.unturned.sum()) - best,
        _fits((force, field), evidence.windows, triads[0], scale, mapping),
        _is_clear(costs, near, best),
    )


def _pace(evidence: Evidence, plain: float, others: float) -> Explanation | None:
    """Return a wrong clock or range where it explains the readings; it stands before axes that do as well."""
    if evidence.pace == 1.0:
        return None
    both = evidence.paced_costs()
    paced = both[int(np.argmin(both.sum(axis=1)))]
    cost = float(paced.sum()) + _COMPLEX
    fits = bool((paced <= FITS * evidence.windows).all())
    if not fits or plain - cost < DOUBT or cost > others + _NEAR:
        return None
    # On a quick clock little time passes, in which everything fits: in the time as it is said, to turn so far must do
    # better than not to turn.
    if float(evidence.unturned.sum() - both[1].sum()) < DOUBT:
        return None
    return Explanation(
        frozenset({"gyroscope"}),
        1.0,
        np.eye(3),
        plain - cost,
        float(evidence.unturned.sum()) - cost,
        fits,
        others > cost + _NEAR,
        evidence.pace,
    )


def _costs(force: Float, field: Float, fastest_radps: float) -> tuple[dict[Triad, Float], bool]:
    """Return what each mistake leaves, shape (11, 48) a triad, and whether the gyroscope reads what limbs do."""
    turned = fastest_radps * np.array(SCALES)
    is_ordinary = _ORDINARY_RADPS[0] < fastest_radps < _ORDINARY_RADPS[1]
    unit = np.where(
        (turned > _POSSIBLE_RADPS[0]) & (turned < _POSSIBLE_RADPS[1]), _COMPLEX * is_ordinary, np.inf
    )
    unit[0] = 0.0
    prior = np.tile(unit[:, None], (1, len(SIGNED_PERMUTATIONS)))
    prior[1:, 1:] += _COMPLEX
    proper = np.where(IS_PROPER, 0.0, np.inf)
    return {
        "gyroscope": force + field + prior,
        "accelerometer": force + field[:, :1] + prior + proper,
        "magnetometer": force[:, :1] + field + prior + proper,
    }, is_ordinary


def _fits(
    left: tuple[Float, Float], windows: NDArray[np.int64], triad: Triad, scale: int, mapping: int
) -> bool:
    """Tell whether a mistake leaves as little as the right reading of a sound recording does."""
    of_force = left[0][scale, 0 if triad == "magnetometer" else mapping]
    of_field = left[1][scale, 0 if triad == "accelerometer" else mapping]
    return bool((np.array([of_force, of_field]) <= FITS * windows).all())


def _is_clear(costs: dict[Triad, Float], near: dict[Triad, tuple[int, int]], best: float) -> bool:
    """Tell whether all else of the same triads does clearly worse."""
    others = {triad: costs[triad].copy() for triad in near}
    for triad, (scale, mapping) in near.items():
        others[triad][scale, mapping] = np.inf
        # As they are, the readings do worse already.
        others[triad][0, 0] = np.inf
    return min(float(cost.min()) for cost in others.values()) > best + _NEAR
