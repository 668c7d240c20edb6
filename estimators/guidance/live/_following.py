"""A guide that is fed with the frames of a session: over gaps, from rest to rest, and on after a pause."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from estimators.comparison.channels.trajectory import leaning_channel
from estimators.guidance._contract import GuidanceChunk, GuidanceTemplate
from estimators.guidance._guide import VALID_SHARE, Guide
from estimators.guidance._orders import CuePace
from estimators.guidance._rules import CueRule, StopRule
from estimators.guidance.fitting import DEFAULT_STOPS, least_room
from estimators.guidance.live._picking import ChannelSelector
from estimators.guidance.live._settling import RestDetector
from estimators.pipelines import Frames
from estimators.recording import Float

LONGEST_GAP_S: Final = 5.0
"""Ticks that never came are fed as unknown up to here; after a longer break the patient starts from rest again."""
TRACKED_S: Final = 1.0
"""So long everything must be seen again before a pause for want of sight ends by itself."""


class GuidanceRunner:
    """Feeds a `Guide`; parameters without a word here are its own.

    Parameters
    ----------
    stops : sequence of StopRule
        Those of a session count no repetitions.
    """

    def __init__(
        self,
        ready: GuidanceTemplate,
        tick_s: float,
        *,
        valid_share: float = VALID_SHARE,
        rules: Sequence[CueRule] | None = None,
        stops: Sequence[StopRule] = DEFAULT_STOPS,
        pace: CuePace | None = None,
    ) -> None:
        self._tick_s = tick_s
        self.main = ready.main
        self._guide = Guide(ready, tick_s, valid_share=valid_share, rules=rules, stops=stops, pace=pace)
        self._picking = ChannelSelector(ready)
        self._settling = RestDetector(ready, tick_s)
        self._is_settled = False
        self._next_tick: int | None = None
        self._tracked_s = 0.0
        self._steering = [ready.channels.index(name) for name in ready.steering]
        self._unsure_rad = min((rule.limit for rule in stops if rule.kind == "unsure"), default=np.inf)
        self._seen: tuple[Float, Float] | None = None
        self._outside = {rule for rule in stops if rule.kind == "limit"}
        for rule in self._outside:
            self._guide.watch(rule, is_watched=False)
        self._set_aside: tuple[tuple[StopRule, float], ...] = ()

    @staticmethod
    def prepare() -> None:
        """Compile or load what `feed` runs, so that the first frames do not wait for it; blocks."""
        Guide.prepare()
        ChannelSelector.prepare()

    def feed(self, frames: Frames) -> tuple[GuidanceChunk, bool]:
        """Take frames; return what the guide says of the last of them, and whether it counts already."""
        values, sigma = self._picking.pick(frames)
        missing = 0 if self._next_tick is None else frames.first_tick - self._next_tick
        self._next_tick = frames.first_tick + len(values)
        if missing > 0:
            if missing * self._tick_s > LONGEST_GAP_S:
                self.leave()
            else:
                gap = np.full((missing, values.shape[1]), np.nan)
                values, sigma = np.concatenate([gap, values]), np.concatenate([gap, sigma])
        self._seen = values, sigma
        self._watch_limits(values, sigma, first=1)
        chunk = self._guide.feed(values, sigma)
        self._watch_limits(values, sigma, first=None)
        if not self._is_settled and not self._guide.is_stopped:
            rest = self._settling.add(values, sigma)
            if rest is not None:
                # What the guide took for rest before was only the beginning of the frames.
                self._guide.prompt_rest()
                again = self._guide.feed(*rest)
                self._is_settled = True
                self._set_limits_aside(*rest)
                return replace(chunk, stops=(*chunk.stops, *again.stops)), False
        return chunk, self._is_settled

    def take_set_aside(self) -> tuple[tuple[StopRule, float], ...]:
        """Return limits that the patient broke from the first frame to the first rest, with the value; once each.

        They do not stop the session: a rule that rest itself breaks would stop it again after each "Go on".
        """
        found, self._set_aside = self._set_aside, ()
        return found

    def watch_all(self) -> None:
        """Look at every limit at once, as where the patient was seen within them before a restart."""
        for rule in self._outside:
            self._guide.watch(rule, is_watched=True)
        self._outside = set()

    def _watch_limits(self, values: Float, sigma: Float, first: int | None) -> None:
        """Look at each limit from when the patient is first seen within it; `first` of the ticks are looked at."""
        for rule in tuple(self._outside):
            beyond = self._beyond(rule, values[:first], sigma[:first])
            if (beyond < 0.0).any():
                self._outside.discard(rule)
                self._guide.watch(rule, is_watched=True)

    def _set_limits_aside(self, values: Float, sigma: Float) -> None:
        broken = [
            (rule, float(np.nanmedian(values[:, self._guide.ready.channels.index(rule.channel)])))
            for rule in self._guide.stops
            if rule in self._outside and np.isfinite(self._beyond(rule, values, sigma)).any()
        ]
        # What was not measured until now is looked at as soon as it is.
        unknown = self._outside - {rule for rule, _ in broken}
        for rule in unknown:
            self._guide.watch(rule, is_watched=True)
        self._outside = set()
        self._set_aside = (*self._set_aside, *broken)

    def _beyond(self, rule: StopRule, values: Float, sigma: Float) -> Float:
        """Return how far each tick is beyond where a limit stops, rad or m; NaN where unknown."""
        column = self._guide.ready.channels.index(rule.channel)
        sign = 1.0 if rule.side == "above" else -1.0
        doubt = np.where(np.isfinite(sigma[:, column]), 2.0 * sigma[:, column], least_room(rule.channel))
        beyond: Float = sign * values[:, column] - (sign * rule.limit - doubt)
        return beyond

    def measures_main(self, frames: Frames) -> bool:
        """Say whether the sensors worn give the main channel at all, be it known at the moment or not."""
        layout = frames.layout
        places = {f"{point}.{axis}" for point in layout.points for axis in "xyz"}
        leaning = {leaning_channel(segment) for segment in layout.segments}
        return self.main in {*layout.angles, *layout.scalars, *places, *leaning}

    def is_tracked(self, chunk: GuidanceChunk) -> bool:
        """Say whether what tells the phase has been seen well for a while, up to the last frames."""
        if self._seen is None:
            return False
        values, sigma = (part[:, self._steering] for part in self._seen)
        is_known = np.isfinite(values).any(axis=1)
        is_sure = ~(np.nan_to_num(sigma) > self._unsure_rad).any(axis=1)
        if not (is_known & is_sure).all():
            self._tracked_s = 0.0
        else:
            self._tracked_s += len(values) * self._tick_s
        return self._tracked_s >= TRACKED_S

    def leave(self) -> None:
        """Begin from rest again with the next frames."""
        self._is_settled = False
        self._settling.restart()

    def hold(self) -> None:
        """Count and say nothing until `go_on`, from this tick on."""
        self._guide.stop_for_pain()

    def go_on(self) -> None:
        """Count again, from rest."""
        self._tracked_s = 0.0
        self.leave()
        self._guide.resume()
