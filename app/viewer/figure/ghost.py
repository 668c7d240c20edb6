"""The template as a ghost: its mean angles on the patient's body, and which phase belongs to a moment."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from app.exercises.models import Posture
from app.viewer.pose import PoseTrack, thigh_at_rest, track_from_room
from estimators.arm import segments_from_angles
from estimators.body import BodyDimensions
from estimators.comparison import PHASES, RepetitionResult, Template, mirror_template
from estimators.conventions import Side
from estimators.leg import leg_from_angles, lower_segment
from estimators.recording import Float

Limb = Literal["arm", "leg"]
PAUSE_S: Final = 1.0
"""Rest between two showings when nobody says where a repetition begins."""

_AT_REST = {"humerus_forearm_{side}_zxy_pronation": np.pi / 2}


@dataclass(frozen=True)
class Ghost:
    """A template ready to be drawn.

    Attributes
    ----------
    track : PoseTrack
        Phases 0 to 100.
    duration_s : float
        Of one repetition of the therapist.
    limb : {"arm", "leg"}
        Which its main angle is of.
    """

    track: PoseTrack
    side: Side
    duration_s: float
    limb: Limb


def ghost_from_template(
    template: Template, body: BodyDimensions, side: Side, posture: Posture = "standing"
) -> Ghost:
    """Put a template on a body.

    Parameters
    ----------
    body : BodyDimensions
        The patient's, so that the two figures differ only in how they move.
    side : {"left", "right"}
        The patient's side; a template of the other side is mirrored.
    posture : {"standing", "seated"}
        Of the exercise: how the upper segments of a leg are where the template does not know.
    """
    if template.side != side:
        template = mirror_template(template)
    angles: dict[str, Float] = {}
    for column, name in enumerate(template.channels):
        if "." in name or not (name.endswith("_rad") or f"_{side}_" in name):
            continue
        values = template.mean[:, column]
        known = np.isfinite(values)
        if known.any():
            phase = np.arange(len(values))
            angles[name] = np.interp(phase, phase[known], values[known])
    for pattern, value in _AT_REST.items():
        angles.setdefault(pattern.format(side=side), np.full(PHASES, value))
    segments = segments_from_angles(angles, (side,))
    segments |= leg_from_angles(angles, side, thigh_at_rest(posture))
    track = track_from_room(segments, np.linspace(0.0, template.duration_s, PHASES), body, posture)
    limb: Limb = "leg" if lower_segment(template.primary_channel) else "arm"
    return Ghost(track, side, max(template.duration_s, 0.1), limb)


@dataclass(frozen=True)
class WarpedRepetition:
    """When a repetition ran and which template phase belongs to each of its own 101 phases."""

    start_s: float
    end_s: float
    template_phase: Float


@dataclass(frozen=True)
class GhostClock:
    """Which phase of the template to show at a session time.

    Attributes
    ----------
    duration_s : float
        Of the template.
    repetitions : tuple of WarpedRepetition
        In order of time; empty when nothing was compared.
    begin_s : float
        Without repetitions the template is shown over and over from here.
    """

    duration_s: float
    repetitions: tuple[WarpedRepetition, ...] = ()
    begin_s: float = 0.0
    _starts: list[float] = field(default_factory=list)

    @classmethod
    def of(cls, duration_s: float, results: Sequence[RepetitionResult], begin_s: float) -> "GhostClock":
        """Make a clock from a comparison's repetitions (none: a loop)."""
        ordered = sorted(results, key=lambda result: result.repetition.start_s)
        repetitions = tuple(
            WarpedRepetition(
                r.repetition.start_s, r.repetition.end_s, np.asarray(r.warp_template_phase, float)
            )
            for r in ordered
            if r.repetition.end_s > r.repetition.start_s and np.isfinite(r.warp_template_phase).all()
        )
        return cls(duration_s, repetitions, begin_s, [r.start_s for r in repetitions])

    def phase(self, time_s: float, warp: bool) -> float:
        """Return the template phase, 0 to 100, for a session time.

        Parameters
        ----------
        warp : bool
            True lets the ghost follow the patient's timing within each repetition; False runs it at the
            therapist's pace from the start of each. Between repetitions it waits: at the end of the last one
            for the first half of the break, then at the start of the next.
        """
        if not self.repetitions:
            elapsed = max(time_s - self.begin_s, 0.0) % (self.duration_s + PAUSE_S)
            return min(100.0 * elapsed / self.duration_s, 100.0)
        number = bisect_right(self._starts, time_s) - 1
        if number < 0:
            return 0.0
        now = self.repetitions[number]
        if warp:
            own = 100.0 * (time_s - now.start_s) / (now.end_s - now.start_s)
            phase = float(
                np.interp(own, np.linspace(0.0, 100.0, len(now.template_phase)), now.template_phase)
            )
            end_s = now.end_s
        else:
            phase = min(100.0 * (time_s - now.start_s) / self.duration_s, 100.0)
            end_s = max(now.end_s, now.start_s + self.duration_s)
        following = self.repetitions[number + 1] if number + 1 < len(self.repetitions) else None
        if following is not None and time_s > 0.5 * (end_s + following.start_s) and time_s >= end_s:
            return 0.0
        return phase
