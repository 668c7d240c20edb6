"""The cost of a long gap: the foot's place and heading, from then on, until something tells them again."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.gait.foot import layout as at
from estimators.gait.foot.filter import level, start_covariance
from estimators.gait.foot.parameters import FootParameters
from estimators.gait.foot.trajectory import FootFlag
from estimators.recording import Float

Bool = NDArray[np.bool_]

YAW_UNKNOWN_RAD: Final = math.pi / math.sqrt(3.0)
"""Standard deviation of an angle of which nothing is known."""
# Ticks missing in a row; variances lost along the floor, up and about the vertical; where this stretch began (3);
# whether a place was ever lost; mean of the way misplaced so far (2), and in the axes of this stretch (2).
RUN, ALONG2, UP2, YAW2, ORIGIN, LOST, MEAN, TURNED, MEMORY = 0, 1, 2, 3, 4, 7, 8, 10, 12


def lost_yaw_rad(gap_s: float, parameters: FootParameters) -> float:
    """Return how far a foot may have turned in a gap, one sigma."""
    return min(parameters.lost_turn_radps * gap_s, YAW_UNKNOWN_RAD)


def long_gap_ticks(rate_hz: float, parameters: FootParameters) -> int:
    """Return the number of missing ticks from which on a place is lost."""
    return max(1, round(parameters.lost_after_s * rate_hz))


def gap_lengths(is_missing: Bool, run: int) -> NDArray[np.int64]:
    """Return for every tick how many in a row were missing up to it, or just before it where it is not missing.

    Parameters
    ----------
    is_missing : ndarray of bool, shape (K,)
    run : int
        Missing in a row just before the first.
    """
    ticks = np.arange(len(is_missing))
    last = np.maximum.accumulate(np.where(is_missing, -1, ticks))
    found = np.where(last >= 0, ticks - last, ticks + 1 + run)
    before = np.concatenate([[run], found[:-1]])
    return np.asarray(np.where(is_missing, found, before))


def begin_anew(
    x: Float,
    p: Float,
    memory: Float,
    force_mps2: Float,
    statistic: float,
    gap_s: float,
    parameters: FootParameters,
) -> bool:
    """Let the filter start again at the first sample after a long gap; `x`, `p` and `memory` are changed.

    Place and heading go on where they were lost: the new stretch is a frame of its own, certain in itself, and what
    it is worth against the one before is `LostPlace`'s to say. Tilt and velocity are those of a start; biases and
    the contact point, with what is known of them, are retained, and so is the earth's field where it was seen: then the
    heading is searched, not set.

    Parameters
    ----------
    x, p, memory : ndarray
        Of the filter at the last tick of the gap.
    force_mps2 : ndarray, shape (3,)
        Mean specific force of the first moment after the gap.
    statistic : float
        Mean of T there.

    Returns
    -------
    bool
        Whether the field will tell the heading.
    """
    q = x[at.Q : at.Q + 4]
    upright = level(rotation.rotate(q, force_mps2))
    x[at.Q : at.Q + 4] = rotation.normalize(rotation.multiply(upright, q))
    x[at.V : at.V + 3] = 0.0
    retained = slice(at.E_GYROSCOPE_BIAS, at.ERRORS)
    known = p[retained, retained].copy()
    p[:] = start_covariance(statistic, parameters)
    p[retained, retained] = known
    has_field = bool(memory[at.FIELD_KNOWN])
    if has_field:
        p[at.E_Q + 2, at.E_Q + 2] = lost_yaw_rad(gap_s, parameters) ** 2
    memory[at.STARTED] = memory[at.FLOOR_KNOWN] = memory[at.SINCE] = memory[at.BELIEVED_SIGMA] = 0.0
    return has_field


class LostPlace:
    """Says of released samples how much less is known of place and heading than the filter, which begins again, knows.

    A gap of T seconds may hide a way of `lost_speed_mps` T in any direction, a climb of `lost_climb_mps` T and a turn
    of `lost_turn_radps` T, one sigma each. A turn by a normal angle of deviation s misplaces a way d walked since by
    2 d**2 (1 - exp(-s**2 / 2)), in the mean of the square; the ways of several stretches err together, as a turn turns
    all that come after it. Horizontally sigma is the mean of both axes.

    Parameters
    ----------
    memory : ndarray, shape (MEMORY,), optional
        Carried on in place.
    """

    def __init__(self, rate_hz: float, parameters: FootParameters, memory: Float | None = None) -> None:
        self._step_s, self._parameters = 1.0 / rate_hz, parameters
        self._least = long_gap_ticks(rate_hz, parameters)
        self.memory = np.zeros(MEMORY) if memory is None else memory

    @property
    def is_lost(self) -> bool:
        """Whether a place was ever lost, or a gap runs."""
        return bool(self.memory[LOST] or self.memory[RUN])

    def widen(
        self, position_m: Float, sigma: Float, is_missing: Bool, first: int, with_field: dict[int, bool]
    ) -> NDArray[np.uint8]:
        """Add to the sigmas of released samples and return what is to be flagged.

        Parameters
        ----------
        position_m : ndarray, shape (K, 3)
        sigma : ndarray, shape (K, 6)
            Of position and attitude; changed.
        is_missing : ndarray of bool, shape (K,)
        first : int
            Tick of the first.
        with_field : dict
            By the tick of a new stretch: whether the field tells its heading.
        """
        m, flags = self.memory, np.zeros(len(is_missing), dtype=np.uint8)
        if not (self.is_lost or is_missing.any()):
            return flags
        gap = gap_lengths(is_missing, int(m[RUN]))
        begins = set(np.flatnonzero(~is_missing & (gap >= self._least)).tolist())
        starts = sorted({0} | begins)
        for start, stop in zip(starts, [*starts[1:], len(gap)], strict=True):
            if start in begins:
                self._begin(position_m[start], float(gap[start]) * self._step_s, with_field[first + start])
                flags[start] |= np.uint8(FootFlag.BEGINS_ANEW)
            piece = slice(start, stop)
            in_gap = np.where(is_missing[piece], gap[piece], 0) * self._step_s
            spread = sigma[piece]
            bent = 0.5 * self._bent2(position_m[piece, :2]) if m[LOST] else 0.0
            spread[:, :2] = np.sqrt(
                spread[:, :2] ** 2
                + (m[ALONG2] + bent + (self._parameters.lost_speed_mps * in_gap) ** 2)[:, None]
            )
            spread[:, 2] = np.sqrt(
                spread[:, 2] ** 2 + m[UP2] + (self._parameters.lost_climb_mps * in_gap) ** 2
            )
            yaw = np.minimum(self._parameters.lost_turn_radps * in_gap, YAW_UNKNOWN_RAD)
            grown = np.sqrt(spread[:, at.SIGMA_HEADING] ** 2 + m[YAW2] + yaw**2)
            spread[:, at.SIGMA_HEADING] = np.minimum(grown, YAW_UNKNOWN_RAD)
            is_lost = (m[LOST] > 0.0) | (in_gap >= self._least * self._step_s)
            flags[piece] |= is_lost * np.uint8(FootFlag.PLACE_LOST)
        m[RUN] = gap[-1] if is_missing[-1] else 0.0
        return flags

    def _bent2(self, place_m: Float) -> Float:
        """Return by how much this stretch adds to the square of what is misplaced, shape (K,).

        With u = exp(i angle), ways d as complex numbers and A = sum of (u_j - 1) d_j over the stretches before:
        E|A + (u - 1) d|^2 - E|A|^2 = 2 |d|^2 (1 - E u) + 2 Re((E[A u*] - E[A]) d*).
        """
        m = self.memory
        way = place_m - m[ORIGIN : ORIGIN + 2]
        turned = m[TURNED : TURNED + 2] - m[MEAN : MEAN + 2]
        # In plain steps, which compiled code repeats with the same bits.
        together = way[:, 0] * turned[0] + way[:, 1] * turned[1]
        return np.asarray(-2.0 * math.expm1(-0.5 * m[YAW2]) * np.sum(way**2, axis=1) + 2.0 * together)

    def _begin(self, position_m: Float, gap_s: float, has_field: bool) -> None:
        m, c = self.memory, self._parameters
        if m[LOST]:
            way, less = position_m[:2] - m[ORIGIN : ORIGIN + 2], -math.expm1(-0.5 * m[YAW2])
            m[ALONG2] += 0.5 * float(self._bent2(position_m[None, :2])[0])
            m[MEAN : MEAN + 2] -= less * way
            m[TURNED : TURNED + 2] += less * way
        yaw2 = lost_yaw_rad(gap_s, c) ** 2
        m[TURNED : TURNED + 2] *= math.exp(-0.5 * yaw2)
        if has_field:
            m[TURNED : TURNED + 2] = m[MEAN : MEAN + 2]
        m[ALONG2] += (c.lost_speed_mps * gap_s) ** 2
        m[UP2] += (c.lost_climb_mps * gap_s) ** 2
        m[YAW2] = 0.0 if has_field else m[YAW2] + yaw2
        m[ORIGIN : ORIGIN + 3] = position_m
        m[LOST] = 1.0
