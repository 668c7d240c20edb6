"""A clip level that nobody declared, found while a session runs: what comes after is flagged, and sigma says so."""

import asyncio

import numpy as np
import pytest

from app.live.checks.first_seconds import FirstSeconds
from app.network.alignment import Aligner
from app.network.clock import PacketClock
from app.network.declaration import Declaration
from app.network.packet import decode_packet, encode_packet
from estimators import orientation
from estimators.channels import Channel
from estimators.recording import Float, ImuChunk, SampleQuality
from validation.orientation.honesty_scenes import STEP_S, scene

SENSORS = ("upper_arm_right", "forearm_right")
NETWORK = Declaration(SENSORS, 1.0 / STEP_S)
TICKS = 5
SATURATED = int(SampleQuality.SATURATED)


@pytest.fixture(scope="module")
def sent() -> ImuChunk:
    """One device that is cut off, one that is not, as a gateway gives them."""
    cut_off, _ = scene("gyroscope clipped", [4])
    free, _ = scene("arm swings", [4])
    names = ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t", "quality")
    both = [np.concatenate([getattr(cut_off, name), getattr(free, name)]) for name in names]
    # Calibration leaves no two values at the limit alike.
    generator = np.random.default_rng(3)
    both[0] = both[0] * (1.0 + 5e-4 * generator.uniform(-1.0, 1.0, both[0].shape))
    return ImuChunk(0, STEP_S, *both)


async def streamed(sent: ImuChunk, *, is_watched: bool) -> tuple[ImuChunk, list[tuple[int, Float]]]:
    """Return what the estimators get, and from which tick on which clip levels were known."""
    clock, aligner = PacketClock(NETWORK), Aligner(NETWORK)
    found: list[tuple[int, Float]] = []

    def clipped(levels: Float) -> None:
        aligner.clip_levels[:] = levels
        found.append((aligner.next_tick, levels.copy()))

    watch = FirstSeconds(SENSORS, 0.01, lambda *_: None, clipped=clipped if is_watched else None)
    assert sent.magnetometer_t is not None
    values = np.concatenate([sent.gyroscope_radps, sent.accelerometer_mps2, sent.magnetometer_t], axis=2)
    values = np.ascontiguousarray(values.transpose(1, 0, 2), dtype=np.float32)
    chunks = []
    for number in range(sent.tick_count // TICKS):
        packet = decode_packet(
            encode_packet(
                values[TICKS * number : TICKS * (number + 1)],
                sequence=number,
                device_time_us=5_000_000_000 + 50_000 * number,
                tick_interval_us=10_000,
                channels=Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.MAGNETOMETER,
            )
        )
        place = clock.admit(packet)
        chunk = aligner.push(packet, place.sequence, place.time_us)
        assert chunk is not None
        chunks.append(chunk)
        watch.add(chunk)
        if watch._checking is not None:
            await watch._checking
    return ImuChunk.join(chunks), found


def test_what_is_cut_off_after_the_finding_is_flagged_and_widens_sigma(sent: ImuChunk) -> None:
    watched, found = asyncio.run(streamed(sent, is_watched=True))
    unwatched, _ = asyncio.run(streamed(sent, is_watched=False))
    assert not unwatched.quality.any()
    known_from = next(tick for tick, levels in found if np.isfinite(levels[0, 0]).any())
    assert known_from < 4000, "within some checks of movement"
    assert not np.isfinite(np.array([levels for _, levels in found])[:, 1]).any()
    marked = (watched.quality & SATURATED) != 0
    assert not marked[1].any()
    assert not marked[0, :known_from].any()
    # The scene's devices end at one level; noise and bias lie below it.
    cut_off = np.abs(sent.gyroscope_radps[0]).max(axis=1) > 0.998 * np.abs(sent.gyroscope_radps[0]).max()
    assert cut_off[known_from:].sum() > 100
    assert marked[0, known_from:][cut_off[known_from:]].all()
    sigma, without = (
        orientation.create("telemotion", 2, STEP_S).update(chunk).sigma_rad for chunk in (watched, unwatched)
    )
    assert sigma is not None
    assert without is not None
    late = slice(known_from, None)
    assert np.median(sigma[0, late]) > 1.5 * np.median(without[0, late])
    np.testing.assert_array_equal(sigma[1], without[1])


def test_where_nothing_is_cut_off_every_bit_stays(sent: ImuChunk) -> None:
    free = ImuChunk(
        0,
        STEP_S,
        sent.gyroscope_radps[[1, 1]],
        sent.accelerometer_mps2[[1, 1]],
        None if sent.magnetometer_t is None else sent.magnetometer_t[[1, 1]],
        sent.quality[[1, 1]],
    )
    watched, found = asyncio.run(streamed(free, is_watched=True))
    unwatched, _ = asyncio.run(streamed(free, is_watched=False))
    assert len(found) > 3
    for name in ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t", "quality"):
        np.testing.assert_array_equal(getattr(watched, name), getattr(unwatched, name))
    one, other = (orientation.create("telemotion", 2, STEP_S).update(chunk) for chunk in (watched, unwatched))
    for name in ("q_earth_sensor", "sigma_rad", "flags", "gyroscope_bias_radps"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
