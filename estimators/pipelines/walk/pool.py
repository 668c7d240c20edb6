"""A pool of live walks: pipelines whose arrays are views of its rows, and one step for all of them."""

from collections.abc import Hashable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.gait.foot.live.ordinary_kernel import release, take
from estimators.gait.foot.live.rows import FootRows, foot_rows
from estimators.kernels.by_address import address_of
from estimators.kernels.slots import into_row, sparse_zeros
from estimators.pipelines._contract import Frames, Pipeline
from estimators.pipelines.pooled import Columns, chunk_of, columns
from estimators.pipelines.walk.pipeline import GaitPipeline
from estimators.pipelines.walk.pooled_kernel import step_walks
from estimators.pipelines.walk.released_kernel import write_feet, write_shoes
from estimators.pipelines.walk.rows import WalkRows, WalkTables, walk_rows, walk_work
from estimators.recording import Float

_FORCE, _MOMENT = "force_n", "moment_nm"
_FILLED: Final = ("q_room_segment", "point_room_m", "scalar", "segment_flags", "segment_sigma_rad")


class WalkPool:
    """Rows of walks with equal sensors, rate and filter parameters; implements `Pool`.

    What is unusual for a session (a sample that is missing, bridged, cut off or wild, and the moments after it, the
    start, devices calibrated in the hand) is taken by its `GaitPipeline.step`, over the same rows.
    """

    def __init__(
        self, like: Pipeline, channels: int, sessions: int, rows: int, carried: Mapping[str, slice]
    ) -> None:
        assert isinstance(like, GaitPipeline)
        tracker, steps = like._tracker, like._steps
        self.sessions = sessions
        self.layout = like.layout
        self.columns: Columns = columns(rows, self.layout)
        self.errors: dict[int, tuple[int, Exception]] = {}
        self.ordinary = self.general = 0
        """Stretches taken by compiled code, and by a session's own step, since the pool was made."""
        self._sensors, self._feet = len(like._rows), len(like._feet)
        self._channels, self._worn = channels, len(like.setup.placements)
        self._time_step_s = 1.0 / like.setup.rate_hz
        self._carried = dict(carried)
        has_cells = _FORCE in carried and _MOMENT in carried
        self._tables = WalkTables(
            channels,
            self._worn,
            np.array(like._rows, dtype=np.int64),
            tracker._guard.time_step_s,
            *tracker.constants,
            like._heels,
            steps.right,
            like._offset_m,
            int(like._shoes is not None),
            sum(part.stop - part.start for part in carried.values()),
            carried[_FORCE].start if has_cells else -1,
            carried[_MOMENT].start if has_cells else -1,
            address_of(take),
            address_of(release),
            address_of(write_feet if like._shoes is None else write_shoes),
        )
        self._foot_rows = foot_rows(sessions * self._sensors, self._tables.sizes, sparse_zeros)
        self.rows: WalkRows = walk_rows(sessions, self._sensors, self._feet, tracker.delay_ticks, like.width)
        self._work = walk_work(self._sensors)
        self._point_sigma_m: Float = sparse_zeros((rows, len(self.layout.points), 3))
        self._pipelines: dict[int, GaitPipeline] = {}

    @staticmethod
    def key(pipeline: Pipeline) -> Hashable | None:
        """Return what sessions of a pool have in common; None when the pipeline can be in none as it stands."""
        if not isinstance(pipeline, GaitPipeline):
            return None
        setup = pipeline.setup
        parameters = tuple(sorted(pipeline._tracker.parameters.items()))
        return setup.placements, setup.rate_hz, parameters, pipeline.layout

    def join(self, slot: int, pipeline: Pipeline) -> bool:
        """Let a pipeline go on over the rows of a slot; see `Pool.join`."""
        if not isinstance(pipeline, GaitPipeline):
            return False
        r, tracker, steps = self.rows, pipeline._tracker, pipeline._steps
        a, b = slot * self._sensors, (slot + 1) * self._sensors
        tracker.go_on_over(FootRows._make(values[a:b] for values in self._foot_rows))
        tracker._guard.memory = into_row(tracker._guard.memory, r.screen[a:b])
        r.steps_settings[slot] = steps.settings
        steps._feet = into_row(steps._feet, r.steps[slot * self._feet : (slot + 1) * self._feet])
        pipeline._waiting.go_on_in(r.waiting[slot], r.waiting_place[slot])
        if pipeline._shoes is not None:
            pipeline._shoes.go_on_over(r, slot)
        self._pipelines[slot] = pipeline
        self._note(slot, pipeline)
        return True

    def _note(self, slot: int, pipeline: GaitPipeline) -> None:
        """Say to compiled code where a pipeline stands."""
        tracker, x = pipeline._tracker, self.rows.session[slot]
        x["next_tick"] = tracker._guard.next_tick
        x["is_general"] = bool(pipeline.setup.devices) or not tracker.is_plain

    def leave(self, slot: int, pipeline: Pipeline) -> None:
        """Give a pipeline arrays of its own again."""
        self._pipelines.pop(slot, None)
        if not isinstance(pipeline, GaitPipeline):
            return
        tracker, steps = pipeline._tracker, pipeline._steps
        tracker.own()
        tracker._guard.memory = tracker._guard.memory.copy()
        steps._feet = steps._feet.copy()
        pipeline._waiting.own()
        if pipeline._shoes is not None:
            pipeline._shoes.own()

    def step(
        self,
        stretches: NDArray[np.void],
        count: int,
        signals: Float,
        quality: NDArray[np.uint8],
        carried: Float,
    ) -> None:
        """Take the next ticks of some sessions; see `Pool.step`."""
        self.errors = {}
        is_taken = np.zeros(count, dtype=np.uint8)
        left = count
        while left:
            before = left
            left = step_walks(stretches, count, is_taken, signals, quality, carried, *self.arrays)
            self.ordinary += before - left
            if left:
                left -= self._take_first(stretches, is_taken, signals, quality, carried)

    def _take_first(
        self,
        stretches: NDArray[np.void],
        is_taken: NDArray[np.uint8],
        signals: Float,
        quality: NDArray[np.uint8],
        carried: Float,
    ) -> int:
        """Let every session that has stretches left take the first of them itself; returns how many are done."""
        seen, done = set(self.errors), 0
        for number in np.flatnonzero(is_taken == 0).tolist():
            slot, first_tick, ticks, signals_at, quality_at, tick_at = stretches[number].tolist()
            if slot in seen:
                if slot in self.errors:
                    is_taken[number] = 1
                    done += 1
                continue
            seen.add(slot)
            is_taken[number] = 1
            done += 1
            pipeline = self._pipelines[slot]
            # Compiled code may have gone on since it last took a step.
            pipeline._tracker._guard.next_tick = int(self.rows.session[slot]["next_tick"])
            chunk = chunk_of(
                (first_tick, self._time_step_s, ticks, self._worn, self._channels),
                signals[signals_at:],
                quality[quality_at:],
                carried[self._tables.width * quality_at :],
                self._carried,
            )
            try:
                frames = pipeline.step(chunk)
            except Exception as error:
                self.errors[slot] = number, error
                continue
            self.general += 1
            self._note(slot, pipeline)
            for name in _FILLED:
                getattr(self.columns, name)[tick_at : tick_at + ticks] = getattr(frames, name)
            self._point_sigma_m[tick_at : tick_at + ticks] = frames.point_sigma_m
        return done

    @property
    def arrays(self) -> tuple[Any, ...]:
        """What `step_walks` works on, behind what it is given."""
        return self._foot_rows, self.rows, self._tables, self._work, self.columns, self._point_sigma_m

    def stepped(self, pipeline: Pipeline, next_tick: int) -> None:
        """Carry on what a pipeline knows beside its rows; see `Pool.stepped`."""
        pipeline._tracker._guard.next_tick = next_tick  # type: ignore[attr-defined]

    def frames(self, first_tick: int, start: int, stop: int) -> Frames:
        """Return a copy of some rows as frames; see `Pool.frames`."""
        found: Any = [values[start:stop].copy() for values in (*self.columns, self._point_sigma_m)]
        return Frames(self.layout, first_tick, self._time_step_s, *found)
