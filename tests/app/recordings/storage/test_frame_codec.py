"""Stored frames: how far they may differ from what was live, and how much room they take."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from app.recordings.signals import bit_columns as bits
from app.recordings.signals import codecs
from app.recordings.signals.chunks import EncodedChunk, decode_frames, encode_frames
from app.recordings.signals.frame_codec import FLOAT32_FRAMES_CODEC
from estimators import pipelines
from estimators.conventions import PLACEMENTS
from estimators.pipelines import FrameLayout, Frames
from estimators.simulation import ArmScenario, Schedule, simulate_arm

LAYOUT = FrameLayout(
    segments=("upper_arm_right",),
    points=("hand_right",),
    angles=("elbow_flexion", "elbow_carrying"),
    scalars=("lean_rad", "lean_sigma_rad", "ahead_m", "ahead_sigma_m", "speed_mps", "state", "force_n"),
)
ANY = st.floats(allow_nan=True, allow_infinity=True, width=64)
USUAL = st.one_of(st.floats(-10.0, 10.0), st.just(np.nan), ANY)
SIGMA = st.one_of(st.floats(1e-5, 1.0), st.floats(0.0, 1e-3, allow_subnormal=False), st.just(np.nan))


@st.composite
def any_frames(draw: st.DrawFn) -> Frames:
    ticks = draw(st.integers(1, 12))

    def table(elements: st.SearchStrategy[float], *shape: int) -> np.ndarray:
        return draw(hnp.arrays(np.float64, (ticks, *shape), elements=elements))

    scalar = table(USUAL, len(LAYOUT.scalars))
    scalar[:, [1, 3]] = table(SIGMA, 2)
    return Frames(
        layout=LAYOUT,
        first_tick=draw(st.integers(0, 2**31)),
        time_step_s=0.01,
        q_room_segment=table(st.floats(-1.0, 1.0), 1, 4),
        point_room_m=table(USUAL, 1, 3),
        angle_rad=table(USUAL, 2),
        angle_sigma_rad=table(SIGMA, 2),
        scalar=scalar,
        segment_flags=draw(hnp.arrays(np.uint8, (ticks, 1))),
        angle_flags=draw(hnp.arrays(np.uint8, (ticks, 2))),
        segment_sigma_rad=draw(st.sampled_from([None, "some"])) and table(SIGMA, 1, 3),
        point_sigma_m=draw(st.sampled_from([None, "some"])) and table(SIGMA, 1, 3),
        slipped=draw(st.one_of(st.none(), hnp.arrays(np.bool_, (ticks, 4)))),
    )


def within(read: np.ndarray, live: np.ndarray, bound: Any) -> None:
    """NaN stays NaN, infinities stay, and finite numbers differ by no more than `bound`."""
    assert np.array_equal(np.isnan(read), np.isnan(live))
    finite = np.isfinite(live)
    assert np.array_equal(read[np.isinf(live)], live[np.isinf(live)])
    error = np.abs(read[finite] - live[finite])
    assert (error <= np.broadcast_to(bound, live.shape)[finite]).all()


def within_a_tenth_of_sigma(read: np.ndarray, live: np.ndarray, sigma: np.ndarray) -> None:
    known = np.isfinite(live) & np.isfinite(sigma)
    error, sigma = np.abs(read[known] - live[known]), sigma[known]
    assert (error[sigma > 0.0] < sigma[sigma > 0.0] / 10.0).all()
    assert (error[sigma == 0.0] == 0.0).all()


@given(any_frames())
@settings(max_examples=150, deadline=None)
def test_what_is_read_back_differs_by_less_than_matters(live: Frames) -> None:
    read = decode_frames(encode_frames(live), LAYOUT)
    assert (read.first_tick, read.time_step_s) == (live.first_tick, live.time_step_s)
    assert np.array_equal(read.segment_flags, live.segment_flags)
    assert np.array_equal(read.angle_flags, live.angle_flags)
    assert np.array_equal(read.slipped, live.slipped)
    within(read.q_room_segment, live.q_room_segment, 2.0**-16)
    within(read.point_room_m, live.point_room_m, 2.0**-15)
    within(read.angle_rad, live.angle_rad, 2.0**-15)
    within_a_tenth_of_sigma(read.angle_rad, live.angle_rad, live.angle_sigma_rad)
    for column, bound in ((0, 2.0**-15), (2, 2.0**-15), (4, 2.0**-15)):
        within(read.scalar[:, column], live.scalar[:, column], bound)
    within_a_tenth_of_sigma(read.scalar[:, 0], live.scalar[:, 0], live.scalar[:, 1])
    known = live.scalar[:, 3] > 0.0
    within_a_tenth_of_sigma(read.scalar[known, 2], live.scalar[known, 2], live.scalar[known, 3])
    for sigma, found in (
        (live.angle_sigma_rad, read.angle_sigma_rad),
        (live.scalar[:, [1, 3]], read.scalar[:, [1, 3]]),
    ):
        within(found, sigma, np.nan_to_num(sigma) / 512.0)
    for column in (5, 6):
        values = live.scalar[:, column]
        finite = values[np.isfinite(values)]
        largest = np.abs(finite).max() if finite.size else 0.0
        within(read.scalar[:, column], values, largest * 2.0**-23)
    for sigma, found in (
        (live.segment_sigma_rad, read.segment_sigma_rad),
        (live.point_sigma_m, read.point_sigma_m),
    ):
        if sigma is None or not np.isfinite(sigma).any():
            assert found is None
        else:
            assert found is not None
            within(found, sigma, np.nan_to_num(sigma) / 512.0)
    if read.point_sigma_m is not None:
        known = live.point_sigma_m > 0.0
        within_a_tenth_of_sigma(read.point_room_m[known], live.point_room_m[known], live.point_sigma_m[known])


@given(
    st.one_of(
        hnp.arrays(np.int64, st.integers(1, 60)),
        hnp.arrays(np.int64, st.integers(1, 60), elements=st.integers(-9, 9)).map(np.cumsum),
    ),
    st.integers(0, 40),
)
@settings(max_examples=150, deadline=None)
def test_any_whole_numbers_come_back_from_bits(numbers: np.ndarray, shift: int) -> None:
    numbers = numbers << shift
    words, state = np.empty(bits.room_words(len(numbers), 1), np.uint32), np.zeros(3, np.uint64)
    bits.write_column(words, state, np.stack([numbers, numbers, numbers]))
    written = words[: bits.finish(words, state)].copy()
    read, state = np.empty_like(numbers), np.zeros(3, np.uint64)
    bits.read_column(written, state, read)
    assert np.array_equal(read, numbers)
    assert bits.is_read(written, state)


def test_whole_numbers_among_measures_stay_whole() -> None:
    frames = still(20)
    frames.scalar[:, 5] = np.arange(20) % 7
    frames.scalar[3, 5] = 65_535
    assert np.array_equal(decode_frames(encode_frames(frames), LAYOUT).scalar[:, 5], frames.scalar[:, 5])


def test_parts_are_one_chunk() -> None:
    whole = still(20)
    whole.angle_rad[:] = np.random.default_rng(1).normal(size=(20, 2))
    parts = [whole.ticks(start, start + 5) for start in range(0, 20, 5)]
    joined, alone = encode_frames(*parts), encode_frames(whole)
    assert (joined.data, joined.scale, joined.ticks) == (alone.data, alone.scale, 20)


def test_a_part_without_sigmas_is_unknown_there() -> None:
    told = np.full((10, 1, 3), 0.02)
    whole = replace(still(10), segment_sigma_rad=told, point_sigma_m=told)
    first = whole.ticks(0, 5)
    second = replace(whole.ticks(5, 10), segment_sigma_rad=None, point_sigma_m=None)
    read = decode_frames(encode_frames(first, second), LAYOUT)
    for sigma in (read.segment_sigma_rad, read.point_sigma_m):
        assert sigma is not None
        np.testing.assert_allclose(sigma[:5], 0.02, rtol=2e-3)
        assert np.isnan(sigma[5:]).all()


def test_segments_alone_are_stored() -> None:
    """A forearm alone has neither points nor angles."""
    layout = FrameLayout(("forearm_right",), (), ())
    ticks, nothing = 5, np.empty((5, 0))
    q = np.tile([1.0, 0.0, 0.0, 0.0], (ticks, 1, 1))
    flags = np.zeros((ticks, 1), np.uint8)
    live = Frames(layout, 0, 0.01, q, np.empty((ticks, 0, 3)), nothing, nothing, nothing, flags, flags[:, :0])
    read = decode_frames(encode_frames(live), layout)
    assert read.point_room_m.shape == (ticks, 0, 3)
    np.testing.assert_allclose(read.q_room_segment, q, atol=1e-4)


def test_frames_stored_before_are_still_read() -> None:
    frames = still(30)
    frames.point_room_m[:] = np.random.default_rng(2).normal(size=(30, 1, 3))
    frames.angle_flags[7] = 3
    floats = np.concatenate(
        [
            frames.q_room_segment.reshape(30, -1),
            frames.point_room_m.reshape(30, -1),
            frames.angle_rad,
            frames.angle_sigma_rad,
            frames.scalar,
        ],
        axis=1,
    )
    head = codecs.encode_floats(floats.astype(np.float32))
    data = head + codecs.encode_flags(np.concatenate([frames.segment_flags, frames.angle_flags], axis=1))
    scale = {"first_tick": 40, "time_step_s": 0.01, "head_bytes": len(head), "floats": 18, "flags": 3}
    read = decode_frames(
        EncodedChunk(0, 30, FLOAT32_FRAMES_CODEC, scale, codecs.checksum(data), data), LAYOUT
    )
    assert read.first_tick == 40
    assert read.slipped is None
    np.testing.assert_allclose(read.point_room_m, frames.point_room_m, rtol=1e-7)
    assert np.array_equal(read.angle_flags, frames.angle_flags)


def test_damage_and_other_layouts_are_refused_in_words() -> None:
    chunk = encode_frames(still(30))

    def changed(data: bytes, codec: str = chunk.codec) -> EncodedChunk:
        return replace(chunk, codec=codec, data=data, crc=codecs.checksum(data))

    with pytest.raises(codecs.DamagedChunkError, match="checksum"):
        decode_frames(replace(chunk, data=chunk.data[:-4]), LAYOUT)
    for data in (chunk.data[:-4], chunk.data + b"\0\0\0\0", chunk.data + b"\0", b""):
        with pytest.raises(codecs.DamagedChunkError, match="cut off or damaged"):
            decode_frames(changed(data), LAYOUT)
    with pytest.raises(codecs.DamagedChunkError, match="newer version"):
        decode_frames(changed(chunk.data, "frames-of-tomorrow/1"), LAYOUT)
    with pytest.raises(codecs.DamagedChunkError, match="layout"):
        decode_frames(chunk, replace(LAYOUT, angles=("elbow_flexion",)))


def still(ticks: int) -> Frames:
    return Frames(
        layout=LAYOUT,
        first_tick=0,
        time_step_s=0.01,
        q_room_segment=np.full((ticks, 1, 4), 0.5),
        point_room_m=np.zeros((ticks, 1, 3)),
        angle_rad=np.zeros((ticks, 2)),
        angle_sigma_rad=np.full((ticks, 2), 0.01),
        scalar=np.zeros((ticks, len(LAYOUT.scalars))),
        segment_flags=np.zeros((ticks, 1), np.uint8),
        angle_flags=np.zeros((ticks, 2), np.uint8),
    )


@pytest.fixture(scope="module")
def lived() -> Frames:
    """What the live pipeline finds of 17 moving sensors at 100 Hz, with the noise of consumer sensors."""
    scenario = ArmScenario(
        both_arms=True,
        exercise="drinking",
        placements=PLACEMENTS,
        schedule=Schedule(n_pose_s=4.0, repetitions=None, duration_s=20.0),
        seed=7,
    )
    made = simulate_arm(scenario)
    frames, _ = pipelines.run(made.recording, made.setup, pose_s=(1.0, 3.5))
    return replace(frames, segment_sigma_rad=None).ticks(700, 1700)


def test_a_session_hour_of_frames_takes_at_most_25_megabytes(lived: Frames) -> None:
    assert lived.tick_count == 1000
    assert len(lived.layout.segments) == 17
    assert np.isfinite(lived.angle_rad).all()
    assert np.ptp(lived.angle_rad, axis=0).max() > 0.8
    size = sum(len(encode_frames(lived.ticks(i, i + 100)).data) for i in range(0, 1000, 100))
    megabytes_an_hour = size * 360 / 1e6
    assert 10.0 < megabytes_an_hour <= 25.0, megabytes_an_hour


def test_what_is_replayed_is_within_a_tenth_of_sigma_of_what_was_live(lived: Frames) -> None:
    for start in range(0, 1000, 100):
        live = lived.ticks(start, start + 100)
        read = decode_frames(encode_frames(live), live.layout)
        assert np.isfinite(live.angle_sigma_rad).all()
        assert (np.abs(read.angle_rad - live.angle_rad) < live.angle_sigma_rad / 10.0).all()
        for name in live.layout.scalars:
            sigma = name.replace("_m", "_sigma_m") if name.startswith("centre_of_mass") else ""
            if sigma in live.layout.scalars:
                column, other = live.layout.scalars.index(name), live.layout.scalars.index(sigma)
                error = np.abs(read.scalar[:, column] - live.scalar[:, column])
                assert (error < live.scalar[:, other] / 10.0).all()
