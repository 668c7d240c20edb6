"""Force, moment and power of the ankle and of the hinge between heel and forefoot: inverse dynamics."""

from dataclasses import dataclass

import numpy as np

from estimators import rotation
from estimators.kinetics._ground_reaction import GroundReaction, ShoeLoads
from estimators.kinetics._shoe_geometry import ShoeGeometry
from estimators.kinetics._shoe_pose import ShoePose
from estimators.recording import Float
from estimators.signals import derivative


@dataclass(frozen=True)
class FootSegment:
    """A foot with its shoe as one rigid body.

    Attributes
    ----------
    centre_m : tuple of 3 floats
        Centre of mass in the heel frame.
    inertia_kgm2 : tuple of 3 floats
        Principal moments about it, along the axes of the heel frame.
    """

    mass_kg: float
    centre_m: tuple[float, float, float] = (0.07, 0.0, 0.02)
    inertia_kgm2: tuple[float, float, float] = (0.0012, 0.006, 0.006)


@dataclass(frozen=True)
class JointLoad:
    """Of the proximal segment on the distal one, room axes; shape (N, 3), (N, 3), (N,).

    A moment about the left (+y) axis presses the toes down; positive power is generated.
    """

    force_n: Float
    moment_nm: Float
    power_w: Float


def ankle_load(
    reaction: GroundReaction,
    pose: ShoePose,
    shank_rate_radps: Float,
    rate_hz: float,
    geometry: ShoeGeometry | None = None,
    foot: FootSegment | None = None,
) -> JointLoad:
    """Return what the shank does to the foot at the ankle.

    Parameters
    ----------
    shank_rate_radps : ndarray, shape (N, 3)
        Room axes.
    foot : FootSegment, optional
        Its weight and inertia are taken into account; without it the foot is massless (quasi-static form).

    Notes
    -----
    Schepers (2009) equations 2.3 to 2.5 corrected. Quasi-static: `M = -(M_O - x_ankle x F)`, which keeps the
    free moment that (2.4) drops (E3). In full: plus `(x_com - x_ankle) x m s_com + R (I w' + w x I w)`, where
    (2.3) lacks the gyroscopic term (E6). Power is `M . (w_heel - w_shank)`.
    """
    shoe = geometry or ShoeGeometry()
    ankle = pose.heel_m + rotation.rotate(pose.q_room_heel, np.array(shoe.ankle_m))
    force = -reaction.force_n
    moment = -(reaction.moment_nm - np.cross(ankle, reaction.force_n))
    if foot is not None:
        rate = pose.heel_rate_radps
        turning = derivative(rate, rate_hz, window_s=0.06, axis=0)
        arm = rotation.rotate(pose.q_room_heel, np.array(foot.centre_m))
        specific = pose.specific_force_mps2 + np.cross(turning, arm) + np.cross(rate, np.cross(rate, arm))
        needed = foot.mass_kg * specific
        back = rotation.conjugate(pose.q_room_heel)
        rate_own, turning_own = rotation.rotate(back, rate), rotation.rotate(back, turning)
        inertia = np.array(foot.inertia_kgm2)
        spinning = inertia * turning_own + np.cross(rate_own, inertia * rate_own)
        force = force + needed
        moment = moment + np.cross(pose.heel_m + arm - ankle, needed)
        moment = moment + rotation.rotate(pose.q_room_heel, spinning)
    power = np.sum(moment * (pose.heel_rate_radps - shank_rate_radps), axis=1)
    return JointLoad(force, moment, power)


def hinge_load(reaction: GroundReaction, pose: ShoePose, geometry: ShoeGeometry | None = None) -> JointLoad:
    """Return what the heel segment does to the forefoot at the hinge; the forefoot is massless.

    Notes
    -----
    Schepers (2009) equation 2.6 with the forefoot's own load instead of the total centre of pressure (E7) and
    the rate of the forefoot less the heel's, so that ankle and hinge power add up (E8).
    """
    shoe = geometry or ShoeGeometry()
    hinge = pose.heel_m + rotation.rotate(pose.q_room_heel, shoe.hinge_point_m)
    moment = -(reaction.forefoot_moment_nm - np.cross(hinge, reaction.forefoot_force_n))
    power = np.sum(moment * (pose.forefoot_rate_radps - pose.heel_rate_radps), axis=1)
    return JointLoad(-reaction.forefoot_force_n, moment, power)


def environment_power(loads: ShoeLoads, pose: ShoePose, forefoot_velocity_mps: Float) -> Float:
    """Return the power that the ground gives to the shoe, shape (N,): nothing unless the ground moves or slips.

    Notes
    -----
    `P = sum of F . v + M . w` over both cells, the power transfer that Schepers (2009) section 7.4 proposes.
    """
    heel_force = rotation.rotate(pose.q_room_heel, loads.heel_force_n)
    heel_moment = rotation.rotate(pose.q_room_heel, loads.heel_moment_nm)
    forefoot_force = rotation.rotate(pose.q_room_forefoot, loads.forefoot_force_n)
    forefoot_moment = rotation.rotate(pose.q_room_forefoot, loads.forefoot_moment_nm)
    parts = heel_force * pose.velocity_mps + heel_moment * pose.heel_rate_radps
    parts = parts + forefoot_force * forefoot_velocity_mps + forefoot_moment * pose.forefoot_rate_radps
    return np.asarray(np.sum(parts, axis=1))


def work_j(power_w: Float, rate_hz: float) -> tuple[float, float]:
    """Return work generated and absorbed (negative) over a stretch of power, shape (N,), in joules."""
    finite = np.nan_to_num(power_w)
    return float(np.maximum(finite, 0.0).sum() / rate_hz), float(np.minimum(finite, 0.0).sum() / rate_hz)
