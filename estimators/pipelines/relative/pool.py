"""A pool of live relative-pose sessions: pipelines whose arrays are views of its rows, and one step for all of them."""

from collections.abc import Hashable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.kernels.slots import into_row
from estimators.orientation.vqf import VqfEstimator
from estimators.pipelines._contract import Frames, Pipeline
from estimators.pipelines.pooled import Columns, columns
from estimators.pipelines.relative.pipeline import RelativePosePipeline
from estimators.pipelines.relative.pooled_kernel import step_relative
from estimators.pipelines.relative.rows import (
    BEGIN,
    PROGRESS,
    RelativeTables,
    relative_rows,
    relative_work,
)
from estimators.recording import Float

STRETCH_TICKS: Final = 65
"""Most ticks of a stretch: those of the longest packet, and one more off the grid."""
_STORED: Final = Columns._fields.index("segment_sigma_rad")
_FILTER: Final = ("nominal", "covariance", "memory", "counters", "ring")
_OWN: Final = ("account", "last_angle", "turns")
"""Arrays of a filter and of a pipeline that are rows of the same name."""


class RelativePool:
    """Rows of relative-pose sessions with equal modules and rate; implements `Pool`.

    Each has the coils and parameters of its own. Bursts are solved in Python, over the same rows.
    """

    def __init__(
        self, like: Pipeline, channels: int, sessions: int, rows: int, carried: Mapping[str, slice]
    ) -> None:
        assert isinstance(like, RelativePosePipeline)
        level = like._level
        assert isinstance(level, VqfEstimator)
        coil = carried.get("coil_state")
        self.sessions = sessions
        self.layout = like.layout
        self._sensors = len(like._filters)
        self._time_step_s = 1.0 / like.setup.rate_hz
        self._tables = RelativeTables(
            channels,
            sum(part.stop - part.start for part in carried.values()),
            -1 if coil is None else coil.start,
            like._source_row,
            self._sensors,
            len(like._coils.coils),
            like._height_m,
            like._step_s,
            level._settings,
        )
        self.rows = relative_rows(sessions, self._sensors, like._coils.loops.shape, len(self.layout.angles))
        self._work = relative_work(self._sensors, STRETCH_TICKS)
        self._progress = np.zeros(1, dtype=PROGRESS)
        self._pipelines: dict[int, RelativePosePipeline] = {}
        self.columns = columns(rows, self.layout)
        self.errors: dict[int, tuple[int, Exception]] = {}

    @staticmethod
    def key(pipeline: Pipeline) -> Hashable | None:
        """Return what sessions of a pool have in common; None when the pipeline can be in none as it stands."""
        if not isinstance(pipeline, RelativePosePipeline):
            return None
        setup = pipeline.setup
        return setup.placements, setup.rate_hz, pipeline.layout, pipeline._coils.loops.shape

    def join(self, slot: int, pipeline: Pipeline) -> bool:
        """Let a pipeline go on over the rows of a slot; see `Pool.join`."""
        if not isinstance(pipeline, RelativePosePipeline) or not isinstance(pipeline._level, VqfEstimator):
            return False
        r, level = self.rows, pipeline._level
        # What was restored has new arrays; what is a view already stays.
        level._state = into_row(level._state, r.level[slot : slot + 1])
        level._covariance = into_row(level._covariance, r.level_covariance[slot : slot + 1])
        level._guard.memory = into_row(level._guard.memory, r.screen[slot : slot + 1])
        for name in _OWN:
            own = f"_{name}"
            setattr(pipeline, own, into_row(getattr(pipeline, own), getattr(r, name)[slot]))
        for f, one in enumerate(pipeline._filters, slot * self._sensors):
            for name in _FILTER:
                own = f"_{name}"
                setattr(one, own, into_row(getattr(one, own), getattr(r, name)[f]))
            r.settings[f] = one._settings
        r.loops[slot] = pipeline._filters[0]._loops
        self._pipelines[slot] = pipeline
        return True

    def leave(self, slot: int, pipeline: Pipeline) -> None:
        """Give a pipeline arrays of its own again."""
        self._pipelines.pop(slot, None)
        if not isinstance(pipeline, RelativePosePipeline) or not isinstance(pipeline._level, VqfEstimator):
            return
        level = pipeline._level
        level._state, level._covariance = level._state.copy(), level._covariance.copy()
        level._guard.memory = level._guard.memory.copy()
        for name in _OWN:
            setattr(pipeline, f"_{name}", getattr(pipeline, f"_{name}").copy())
        for one in pipeline._filters:
            for name in _FILTER:
                setattr(one, f"_{name}", getattr(one, f"_{name}").copy())

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
        progress = self._progress
        progress[0] = 0, BEGIN, 0
        while step_relative(
            stretches,
            count,
            signals,
            quality,
            carried,
            self.rows,
            self._tables,
            self._work,
            self.columns,
            progress,
        ):
            number, sensor, _ = progress[0].item()
            slot = int(stretches["slot"][number])
            try:
                self._pipelines[slot]._filters[sensor].handle_event()
            except Exception as error:
                self.errors[slot] = number, error
                # Nothing more is taken of it in this step; its neighbours go on.
                self.rows.is_stopped[slot] = 1
                progress[0] = number + 1, BEGIN, 0
        for slot in self.errors:
            self.rows.is_stopped[slot] = 0

    def stepped(self, pipeline: Pipeline, next_tick: int) -> None:
        """Carry on what a pipeline knows beside its rows; see `Pool.stepped`."""
        assert isinstance(pipeline, RelativePosePipeline)
        pipeline._next_tick = pipeline._level._guard.next_tick = next_tick  # type: ignore[attr-defined]

    def frames(self, first_tick: int, start: int, stop: int) -> Frames:
        """Return a copy of some rows as frames; see `Pool.frames`."""
        # As stored live: angles carry their own sigma.
        found: Any = [values[start:stop].copy() for values in self.columns[:_STORED]]
        return Frames(self.layout, first_tick, self._time_step_s, *found)
