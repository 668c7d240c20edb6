"""What every pipeline must keep; a test class inherits it and says how to build one.

Imported by path from test modules beside it (see `conftest.py`).
"""

import json

import numpy as np
import pytest

from estimators.errors import ShapeError
from estimators.pipelines import Frames, SessionSetup, concatenate, create

ARRAYS = (
    "q_room_segment",
    "point_room_m",
    "angle_rad",
    "angle_sigma_rad",
    "scalar",
    "segment_flags",
    "angle_flags",
)


def assert_same_bits(one: Frames, two: Frames) -> None:
    assert one.layout == two.layout
    assert (one.first_tick, one.time_step_s, one.tick_count) == (
        two.first_tick,
        two.time_step_s,
        two.tick_count,
    )
    for name in ARRAYS:
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name
    for name in ("segment_sigma_rad", "point_sigma_m"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name), name)


def in_chunks(pipeline, chunk, sizes):
    parts, start = [], 0
    while start < chunk.tick_count:
        stop = min(start + next(sizes), chunk.tick_count)
        parts.append(pipeline.step(chunk.ticks(start, stop)))
        start = stop
    return parts


def forever(*sizes):
    while True:
        yield from sizes


class PipelineContract:
    """Inherit, and give fixtures `setup` (SessionSetup) and `chunk` (ImuChunk, with gaps)."""

    pose: tuple[int, int] | None = None
    """Ticks of a calibration pose in the chunk, and its method; None where there is none."""
    method = "n_pose"

    def frames(self, setup, chunk, sizes):
        pipeline = create(setup)
        if self.pose is None:
            return concatenate(in_chunks(pipeline, chunk, sizes)), pipeline
        first, stop = self.pose
        before = in_chunks(pipeline, chunk.ticks(0, stop), sizes)
        pipeline.calibrate(chunk.ticks(first, stop), self.method)
        after = in_chunks(pipeline, chunk.ticks(stop, chunk.tick_count), sizes)
        return concatenate([*before, *after]), pipeline

    def test_one_by_one_uneven_and_batch_are_equal(self, setup, chunk):
        batch, _ = self.frames(setup, chunk, forever(10**6))
        uneven, _ = self.frames(setup, chunk, forever(5, 1, 17, 64, 3))
        single, _ = self.frames(setup, chunk, forever(1))
        assert_same_bits(batch, uneven)
        assert_same_bits(batch, single)

    @pytest.mark.parametrize("share", [0.1, 0.37, 0.8])
    def test_restored_goes_on_alike(self, setup, chunk, share):
        whole, _ = self.frames(setup, chunk, forever(50))
        cut = int(share * chunk.tick_count)
        pipeline = create(setup)
        parts = []
        marks = sorted({cut, chunk.tick_count, *(() if self.pose is None else (self.pose[1],))})
        start = 0
        for mark in marks:
            parts.append(pipeline.step(chunk.ticks(start, mark)))
            if self.pose is not None and mark == self.pose[1]:
                pipeline.calibrate(chunk.ticks(*self.pose), self.method)
            if mark == cut:
                stored = {name: np.array(values) for name, values in pipeline.state().items()}
                # Nothing of the old one may be needed: a fresh one from the stored, uncalibrated setup.
                pipeline = create(SessionSetup.from_dict(json.loads(json.dumps(setup.to_dict()))))
                pipeline.restore(stored)
            start = mark
        assert_same_bits(whole, concatenate(parts))

    def test_state_is_small_arrays(self, setup, chunk):
        _, pipeline = self.frames(setup, chunk.ticks(0, min(chunk.tick_count, 1500)), forever(100))
        state = pipeline.state()
        assert all(isinstance(values, np.ndarray) and values.dtype != object for values in state.values())
        # The largest filter keeps the covariance of 30 states, 7.2 kB a sensor, beside its sums.
        assert sum(values.nbytes for values in state.values()) < 16_000 * len(setup.placements) + 5_000

    def test_state_is_a_copy(self, setup, chunk):
        pipeline = create(setup)
        pipeline.step(chunk.ticks(0, 50))
        before = {name: np.array(values) for name, values in pipeline.state().items()}
        held = pipeline.state()
        pipeline.step(chunk.ticks(50, 100))
        for name, values in held.items():
            assert values.tobytes() == before[name].tobytes(), name

    def test_shapes_follow_the_layout(self, setup, chunk):
        pipeline = create(setup)
        frames = pipeline.step(chunk.ticks(0, 30))
        layout = pipeline.layout
        assert frames.layout == layout
        assert frames.q_room_segment.shape == (30, len(layout.segments), 4)
        assert frames.point_room_m.shape == (30, len(layout.points), 3)
        assert frames.angle_rad.shape == frames.angle_sigma_rad.shape == (30, len(layout.angles))
        assert frames.angle_flags.shape == (30, len(layout.angles))
        assert frames.scalar.shape == (30, len(layout.scalars))
        assert frames.segment_flags.shape == (30, len(layout.segments))
        assert np.allclose(np.linalg.norm(frames.q_room_segment, axis=-1), 1.0)
        for sigma, names in (
            (frames.segment_sigma_rad, layout.segments),
            (frames.point_sigma_m, layout.points),
        ):
            assert sigma is None or sigma.shape == (30, len(names), 3)

    def test_a_hole_in_the_ticks_is_refused(self, setup, chunk):
        pipeline = create(setup)
        pipeline.step(chunk.ticks(0, 10))
        with pytest.raises(ShapeError, match="tick 10 is next"):
            pipeline.step(chunk.ticks(15, 20))

    def test_no_ticks_give_no_frames(self, setup, chunk):
        pipeline = create(setup)
        pipeline.step(chunk.ticks(0, 10))
        assert pipeline.step(chunk.ticks(10, 10)).tick_count == 0

    def test_setup_survives_json(self, setup, chunk):
        _, pipeline = self.frames(setup, chunk, forever(500))
        again = SessionSetup.from_dict(json.loads(json.dumps(pipeline.setup.to_dict())))
        assert again == pipeline.setup
        rerun = create(again).step(chunk)
        assert rerun.tick_count == chunk.tick_count
