"""Stored frames at 25 Hz are drawn with steps between them."""

import numpy as np

from app.viewer.fluent import fluent
from estimators import rotation
from estimators.pipelines import FrameLayout, Frames


def turning(rate_hz: float, ticks: int) -> Frames:
    """A segment that turns at 2 rad/s; some quaternions have the other sign."""
    time_s = np.arange(10, 10 + ticks) / rate_hz
    half = time_s
    q = np.stack([np.cos(half), np.zeros(ticks), np.zeros(ticks), np.sin(half)], axis=-1)
    q[1::3] *= -1.0
    flags = np.zeros((ticks, 1), np.uint8)
    flags[2] = 1
    return Frames(
        layout=FrameLayout(("sternum",), ("hand_right",), ()),
        first_tick=10,
        time_step_s=1.0 / rate_hz,
        q_room_segment=q[:, None],
        point_room_m=np.repeat(time_s[:, None, None], 3, axis=2),
        angle_rad=np.zeros((ticks, 0)),
        angle_sigma_rad=np.zeros((ticks, 0)),
        scalar=np.zeros((ticks, 0)),
        segment_flags=flags,
        angle_flags=np.zeros((ticks, 0), np.uint8),
    )


def test_a_slow_session_gets_pictures_between() -> None:
    slow = turning(25.0, 40)
    found = fluent(slow)
    assert np.allclose(found.time_s, np.arange(20, 99) / 50.0)
    assert np.allclose(found.time_s[::2], slow.time_s)
    assert np.allclose(found.point_room_m[:, 0, 0], found.time_s)
    exact = np.stack(
        [np.cos(found.time_s), 0 * found.time_s, 0 * found.time_s, np.sin(found.time_s)], axis=-1
    )
    assert rotation.angle_between(found.q_room_segment[:, 0], exact).max() < 1e-4
    assert found.segment_flags[:, 0].tolist() == [0] * 4 + [1, 1] + [0] * 73


def test_a_fast_session_stays_as_it_is() -> None:
    fast = turning(100.0, 40)
    assert fluent(fast) is fast
