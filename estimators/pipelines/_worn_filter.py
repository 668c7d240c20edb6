"""The relative-pose filter as it is worn: a source may be off for minutes, and is then found again."""

import math
from typing import Final

import numpy as np

from estimators.magnetic import RelativePoseFilter
from estimators.magnetic.relative import layout as at
from estimators.recording import Float

_MOVES_MPS: Final = 0.25
"""How fast one part of a body usually moves against another, one sigma. Dead reckoning that knows less is no help."""
_START_MPS: Final = 0.5
_USUAL_M: Final = 0.15
"""How far a sensor is from where it usually sits on a standing person, one sigma an axis."""
_KNOWN_RAD: Final = math.radians(20.0)
_PULSES_S: Final = 10.0
"""For so long single pulses are to find the place, before another burst is asked for because it is known badly."""


class WornPoseFilter(RelativePoseFilter):
    """`RelativePoseFilter` that finds the sensor again after dead reckoning has lost it.

    A burst takes most of a second over a network. After seconds without the source the velocity is known less well
    than people's movements are, and the burst is taken as one of a sensor that stood still. If that fits no pose, the
    person moves: the gyroscopes still know the orientation, so the filter begins where the sensor sits on somebody
    who stands, uncertain by what people differ and bend, and lets the pulses tell the rest one by one. Should that be
    wrong, their residuals say so.
    """

    def handle_event(self) -> None:
        """Solve the burst that the compiled loop has just completed."""
        _, _, _, covariance, _, counters, _ = self.arrays()
        sigma = np.sqrt(np.diagonal(covariance))
        is_lost = bool(counters[at.STARTED]) and sigma[at.E_VELOCITY : at.E_VELOCITY + 3].max() > _MOVES_MPS
        super().handle_event()
        if not is_lost or counters[at.PHASE] == at.TRACK or self._usual_place_m is None:
            return
        if sigma[at.E_ATTITUDE : at.E_ATTITUDE + 3].max() < _KNOWN_RAD:
            self._begin_at(self._usual_place_m)

    def _begin_at(self, place_m: Float) -> None:
        """Begin at a place that is roughly known, at rest as far as is known, with the orientation as it is."""
        _, settings, nominal, covariance, memory, counters, _ = self.arrays()
        spread = np.diagonal(covariance).copy()
        spread[at.E_POSITION : at.E_POSITION + 3] = _USUAL_M**2
        spread[at.E_VELOCITY : at.E_VELOCITY + 3] = _START_MPS**2
        turn = slice(at.E_ATTITUDE, at.E_ATTITUDE + 3)
        attitude = covariance[turn, turn].copy()
        covariance[:] = np.diag(spread)
        covariance[turn, turn] = attitude
        nominal[at.POSITION : at.POSITION + 3] = place_m
        nominal[at.VELOCITY : at.VELOCITY + 3] = 0.0
        memory[at.NIS_WINDOW : at.NIS_WINDOW + at.NIS_LENGTH] = 0.0
        memory[at.SENSITIVITY : at.SENSITIVITY + at.ERRORS] = 0.0
        counters[at.PHASE] = at.TRACK
        counters[at.RESTARTED] += 1
        counters[at.WIDE_AFTER] = counters[at.TICK] + round(_PULSES_S / settings[at.TIME_STEP])
