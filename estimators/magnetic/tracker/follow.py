"""Bursts of a moving sensor to fixes, one after the other, each carried by what the filter knows by then."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from estimators import rotation
from estimators.magnetic._coil import Source
from estimators.magnetic._pulses import Pulse
from estimators.magnetic.tracker import fusion_layout as at
from estimators.magnetic.tracker.burst import BurstNoise, CarriedFix, ModuleSignals, locate_moving
from estimators.magnetic.tracker.fusion import TrackerFusion, TrackerFusionChunk
from estimators.magnetic.tracker.segment_tracker import Fix, TrackerFlag, TrackerLimits, locate
from estimators.recording import Float

_SURE = 3.0
"""Sigmas of dead reckoning that must be within the distance for it to choose between a place and its mirror image."""


@dataclass(frozen=True)
class FollowedBurst:
    """One burst.

    Attributes
    ----------
    tick : int
        Middle of the pulse that was fired between the others.
    alone : Fix
        By the tracker alone, as if nothing moved.
    carried : CarriedFix or None
        With the motion in the burst; None where the burst fits no pose at all.
    used : bool
        Whether the filter was given it.
    """

    tick: int
    alone: Fix
    carried: CarriedFix | None
    used: bool


def middle_tick(burst: Sequence[Pulse]) -> int:
    """Return the middle of the pulse that was fired between the others."""
    return sorted(pulse.middle for pulse in burst)[len(burst) // 2]


def follow_bursts(
    source: Source,
    gathered: Sequence[Sequence[Pulse]],
    signals: ModuleSignals,
    chunk: TrackerFusionChunk,
    parameters: Mapping[str, Any] | None = None,
    direction: ArrayLike | None = None,
    noise: BurstNoise | None = None,
    limits: TrackerLimits | None = None,
) -> tuple[TrackerFusionChunk, list[FollowedBurst]]:
    """Solve bursts in their order and put them where the filter finds them.

    Each is carried by the pose and the velocity that the filter predicts for its tick from the bursts before: what a
    live filter would know, had it held its samples back until the end of the burst.

    Parameters
    ----------
    gathered : sequence of bursts
        As `bursts` gathers them.
    chunk : TrackerFusionChunk
        Of the whole recording, from tick 0; its fixes are overwritten.
    parameters : mapping, optional
        Of the filter.
    direction : array_like, shape (3,), optional
        From the source to the sensor, roughly, for the hemisphere of the first burst.

    Returns
    -------
    chunk : TrackerFusionChunk
    followed : list of FollowedBurst
    """
    count, own = chunk.tick_count, noise or BurstNoise()
    empty = replace(
        chunk,
        fix_position_m=np.full((count, 3), np.nan),
        fix_q_source_sensor=np.full((count, 4), np.nan),
        fix_covariance=np.full((count, 6, 6), np.nan),
        fix_velocity_mps=np.full((count, 3), np.nan),
        fix_velocity_effect=np.full((count, 6, 3), np.nan),
    )
    fusion, found, done = TrackerFusion(chunk.time_step_s, parameters), [], 0
    last: Float | None = None
    for burst in sorted(gathered, key=middle_tick):
        tick = middle_tick(burst)
        if tick < done:
            continue
        fusion.update(empty.ticks(done, tick))
        done = tick
        before = fusion.state()
        known = fusion.update(empty.ticks(tick, tick + 1))
        started = bool(known.valid[0])
        is_sure = started and (last is None or _tells_side(known.covariance[0], last))
        place = known.position_m[0] if is_sure else last
        alone = _alone(source, burst, own, limits, direction if place is None else None, place)
        carried: CarriedFix | None = None
        if not alone.flags & TrackerFlag.NO_SOLUTION:
            last = alone.position_m
            velocity, spread = np.zeros(3), None
            pose = (alone.position_m, alone.q_source_sensor)
            if started:
                velocity, spread = _velocity(fusion, chunk.q_world_source[tick])
                pose = (known.position_m[0] if is_sure else alone.position_m, known.q_source_sensor[0])
            carried = locate_moving(source, burst, signals, tick, *pose, velocity, spread, own, limits)
        fusion.restore(before)
        # Below four times the noise what comes out is not spread as its covariance says.
        used = carried is not None and carried.fix.usable and not carried.fix.flags & TrackerFlag.OUT_OF_RANGE
        if carried is not None and used:
            assert empty.fix_velocity_mps is not None
            assert empty.fix_velocity_effect is not None
            empty.fix_position_m[tick] = carried.fix.position_m
            empty.fix_q_source_sensor[tick] = carried.fix.q_source_sensor
            empty.fix_covariance[tick] = carried.fix.covariance
            empty.fix_velocity_mps[tick] = carried.velocity_mps
            empty.fix_velocity_effect[tick] = carried.velocity_effect
        found.append(FollowedBurst(tick, alone, carried, used))
    return empty, found


def _tells_side(covariance: Float, last_position_m: Float) -> bool:
    """Whether dead reckoning still tells on which side of the source the sensor is; else it is where it was."""
    sigma = np.sqrt(np.linalg.eigvalsh(covariance[:3, :3])[-1])
    return bool(_SURE * sigma < np.linalg.norm(last_position_m))


def _velocity(fusion: TrackerFusion, q_world_source: Float) -> tuple[Float, Float]:
    """Return the velocity that the filter has, and its covariance, in source axes."""
    state = fusion.state()
    back = rotation.conjugate(q_world_source)
    turn = rotation.to_matrix(back)
    rows = slice(at.E_VELOCITY, at.E_VELOCITY + 3)
    velocity = rotation.rotate(back, state["nominal"][at.VELOCITY : at.VELOCITY + 3])
    return velocity, np.asarray(turn @ state["covariance"][rows, rows] @ turn.T)


def _alone(
    source: Source,
    burst: Sequence[Pulse],
    noise: BurstNoise,
    limits: TrackerLimits | None,
    direction: ArrayLike | None,
    last: Float | None,
) -> Fix:
    """Solve a burst as if nothing moved in it."""
    shares = [1.0 / len(pulse.on) + 1.0 / len(pulse.off) for pulse in burst]
    return locate(
        source,
        [pulse.coil for pulse in burst],
        [pulse.current_a for pulse in burst],
        np.stack([pulse.field_sensor_t for pulse in burst]),
        noise.magnetometer_sigma_t * float(np.sqrt(np.mean(shares))),
        direction=direction,
        last_position_m=last,
        saturated=any(pulse.saturated for pulse in burst),
        limits=limits,
    )
