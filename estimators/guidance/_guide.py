"""Guidance tick by tick: what a session feeds and what it reads."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from estimators.compiling import Kernel, unchecked
from estimators.errors import SetupError, ShapeError
from estimators.guidance._contract import (
    KINDS,
    CountedRepetition,
    GuidanceChunk,
    GuidanceTemplate,
)
from estimators.guidance._cue_records import CUE, STOPPED, Said, Spoken
from estimators.guidance._kernel import run
from estimators.guidance._orders import CuePace, make_orders, make_said
from estimators.guidance._parameters import GuidanceParameters
from estimators.guidance._records import (
    ASTRAY,
    OUT,
    PHASE,
    REPETITION,
    REST,
    SETTINGS,
    SIGMA,
    SIZE,
    STATE,
    Memory,
    Out,
    Work,
)
from estimators.guidance._rules import Cue, CueRule, Stopped, StopRule
from estimators.guidance._template import SLOPE_S
from estimators.guidance.fitting import DEFAULT_STOPS, PRAISE, default_rules
from estimators.kernels import filled, restored
from estimators.recording import Float

UPDATE_HZ: Final = 50.0
REST_S: Final = 1.0
VALID_SHARE: Final = 0.8
"""Share of each target that a valid repetition attains unless the therapist says otherwise."""
_PACKET_TICKS: Final = 32
"""More than a packet of a live session brings."""
_TICK: Final = (STATE.names or ()).index("tick")


def _room_for(ready: GuidanceTemplate, rest_ticks: int, window_ticks: int) -> tuple[Memory, Work]:
    """Return the memory of a guide that has seen nothing, and room for what it computes in a tick."""
    model, channels = ready.model, len(ready.channels)
    sizes, (steering, phases) = len(model.sizes), model.offset.shape
    memory = Memory(
        mass=np.zeros((sizes, phases)),
        start=np.full(channels, np.nan),
        last=np.full(channels, np.nan),
        window=np.full((window_ticks, channels), np.nan),
        rest=np.full((rest_ticks, channels), np.nan),
        size_mean=np.full(sizes, 1.0 / sizes),
        reached=np.zeros(steering),
        quotient=np.zeros(len(model.target)),
    )
    work = Work(
        sums=np.zeros((6, phases)),
        moved=np.zeros((sizes, phases)),
        pace=np.zeros((sizes, phases)),
        strange=np.zeros((sizes, phases)),
        line=np.zeros((5, phases)),
        slope=np.zeros((steering, phases)),
        y=np.zeros(channels),
        v=np.zeros(channels),
        sigma=np.zeros(channels),
        prior=np.zeros(sizes),
        sorted=np.zeros(rest_ticks),
    )
    return memory, work


class Guide:
    """Follows a patient along a template, counts, cues and stops; recorded and live give the same bits.

    The first second in which a steering channel is known is the prompted rest in the start posture.

    Parameters
    ----------
    tick_s : float
        Time between ticks, 1/200 to 1/20 s.
    valid_share : float
        q of (9).
    rules : sequence of CueRule, optional
        `default_rules` unless given.

    Raises
    ------
    SetupError
        If the tick, the share or a rule cannot be worked with.
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
        parameters: GuidanceParameters | None = None,
    ) -> None:
        if not 1.0 / 500.0 <= tick_s <= 1.0 / 20.0:
            raise SetupError(f"the time between ticks is {tick_s} s; it lies within 0.002 and 0.05")
        if not 0.0 < valid_share <= 1.2:
            raise SetupError(f"the share of a valid repetition is {valid_share}; it lies within 0 and 1.2")
        self.ready = ready
        self.tick_s = float(tick_s)
        self.rules = tuple(default_rules(ready, valid_share) if rules is None else rules)
        self.stops = tuple(stops)
        self._orders = make_orders(ready, self.tick_s, self.rules, self.stops, pace or CuePace())
        self._said = make_said(self._orders)
        stride = max(1, round(1.0 / UPDATE_HZ / tick_s))
        rest_ticks = max(2, round(REST_S / tick_s))
        self._settings = filled(
            SETTINGS,
            {
                **asdict(parameters or GuidanceParameters()),
                "tick_s": tick_s,
                "update_s": stride * tick_s,
                "stride": stride,
                "rest_ticks": rest_ticks,
                "pace": 1.0 / ready.duration_s,
                "main": ready.channels.index(ready.main),
                "valid_share": valid_share,
            },
        )
        self._state = np.zeros(1, dtype=STATE)
        self._state["tick"] = -1
        self._state["p_rest"] = 1.0
        self._state["pace"] = 1.0 / ready.duration_s
        self._memory, self._work = _room_for(ready, rest_ticks, max(3, round(SLOPE_S / tick_s) + 1))
        self._make_room(_PACKET_TICKS)
        self._run = run

    @staticmethod
    def prepare() -> None:
        """Compile or load what `feed` runs, so that the first ticks do not wait for it; blocks."""
        cast(Kernel, run).prepare()

    @property
    def start_posture(self) -> Float:
        """y0 now, shape (C,); NaN before the prompted rest is over, 0 for angles without meaning in that posture."""
        return self._memory.start.copy()

    @property
    def is_stopped(self) -> bool:
        """Whether nothing is counted or said until `resume`."""
        return bool(self._said.state["stopped"][0])

    def stop_for_pain(self) -> Stopped:
        """Stop at once: the patient pressed the button."""
        self._said.state["stopped"] = 1
        return Stopped(int(self._state["tick"][0]), "pain", None, float("nan"), float("nan"))

    def resume(self) -> None:
        """Go on by hand after a stop or a pause; a number or a time that was reached does not stop again."""
        self._said.state["stopped"] = 0
        self._said.state["wrong_in_a_row"] = 0
        self._said.stops["held_s"] = 0.0
        self._state["in_attempt"] = 0

    def watch(self, rule: StopRule, *, is_watched: bool) -> None:
        """Look at a stop rule of kind `limit` from the next tick on, or no longer."""
        self._said.stops["was_fired"][self.stops.index(rule)] = not is_watched

    def prompt_rest(self) -> None:
        """Take the start posture again from the next second on, as after a pause; an attempt under way is dropped."""
        self._state["rested"] = 0
        self._state["rest_v"], self._state["rest_v_count"] = 0.0, 0
        self._state["in_attempt"] = 0

    def feed(self, values: Float, sigma: Float) -> GuidanceChunk:
        """Take the next ticks.

        Parameters
        ----------
        values, sigma : ndarray, shape (N, C)
            As `signals` gives them: rad and m, NaN where unknown. Any number of ticks at once.

        Raises
        ------
        ShapeError
        """
        values, sigma = np.ascontiguousarray(values, float), np.ascontiguousarray(sigma, float)
        shape = (values.shape[0] if values.ndim == 2 else -1, len(self.ready.channels))
        if values.shape != shape or sigma.shape != shape:
            raise ShapeError(f"values {values.shape} and sigma {sigma.shape}; both must be (N, {shape[1]})")
        ticks = len(values)
        if ticks > self._room:
            self._make_room(ticks)
        follow, deviation, deviation_sigma = np.empty((ticks, OUT)), np.empty(shape), np.empty(shape)
        out = Out(follow, deviation, deviation_sigma, *self._ended)
        spoken = self._spoken
        is_sound = self._run(
            values,
            sigma,
            self._settings,
            self._state,
            self.ready.model,
            self._memory,
            self._work,
            out,
            self._orders,
            self._said,
            spoken,
        )
        if self._run is run:
            # The first was checked; what comes after it is of the same types.
            self._run = unchecked(run)
        if not is_sound:
            raise ShapeError("values must be finite or NaN, sigma not negative, finite or NaN")
        cues, stops = spoken.counts.tolist()
        return GuidanceChunk(
            first_tick=self._state.item()[_TICK] + 1 - ticks,
            phase=follow[:, PHASE],
            sigma=follow[:, SIGMA],
            rest=follow[:, REST],
            wrong=follow[:, ASTRAY],
            size=follow[:, SIZE],
            deviation=deviation,
            deviation_sigma=deviation_sigma,
            repetitions=_repetitions(out) if out.counts[0] else (),
            cues=tuple(self._cue(one) for one in spoken.cues[:cues]) if cues else (),
            stops=tuple(self._stopped(one) for one in spoken.stops[:stops]) if stops else (),
        )

    def _make_room(self, ticks: int) -> None:
        """Make room for what ends and is said in so many ticks; it is written over by the next ones."""
        # An attempt lasts an update at least.
        room = ticks // int(self._settings["stride"][0]) + 1
        self._ended = (
            np.zeros(room, dtype=REPETITION),
            np.zeros((room, len(self._memory.quotient))),
            np.zeros(1, dtype=np.int64),
        )
        # Of each update at most a cue and a word at the end of an attempt; one stop lasts until somebody resumes.
        self._spoken = Spoken(
            np.zeros(2 * room, dtype=CUE), np.zeros(1, dtype=STOPPED), np.zeros(2, dtype=np.int64)
        )
        self._room = ticks

    def _cue(self, one: Any) -> Cue:
        rule = self.rules[int(one["rule"])] if one["rule"] >= 0 else None
        return Cue(
            tick=int(one["tick"]),
            sentence=PRAISE if rule is None else rule.sentence,
            rule=rule,
            attempt=int(one["attempt"]),
            phase=float(one["phase"]),
            value=float(one["value"]),
            limit=float(one["limit"]),
        )

    def _stopped(self, one: Any) -> Stopped:
        rule = self.stops[int(one["rule"])]
        return Stopped(int(one["tick"]), rule.kind, rule, float(one["value"]), float(one["limit"]))

    def state(self) -> dict[str, NDArray[Any]]:
        """Return all that goes on from tick to tick, copied."""
        arrays = {**self._memory._asdict(), **{f"said_{k}": v for k, v in self._said._asdict().items()}}
        return {"state": self._state.copy(), **{k: v.copy() for k, v in arrays.items()}}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state` of a guide built alike; raises `ShapeError` for any other."""
        record = restored(state, "state", self._state)
        memory = Memory(**{k: restored(state, k, v) for k, v in self._memory._asdict().items()})
        said = Said(**{k: restored(state, f"said_{k}", v) for k, v in self._said._asdict().items()})
        self._state, self._memory, self._said = record, memory, said
        self._run = run


def _repetitions(out: Out) -> tuple[CountedRepetition, ...]:
    count = int(out.counts[0])
    return tuple(
        CountedRepetition(
            kind=KINDS[int(one["kind"])],
            attempt=int(one["attempt"]),
            start_tick=int(one["start_tick"]),
            end_tick=int(one["tick"]),
            quotient=tuple(float(q) for q in quotient),
            wrong_share=float(one["wrong"]),
            excursion=float(one["excursion"]),
            stiff_share=float(one["stiff"]),
        )
        for one, quotient in zip(out.repetitions[:count], out.quotients[:count], strict=True)
    )
