"""The relative-pose filter as it is worn: a source may be off for minutes, and is then found again."""

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from estimators.magnetic import RelativePoseFilter, Source
from estimators.magnetic import _relative_layout as at
from estimators.recording import Float

_MOVES_MPS: Final = 0.25
"""How fast one part of a body usually moves against another, one sigma. Dead reckoning that knows less is no help."""
_START_MPS: Final = 0.5
_REACH_M: Final = 0.3
"""Known less well than this a place is lost."""
_USUAL_M: Final = 0.15
"""How far a sensor is from where it usually sits on a standing person, one sigma an axis."""
_WITHIN_BURST_M: Final = 0.02
"""What a burst that fits one place may have been moved by all the same, one sigma."""
_KNOWN_RAD: Final = math.radians(20.0)


class WornPoseFilter(RelativePoseFilter):
    """`RelativePoseFilter` that finds the sensor again after dead reckoning has lost it.

    A burst takes most of a second over a network, so the filter carries its three pulses together by how the sensor
    moved meanwhile. After seconds without the source that velocity is wrong by metres a second: every burst would be
    refused, and the source never used again. Where the velocity is known less well than people's movements are, the
    sensor is first taken to have stood still within the burst. If that fits no pose, the person moves: the gyroscopes
    still know the orientation, so the filter begins where the sensor sits on somebody who stands, uncertain by what
    people differ and bend, and lets the pulses tell the rest one by one. Should that be wrong, their residuals say so.

    Parameters
    ----------
    source, time_step_s, parameters
        As for `RelativePoseFilter`.
    usual_place_m : ndarray, shape (3,), or None
        Of the sensor in source axes, roughly.
    """

    def __init__(
        self,
        source: Source,
        time_step_s: float,
        parameters: Mapping[str, Any] | None = None,
        usual_place_m: Float | None = None,
    ) -> None:
        super().__init__(source, time_step_s, parameters)
        self._usual_place_m = usual_place_m

    def handle_event(self) -> None:
        """Solve the burst that the compiled loop has just completed."""
        _, _, nominal, covariance, memory, counters, _ = self.arrays()
        sigma = np.sqrt(np.diagonal(covariance))
        is_lost = bool(counters[at.STARTED]) and sigma[at.E_VELOCITY : at.E_VELOCITY + 3].max() > _MOVES_MPS
        if is_lost:
            nominal[at.VELOCITY : at.VELOCITY + 3] = 0.0
            if self._usual_place_m is not None and sigma[at.E_POSITION : at.E_POSITION + 3].max() > _REACH_M:
                nominal[at.POSITION : at.POSITION + 3] = self._usual_place_m
            rows = memory[at.BURST : at.BURST + 3 * at.BURST_COLUMNS].reshape(3, at.BURST_COLUMNS)
            rows[:, 3:6] = nominal[at.POSITION : at.POSITION + 3]
        super().handle_event()
        if not is_lost:
            return
        if counters[at.PHASE] == at.TRACK:
            axes = np.arange(at.E_POSITION, at.E_POSITION + 3)
            covariance[axes, axes] += _WITHIN_BURST_M**2
        elif self._usual_place_m is not None and sigma[at.E_ATTITUDE : at.E_ATTITUDE + 3].max() < _KNOWN_RAD:
            self._begin_at(self._usual_place_m)

    def _begin_at(self, place_m: Float) -> None:
        """Begin at a place that is roughly known, at rest as far as is known, with the orientation as it is."""
        _, _, nominal, covariance, memory, counters, _ = self.arrays()
        spread = np.diagonal(covariance).copy()
        spread[at.E_POSITION : at.E_POSITION + 3] = _USUAL_M**2
        spread[at.E_VELOCITY : at.E_VELOCITY + 3] = _START_MPS**2
        turn = slice(at.E_ATTITUDE, at.E_ATTITUDE + 3)
        attitude = covariance[turn, turn].copy()
        covariance[:] = np.diag(spread)
        covariance[turn, turn] = attitude
        nominal[at.POSITION : at.POSITION + 3] = place_m
        memory[at.NIS_WINDOW : at.NIS_WINDOW + at.NIS_LENGTH] = 0.0
        counters[at.PHASE] = at.TRACK
        counters[at.FAILURES] = 0


__all__ = ["WornPoseFilter"]
