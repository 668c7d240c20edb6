"""The arm pipeline: trunk, arms, legs, and whatever else is worn."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.arm import ArmModel
from estimators.balance import MASS_POINT, MASS_SCALARS, WornMassCentre, has_mass_centre
from estimators.body import HIP_HEIGHT_PER_STATURE
from estimators.calibration import DeviceCalibration, FunctionalResult
from estimators.conventions import PLACEMENTS, Placement
from estimators.errors import SetupError, ShapeError
from estimators.leg import LegModel
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Calibration, FrameLayout, Frames, SessionSetup
from estimators.pipelines._network import NetworkPipeline
from estimators.pipelines.arm.guided import by_movement, reset_heading
from estimators.pipelines.arm.joint_headings import JointHeadings
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

_INVALID = np.uint8(OrientationFlag.INVALID)
_HEADING_KNOWN = np.uint8(0xFF & ~int(OrientationFlag.HEADING_NOT_TRUSTED))


class ArmPipeline(NetworkPipeline):
    """Sensors on trunk, arms and legs to posture, joint angles and compensation.

    Any subset with an upper arm or a forearm works, or both segments of a joint of a leg, or trunk and thighs: what
    the worn sensors cannot tell is not in the layout.
    Further sensors (head, a single one on a leg) become segments with an orientation. Until the patient was
    calibrated the segments show the sensors' own motion, flagged CONVERGING and HEADING_NOT_TRUSTED, and
    angles, points and scalars are NaN, flagged INVALID.

    In a gap that could not be bridged angles and points hold their last value, flagged INVALID; the speed of
    the hand is NaN there. Near the shoulder's singularity (arm hanging) plane of elevation and axial
    rotation are flagged SINGULAR; see `estimators.arm`.

    With sensors on the trunk (sternum or pelvis) and both thighs the centre of mass is in the layout, see
    `estimators.balance.WornMassCentre`: the point `centre_of_mass`, with the hips where all points have them, and
    `MASS_SCALARS` against the ankles and the floor, NaN while a sensor gives nothing.

    With `constrain_joint_headings` forearms and hands are turned about the vertical so that elbows and wrists
    stay possible; their angles lose HEADING_NOT_TRUSTED while the joint knows its heading.
    """

    name: ClassVar[str] = "arm"
    version: ClassVar[str] = "2"
    title: ClassVar[str] = "Arms, trunk and legs"
    axes: ClassVar[str] = (
        "room: z up, x where the patient faced in the calibration pose, y to the patient's left"
    )
    needs_pose: ClassVar[bool] = True
    takes_estimator: ClassVar[bool] = True

    @classmethod
    def used(cls, placements: Sequence[Placement], *, with_legs: bool = False) -> tuple[Placement, ...]:
        """Return the sensors that are used; legs are not left out where no arm is worn: they are what was recorded."""
        has_arm = any(name.startswith(("upper_arm", "forearm")) for name in placements)
        return super().used(placements, with_legs=with_legs or not has_arm)

    def __init__(self, setup: SessionSetup) -> None:
        unknown = [name for name in setup.placements if name not in PLACEMENTS]
        if unknown:
            raise SetupError(say("setup.unknown_placement", unknown=unknown, places=list(PLACEMENTS)))
        weighs = has_mass_centre(setup.placements)
        self._legs = LegModel(setup.placements)
        has_arm = any(name.startswith(("upper_arm", "forearm")) for name in setup.placements)
        if not (has_arm or weighs or self._legs.angles):
            raise SetupError(say("setup.arm_needs"))
        super().__init__(setup)
        # A forearm alone has no joint to measure and hangs from nothing: it stays a segment.
        moves = any(name.startswith(("upper_arm", "sternum")) for name in setup.placements)
        self._model = ArmModel(setup.body, setup.placements, self._network.time_step_s) if moves else None
        headings = JointHeadings(setup.placements, self._network.time_step_s)
        self._headings = headings if setup.constrain_joint_headings and headings.names else None
        self._previous_angle_rad = ArmModel.initial_previous()
        self._mass = WornMassCentre(setup.placements, setup.body) if weighs else None
        self._is_body = self._model is not None or weighs or bool(self._legs.angles)
        points = self._model.points if self._model else ("pelvis",) if self._is_body else ()
        angles = self._model.angles if self._model else ()
        scalars = self._model.scalars if self._model else ()
        self._layout = FrameLayout(
            segments=tuple(setup.placements),
            points=(*points, MASS_POINT) if weighs else points,
            angles=(*angles, *self._legs.angles),
            scalars=(*scalars, *MASS_SCALARS) if weighs else scalars,
        )

    def step(self, chunk: ImuChunk) -> Frames:
        """Take the next ticks of all sensors, in the order of `setup.placements`."""
        _, q_room_segment, omega, sigma, flags = self._network.step(chunk)
        if not self._network.is_calibrated:
            return self._nothing(chunk, q_room_segment, None, flags)
        if not self._is_body:
            return self._nothing(chunk, q_room_segment, None, flags)
        if self._model is None:
            frames = self._nothing(chunk, q_room_segment, sigma, flags)
            frames.point_room_m[:, 0] = (0.0, 0.0, HIP_HEIGHT_PER_STATURE * self.setup.body.stature_m)
        else:
            frames = self._with_arms(chunk, self._model, q_room_segment, omega, sigma, flags)
        assert frames.segment_sigma_rad is not None
        self._legs.write(
            frames.q_room_segment,
            frames.segment_sigma_rad,
            flags,
            frames.angle_rad,
            frames.angle_sigma_rad,
            frames.angle_flags,
        )
        if self._mass is not None:
            self._mass.write(
                frames.q_room_segment, frames.segment_sigma_rad, flags, frames.point_room_m, frames.scalar
            )
        return frames

    def _nothing(
        self, chunk: ImuChunk, q_room_segment: Float, sigma: Float | None, flags: NDArray[np.uint8]
    ) -> Frames:
        """Return frames of which only the segments are known."""
        ticks, layout = chunk.tick_count, self._layout
        return Frames(
            layout=layout,
            first_tick=chunk.first_tick,
            time_step_s=chunk.time_step_s,
            q_room_segment=q_room_segment,
            point_room_m=np.full((ticks, len(layout.points), 3), np.nan),
            angle_rad=np.full((ticks, len(layout.angles)), np.nan),
            angle_sigma_rad=np.full((ticks, len(layout.angles)), np.nan),
            scalar=np.full((ticks, len(layout.scalars)), np.nan),
            segment_flags=flags,
            angle_flags=np.full((ticks, len(layout.angles)), _INVALID),
            segment_sigma_rad=sigma,
        )

    def _with_arms(
        self,
        chunk: ImuChunk,
        model: ArmModel,
        q_room_segment: Float,
        omega: Float,
        sigma: Float,
        flags: NDArray[np.uint8],
    ) -> Frames:
        """Return frames with joint centres, angles and scalars of the arms in the first columns."""
        is_trusted: NDArray[np.bool_] | None = None
        if self._headings is not None:
            q_room_segment, omega, sigma, is_trusted = self._headings.apply(
                q_room_segment, omega, sigma, flags, chunk.first_tick
            )
        found = model.evaluate(
            q_room_segment,
            segment_flags=flags,
            angular_velocity_room_radps=omega,
            sigma_room_rad=sigma,
            previous_angle_rad=self._previous_angle_rad,
            more_points=0 if self._mass is None else 1,
            more_angles=len(self._legs.angles),
            more_scalars=0 if self._mass is None else len(MASS_SCALARS),
        )
        self._previous_angle_rad = found.previous_angle_rad
        if self._headings is not None and is_trusted is not None:
            for j, joint in enumerate(self._headings.names):
                columns = [a for a, name in enumerate(self._layout.angles) if name.startswith(f"{joint}_")]
                known = np.where(is_trusted[:, j], _HEADING_KNOWN, np.uint8(0xFF))
                found.angle_flags[:, columns] &= known[:, None]
        return Frames(
            self._layout,
            chunk.first_tick,
            chunk.time_step_s,
            q_room_segment,
            found.point_room_m,
            found.angle_rad,
            found.angle_sigma_rad,
            found.scalar,
            flags,
            found.angle_flags,
            sigma,
        )

    def calibrate(self, pose: ImuChunk, method: str = "n_pose") -> Calibration:
        """Find bias, mounting and facing from the ticks of a pose; see the contract."""
        found = super().calibrate(pose, method)
        self._begin_anew()
        return found

    def calibrate_by_movement(
        self, chunk: ImuChunk, movements: Mapping[str, tuple[int, int]], *, assisted: bool = False
    ) -> FunctionalResult:
        """Find the calibration from movements of the arms; see the contract."""
        found = by_movement(self._network, chunk, movements, assisted=assisted)
        self._begin_anew()
        return found

    def reset_heading(self, pose: ImuChunk, placements: Sequence[Placement]) -> Calibration:
        """Set the headings of some segments again from an N-pose; see the contract."""
        found = reset_heading(self._network, pose, placements)
        self._begin_anew()
        return found

    def adopt(self, found: Calibration) -> None:
        """Take over what movements left of the calibration in force; it holds from the next step."""
        self._network.adopt(found, None)
        self._begin_anew()

    def set_devices(self, devices: Mapping[Placement, DeviceCalibration]) -> None:
        """Take calibrations made in the hand; see the contract."""
        self._network.set_devices(devices)
        self._begin_anew()

    def _begin_anew(self) -> None:
        self._previous_angle_rad = ArmModel.initial_previous()
        if self._headings is not None:
            self._headings.reset()

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that the next step depends on, as arrays."""
        own = {"previous_angle_rad": self._previous_angle_rad.copy()}
        return {**super().state(), **own, **(self._headings.state() if self._headings else {})}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue exactly where the instance that gave `state` stood."""
        if "previous_angle_rad" not in state:
            raise ShapeError("this state has no previous_angle_rad; it is of another pipeline")
        super().restore(state)
        if self._headings is not None:
            self._headings.restore(state)
        self._previous_angle_rad = np.array(state["previous_angle_rad"], dtype=np.float64)
