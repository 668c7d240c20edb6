"""Live frames of which every fourth is stored: the same numbers, no gap lost, none twice after a restart."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import Engine

from app.database.unit_of_work import read_only, unit_of_work
from app.recordings.analysis.kinds import kinds
from app.recordings.models import Result
from app.recordings.points import ticks_between
from app.recordings.signals.chunks import decode_frames, encode_frames
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import read_frames, stored_step_s
from estimators.pipelines import FrameLayout, Frames, SessionSetup

LAYOUT = FrameLayout(("forearm_right",), ("hand_right",), ("flexion",), ("lean_rad",))
STRIDE = 4


def frames(first_tick: int, ticks: int) -> Frames:
    """Frames whose numbers are those of their ticks; every seventh tick is flagged."""
    tick = np.arange(first_tick, first_tick + ticks)
    angle = np.sin(tick / 50.0)[:, None]
    return Frames(
        layout=LAYOUT,
        first_tick=first_tick,
        time_step_s=0.01,
        q_room_segment=np.tile([1.0, 0.0, 0.0, 0.0], (ticks, 1, 1)),
        point_room_m=np.tile(angle[:, :, None], (1, 1, 3)),
        angle_rad=angle,
        angle_sigma_rad=np.full((ticks, 1), 0.02),
        scalar=angle.copy(),
        segment_flags=np.where(tick % 7 == 0, 2, 0).astype(np.uint8)[:, None],
        angle_flags=np.zeros((ticks, 1), np.uint8),
    )


@given(
    first_tick=st.integers(0, 50),
    lengths=st.lists(st.integers(1, 9), min_size=1, max_size=30),
    stride=st.integers(2, 6),
)
@settings(max_examples=60, deadline=None)
def test_what_is_kept_is_what_was_found(first_tick: int, lengths: list[int], stride: int) -> None:
    starts = np.cumsum([first_tick, *lengths])
    parts = [frames(int(start), int(stop - start)) for start, stop in pairwise(starts)]
    kept = np.flatnonzero(np.arange(first_tick, starts[-1]) % stride == 0)
    if not len(kept):
        return
    chunk = encode_frames(*parts, stride=stride)
    read, whole = decode_frames(chunk, LAYOUT), frames(first_tick, int(starts[-1] - first_tick))
    assert np.allclose(read.time_s, whole.time_s[kept])
    assert np.allclose(read.angle_rad, whole.angle_rad[kept], atol=2.0**-14)
    assert np.allclose(read.point_room_m, whole.point_room_m[kept], atol=2.0**-14)
    assert chunk.scale["first_tick"] + chunk.ticks == first_tick + kept[-1] + stride
    # A flag of a tick that is left out stands at a tick that is kept.
    assert bool(read.segment_flags.any()) == bool(whole.segment_flags.any())
    ends = [*kept[1:], len(whole.segment_flags)]
    joined = [
        whole.segment_flags[0 if not k else at : end].max()
        for k, (at, end) in enumerate(zip(kept, ends, strict=True))
    ]
    assert read.segment_flags[:, 0].tolist() == joined


def live_result(engine: Engine, session_id: str, stride: int) -> str:
    with unit_of_work(engine) as session:
        result = Result(
            session_id=session_id,
            kind="live",
            pipeline="arm",
            pipeline_version="1",
            orientation="vqf",
            orientation_version="1",
            setup=SessionSetup("arm", ("forearm_right",), 100.0).to_dict(),
            layout={
                name: list(getattr(LAYOUT, name)) for name in ("segments", "points", "angles", "scalars")
            },
            stride=stride,
        )
        session.add(result)
        session.flush()
        return result.id


def store(engine: Engine, session_id: str, result_id: str, first_tick: int, lengths: list[int]) -> None:
    """Append parts as a live session does, with a commit wherever it falls; then the service ends."""
    writer = GroupCommitWriter(engine)
    writer.open_session(session_id)
    for number, ticks in enumerate(lengths):
        assert writer.append_frames(session_id, result_id, frames(first_tick, ticks))
        first_tick += ticks
        if number % 3 == 2:
            writer._commit(writer._take_due(everything=True))
    writer._commit(writer._take_due(everything=True))


@pytest.mark.parametrize("stride", [1, STRIDE])
def test_commits_at_any_tick_leave_neither_gaps_nor_doubles(
    engine: Engine, new_session: Callable[..., str], stride: int
) -> None:
    session_id = new_session()
    result_id = live_result(engine, session_id, stride)
    lengths = [5, 5, 3, 1, 2, 7, 1, 1, 1, 5, 4, 6, 2, 3]
    store(engine, session_id, result_id, 0, lengths)
    with read_only(engine) as session:
        found = read_frames(session, result_id)
        result = session.get_one(Result, result_id)
        assert stored_step_s(result) == pytest.approx(stride * 0.01)
        assert ticks_between(session, result, stored_step_s(result), None, None) == (0, found.tick_count)
        part = read_frames(session, result_id, 0.1, 0.3)
    whole = frames(0, sum(lengths))
    assert np.allclose(found.time_s, whole.time_s[::stride])
    assert np.allclose(found.angle_rad, whole.angle_rad[::stride], atol=2.0**-14)
    inside = whole.time_s[::stride]
    assert np.allclose(part.time_s, inside[(inside > 0.0999) & (inside < 0.2999)])


def test_a_finer_chunk_of_a_thin_result_is_read_on_its_grid(
    engine: Engine, new_session: Callable[..., str]
) -> None:
    session_id = new_session()
    result_id = live_result(engine, session_id, 1)
    store(engine, session_id, result_id, 0, [50, 30])
    with unit_of_work(engine) as session:
        session.get_one(Result, result_id).stride = STRIDE
    store(engine, session_id, result_id, 80, [40])
    with read_only(engine) as session:
        found = read_frames(session, result_id)
    assert np.allclose(found.time_s, np.arange(0, 120, STRIDE) * 0.01)
    assert np.isfinite(found.angle_rad).all()


def test_only_kinds_that_are_analysed_whole_are_thinned() -> None:
    """A contact of a foot, a pulse of a source and sway are of single ticks: those are kept."""
    strides = {name: kind.live_stride(100.0) for name, kind in kinds().items()}
    assert strides.pop("arm") == strides.pop("orientation") == STRIDE
    assert set(strides.values()) == {1}
    arm: Any = kinds()["arm"]
    assert [arm.live_stride(rate) for rate in (10.0, 25.0, 60.0, 99.0, 200.0)] == [1, 1, 2, 3, 8]


def test_a_thin_chunk_without_a_tick_of_the_grid_is_none(
    engine: Engine, new_session: Callable[..., str]
) -> None:
    session_id = new_session()
    result_id = live_result(engine, session_id, STRIDE)
    store(engine, session_id, result_id, 5, [2])
    with read_only(engine) as session:
        assert read_frames(session, result_id).tick_count == 0


def test_unknown_sigma_of_some_parts_stays_with_its_ticks() -> None:
    known, unknown = frames(0, 6), frames(6, 6)
    known = replace(known, segment_sigma_rad=np.full((6, 1, 3), 0.01))
    read = decode_frames(encode_frames(known, unknown, stride=STRIDE), LAYOUT)
    assert read.segment_sigma_rad is not None
    assert np.isfinite(read.segment_sigma_rad).all(axis=(1, 2)).tolist() == [True, True, False]


def test_frames_of_a_body_without_points_and_angles_are_thinned() -> None:
    layout = FrameLayout(("foot_right",), (), (), ("lean_rad",))
    whole = frames(3, 20)
    bare = replace(
        whole,
        layout=layout,
        point_room_m=np.empty((20, 0, 3)),
        angle_rad=np.empty((20, 0)),
        angle_sigma_rad=np.empty((20, 0)),
        angle_flags=np.empty((20, 0), np.uint8),
    )
    read = decode_frames(encode_frames(bare.ticks(0, 6), bare.ticks(6, 20), stride=STRIDE), layout)
    assert np.allclose(read.scalar, whole.scalar[1::STRIDE], atol=2.0**-12)
