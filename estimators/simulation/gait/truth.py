"""The truth of a simulated walk, on the ticks of its recording."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import SIDES, Side
from estimators.simulation.arm.kinematics import Path, Turn, cross
from estimators.simulation.gait.body import UPWARD_MPS2, BodyMotion
from estimators.simulation.gait.course import Stance
from estimators.simulation.gait.foot import Foot, FootMotion

Float = NDArray[np.float64]
Motion = TypeVar("Motion", Turn, Path)


@dataclass(frozen=True)
class FootTruth:
    """One foot of a simulated walk; K ticks, M stances; all vectors in the room frame.

    Attributes
    ----------
    heel, forefoot, shank : Turn
        `q_room_segment` with rate and acceleration in room axes.
    is_contact, is_flat : ndarray of bool, shape (K,)
    force_n, cop_m, free_moment_nm : ndarray, shape (K, 3), (K, 3), (K,)
        Of the ground on the foot; NaN for `cop_m` without load. The free moment is about the vertical.
    loads : dict of str to (force, moment), each shape (K, 3)
        `heel` and `forefoot` sensor, in segment axes about the sensor centre.
    ankle_force_n, ankle_moment_nm, ankle_power_w : ndarray
        Of the shank on the foot, with the foot's own mass; power is moment times rate of the heel segment
        less the shank.
    hinge_moment_nm, hinge_power_w : ndarray
        Of the heel segment on the forefoot; rate of the forefoot less the heel segment.
    land_s, flat_from_s, heel_off_s, tipping_s, lift_s : ndarray, shape (M,)
        Events of each stance; infinite where the recording begins or ends in it.
    foothold_m, foothold_yaw_rad : ndarray, shape (M, 3) and (M,)
        Point of the floor below the heel sensor while flat, and where the foot points.
    """

    heel: Turn
    forefoot: Turn
    shank: Turn
    heel_sensor: Path
    forefoot_sensor: Path
    hinge: Path
    ankle: Path
    is_contact: NDArray[np.bool_]
    is_flat: NDArray[np.bool_]
    force_n: Float
    cop_m: Float
    free_moment_nm: Float
    loads: dict[str, tuple[Float, Float]]
    ankle_force_n: Float
    ankle_moment_nm: Float
    ankle_power_w: Float
    hinge_moment_nm: Float
    hinge_power_w: Float
    land_s: Float
    flat_from_s: Float
    heel_off_s: Float
    tipping_s: Float
    lift_s: Float
    foothold_m: Float
    foothold_yaw_rad: Float


@dataclass(frozen=True)
class GaitTruth:
    """A simulated walk.

    Attributes
    ----------
    time_s : ndarray, shape (K,)
    com : Path
        Centre of mass of the whole body.
    momentum_rate_nm : ndarray, shape (K, 3)
        Rate of the angular momentum about the centre of mass.
    pelvis, trunk : (Turn, Path)
        Orientation and centre.
    step_side, step_land_s
        Side and time of every landing, in order.
    active_s : ndarray, shape (B, 2)
        From first lift to last landing of each bout.
    q_segment_sensor : dict of str to ndarray, shape (4,)
    """

    time_s: Float
    feet: dict[Side, FootTruth]
    com: Path
    momentum_rate_nm: Float
    mass_kg: float
    pelvis: tuple[Turn, Path]
    trunk: tuple[Turn, Path]
    step_side: tuple[Side, ...]
    step_land_s: Float
    active_s: Float
    q_segment_sensor: dict[str, Float]
    facing_rad: float

    @property
    def force_n(self) -> Float:
        """Total ground reaction, shape (K, 3)."""
        return np.asarray(self.feet["left"].force_n + self.feet["right"].force_n)

    @property
    def cop_m(self) -> Float:
        """Centre of pressure of both feet, weighted by their vertical forces, shape (K, 3)."""
        weights = {side: self.feet[side].force_n[:, 2:] for side in SIDES}
        total = weights["left"] + weights["right"]
        parts = [weights[side] * np.nan_to_num(self.feet[side].cop_m) for side in SIDES]
        return np.asarray((parts[0] + parts[1]) / total)


def foot_truth(
    model: Foot,
    stances: list[Stance],
    foot: FootMotion,
    body: BodyMotion,
    side: Side,
    loads: dict[str, tuple[Float, Float]],
    thin: slice,
) -> FootTruth:
    """Gather the truth of one foot on every `thin`-th instant, with the joint loads of a foot with mass."""
    heel_part, forefoot_part = body.parts[f"heel_{side}"], body.parts[f"forefoot_{side}"]
    force, cop = body.force_n[side], body.cop_m[side]
    joint_force = -force
    ankle_moment = -cross(cop - foot.ankle.position, force)
    ankle_moment[:, 2] -= body.free_moment_nm[side]
    for part in (heel_part, forefoot_part):
        needed = part.mass_kg * (part.centre.acceleration + UPWARD_MPS2)
        joint_force = joint_force + needed
        ankle_moment += cross(part.centre.position - foot.ankle.position, needed) + part.momentum_rate_nm
    share = np.clip(foot.cop_local_m / 0.16, 0.0, 1.0)
    forefoot_force = share[:, None] * force
    along = np.column_stack((np.cos(foot.sole_yaw_rad), np.sin(foot.sole_yaw_rad), np.zeros(share.size)))
    point = cop + (0.17 * (1.0 - share))[:, None] * along
    hinge_moment = -cross(point - foot.hinge.position, forefoot_force)
    hinge_moment[:, 2] -= share * body.free_moment_nm[side]
    needed = forefoot_part.mass_kg * (forefoot_part.centre.acceleration + UPWARD_MPS2)
    hinge_moment += cross(forefoot_part.centre.position - foot.hinge.position, needed)
    hinge_moment += forefoot_part.momentum_rate_nm
    ankle_power = np.sum(ankle_moment * (foot.heel.rate - foot.shank.rate), axis=1)
    hinge_power = np.sum(hinge_moment * (foot.forefoot.rate - foot.heel.rate), axis=1)
    loaded = force[:, 2] > 1e-6
    flats = [model.flat_s(stance) for stance in stances]
    return FootTruth(
        heel=thinned(foot.heel, thin),
        forefoot=thinned(foot.forefoot, thin),
        shank=thinned(foot.shank, thin),
        heel_sensor=thinned(foot.heel_sensor, thin),
        forefoot_sensor=thinned(foot.forefoot_sensor, thin),
        hinge=thinned(foot.hinge, thin),
        ankle=thinned(foot.ankle, thin),
        is_contact=foot.contact[thin],
        is_flat=foot.flat[thin],
        force_n=force[thin],
        cop_m=np.where(loaded[:, None], cop, np.nan)[thin],
        free_moment_nm=body.free_moment_nm[side][thin],
        loads={name: (load[0][thin], load[1][thin]) for name, load in loads.items()},
        ankle_force_n=joint_force[thin],
        ankle_moment_nm=ankle_moment[thin],
        ankle_power_w=ankle_power[thin],
        hinge_moment_nm=hinge_moment[thin],
        hinge_power_w=hinge_power[thin],
        land_s=np.array([stance.land_s for stance in stances]),
        flat_from_s=np.array([flat[0] for flat in flats]),
        heel_off_s=np.array([flat[1] for flat in flats]),
        tipping_s=np.array([model.tipping_s(stance) for stance in stances]),
        lift_s=np.array([stance.lift_s for stance in stances]),
        foothold_m=np.array([stance.position_m for stance in stances]),
        foothold_yaw_rad=np.array([stance.yaw_rad for stance in stances]),
    )


def thinned(motion: Motion, thin: slice) -> Motion:
    """Return a path or turn on every `thin`-th instant."""
    return type(motion)(*(part[thin] for part in motion))
