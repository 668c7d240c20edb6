"""The balance pipeline: sensors on pelvis and chest of a person who stands."""

from collections.abc import Sequence
from typing import ClassVar, Final

import numpy as np

from estimators.balance.sway import posture
from estimators.body import ANKLE_HEIGHT_PER_STATURE, HIP_HEIGHT_PER_STATURE, BodyDimensions
from estimators.conventions import Placement
from estimators.errors import SetupError
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import FrameLayout, Frames, SessionSetup
from estimators.pipelines._network import NetworkPipeline
from estimators.recording import ImuChunk
from estimators.sentences import say

TRUNK: Final[tuple[Placement, ...]] = ("pelvis", "sternum")
"""Where sensors of a balance test are worn, the one that its measures are of first."""
_ABOVE_HIPS_M: Final = 0.05
"""Of a sensor on the pelvis."""
_UP_THE_TRUNK: Final = 0.8
"""Share of the trunk's length at which a sensor on the chest sits."""
_COLUMNS: Final = (
    "lean_forward_rad",
    "lean_left_rad",
    "acceleration_forward_mps2",
    "acceleration_left_mps2",
    "rate_forward_radps",
    "rate_left_radps",
)
_HIDDEN: Final = np.uint8(OrientationFlag.INVALID)


def hips_above_ankles_m(body: BodyDimensions) -> float:
    """Return how high the hips are above the ankles, on which a stiff body sways, m."""
    return (HIP_HEIGHT_PER_STATURE - ANKLE_HEIGHT_PER_STATURE) * body.stature_m


def trunk_above_ankles_m(placement: Placement, body: BodyDimensions) -> float:
    """Return how high a sensor on the trunk sits above the ankles in upright stance, m."""
    up = _ABOVE_HIPS_M if placement == "pelvis" else _UP_THE_TRUNK * body.trunk_m
    return hips_above_ankles_m(body) + up


def sway_columns(placement: Placement) -> tuple[str, ...]:
    """Return the scalars of one sensor: lean, acceleration and rate, each forward and left."""
    return tuple(f"{placement}_{column}" for column in _COLUMNS)


class BalancePipeline(NetworkPipeline):
    """Sensors on pelvis, chest or both to lean and horizontal acceleration of each.

    Scalars of each sensor, forward and left: `PLACE_lean_forward_rad` and `PLACE_acceleration_forward_mps2`
    (`estimators.balance.sway.posture`), and `PLACE_rate_forward_radps`, how fast it leans as the gyroscope reads it,
    which leaves the constant error to whoever sees a whole trial. NaN before the N-pose was evaluated and while the
    sensor gives nothing. The point `pelvis` is where the hips are in upright stance: feet do not move.
    """

    name: ClassVar[str] = "balance"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Balance"
    axes: ClassVar[str] = (
        "room: z up, x where the patient faced in the calibration pose, y to the patient's left"
    )
    needs_pose: ClassVar[bool] = True
    takes_estimator: ClassVar[bool] = True

    @classmethod
    def used(cls, placements: Sequence[Placement], *, with_legs: bool = False) -> tuple[Placement, ...]:
        """Return the sensors on the trunk."""
        return tuple(name for name in TRUNK if name in placements)

    def __init__(self, setup: SessionSetup) -> None:
        if not setup.placements or not set(setup.placements) <= set(TRUNK):
            raise SetupError(say("setup.balance_needs"))
        super().__init__(setup)
        self._layout = FrameLayout(
            segments=tuple(setup.placements),
            points=("pelvis",),
            angles=(),
            scalars=tuple(column for name in setup.placements for column in sway_columns(name)),
        )

    def step(self, chunk: ImuChunk) -> Frames:
        """Take the next ticks of all sensors, in the order of `setup.placements`."""
        _, q_room_segment, _, sigma, flags = self._network.step(chunk)
        ticks, sensors = chunk.tick_count, chunk.sensor_count
        scalar = np.full((ticks, sensors, len(_COLUMNS)), np.nan)
        point = np.full((ticks, 1, 3), np.nan)
        if self._network.is_calibrated:
            rate, force = (one.swapaxes(0, 1) for one in self._network.in_segments(chunk))
            leaning = np.stack([rate[..., 1], -rate[..., 0]], axis=-1)
            scalar = np.concatenate([*posture(q_room_segment, force), leaning], axis=-1)
            scalar[(flags & _HIDDEN) != 0] = np.nan
            point[:, 0] = (0.0, 0.0, HIP_HEIGHT_PER_STATURE * self.setup.body.stature_m)
        return Frames(
            layout=self._layout,
            first_tick=chunk.first_tick,
            time_step_s=chunk.time_step_s,
            q_room_segment=q_room_segment,
            point_room_m=point,
            angle_rad=np.empty((ticks, 0)),
            angle_sigma_rad=np.empty((ticks, 0)),
            scalar=scalar.reshape(ticks, -1),
            segment_flags=flags,
            angle_flags=np.empty((ticks, 0), dtype=np.uint8),
            segment_sigma_rad=sigma,
        )
