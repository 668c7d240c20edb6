"""The frames of one arm from its joint axes, gravity at rest and the angle of the palm."""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from estimators import rotation
from estimators.calibration.movement.joint_axes import (
    AxisEstimate,
    frame_from,
    principal_axis,
    refine_two_axes,
    sigma_about_axes,
)
from estimators.conventions import Placement, Side
from estimators.recording import Float

_HANGING_RAD: Final = math.radians(4.0)
_SEATED_RAD: Final = math.radians(12.0)
_PALM_RAD: Final = math.radians(5.0)
_RAISED_RAD: Final = math.radians(15.0)
_WRIST_RAD: Final = math.radians(5.0)
_UPRIGHT: Final = 0.5
_X, _Y, _Z = np.eye(3)


@dataclass(frozen=True)
class ArmMovements:
    """One arm's samples in one common earth frame.

    Attributes
    ----------
    limb : tuple of Placement
        Upper arm, forearm and, if worn, hand.
    q : dict of (Placement, movement) to ndarray
        Orientations, shape (N, 4); of `rest` the mean, shape (4,).
    rates : dict of (Placement, movement) to ndarray, shape (N, 3)
        Earth axes, bias taken out.
    """

    side: Side
    limb: tuple[Placement, ...]
    q: dict[tuple[Placement, str], Float]
    rates: dict[tuple[Placement, str], Float]
    time_step_s: float


@dataclass(frozen=True)
class ArmFrames:
    """What was found: mountings with their uncertainty, the two axes of the elbow, and how well all agree.

    `sigma_rad` is the uncertainty about each axis of the segment; that in `segments` is the worst.
    """

    segments: dict[Placement, tuple[Float, float]]
    flexion: AxisEstimate
    pronation: AxisEstimate
    disagreement_rad: float
    sigma_rad: dict[Placement, Float]


def arm_frames(arm: ArmMovements, *, assisted: bool, rest_pronation_rad: float) -> ArmFrames:
    """Find the mountings of upper arm, forearm and hand.

    Parameters
    ----------
    arm : ArmMovements
        With `elbow_flexion`, `pronation` and `rest`; raises help.
    assisted : bool
        The rest is a seated one: gravity tells the long axes less.

    Notes
    -----
    Bending turns the forearm about -y of the humerus, on both sides; turning the palm turns it about z of
    the forearm. A turn about the elbow's flexion axis leaves that axis alone, so at any flexion y of the
    humerus is, in forearm axes, y turned back by the pronation: that ties the forearm's turn about its own
    long axis to the palm at rest.
    """
    upper, fore = arm.limb[0], arm.limb[1]
    flexion, pronation = _elbow_axes(arm)
    up = {p: rotation.rotate(rotation.conjugate(arm.q[p, "rest"]), _Z) for p in arm.limb}
    if assisted:
        flexion, long_axis = _signed_from_bent_rest(flexion, pronation, arm)
    else:
        long_axis = _proximal(pronation.axis, up[fore], arm, flexion)
    hanging = _SEATED_RAD if assisted else _HANGING_RAD
    sign = 1.0 if arm.side == "right" else -1.0
    humerus = [(-_Y, flexion.axis, flexion.sigma_rad), (_Z, up[upper], hanging)]
    for kind, segment in (("raise_forward", -_Y), ("raise_sideways", -sign * _X)):
        if (upper, kind) in arm.q:
            local = rotation.rotate(rotation.conjugate(arm.q[upper, kind]), arm.rates[upper, kind])
            axis = principal_axis(f"{kind}_{arm.side}", local, arm.time_step_s)
            # How the upper arm turns about itself while it rises is the patient's own: a weak witness.
            humerus.append((segment, axis.axis, math.hypot(axis.sigma_rad, _RAISED_RAD)))
    q_upper, sigma_upper, away_upper = frame_from(humerus)
    y_in_upper = rotation.rotate(q_upper, _Y)
    across = rotation.rotate(
        rotation.multiply(rotation.conjugate(arm.q[fore, "rest"]), arm.q[upper, "rest"]), y_in_upper
    )
    expected = rotation.rotate(rotation.about_z(-sign * rest_pronation_rad), _Y)
    forearm = [
        (_Z, long_axis, pronation.sigma_rad),
        (expected, across, math.hypot(sigma_upper, _PALM_RAD)),
    ]
    if not assisted:
        forearm.append((_Z, up[fore], _HANGING_RAD))
    q_fore, sigma_fore, away_fore = frame_from(forearm)
    segments = {upper: (q_upper, sigma_upper), fore: (q_fore, sigma_fore)}
    sigma_rad = {upper: sigma_about_axes(humerus), fore: sigma_about_axes(forearm)}
    for hand in arm.limb[2:]:
        to_hand = rotation.multiply(rotation.conjugate(arm.q[hand, "rest"]), arm.q[fore, "rest"])
        segments[hand] = (
            rotation.positive(rotation.multiply(to_hand, q_fore)),
            math.hypot(sigma_fore, _WRIST_RAD),
        )
        sigma_rad[hand] = np.hypot(sigma_rad[fore], _WRIST_RAD)
    return ArmFrames(segments, flexion, pronation, max(away_upper, away_fore), sigma_rad)


def _elbow_axes(arm: ArmMovements) -> tuple[AxisEstimate, AxisEstimate]:
    """Flexion axis in the upper arm's sensor, pronation axis in the forearm's, refined together."""
    upper, fore = arm.limb[0], arm.limb[1]
    relative = {
        kind: arm.rates[fore, kind] - arm.rates[upper, kind] for kind in ("elbow_flexion", "pronation")
    }
    axes = []
    for kind, holder in (("elbow_flexion", upper), ("pronation", fore)):
        local = rotation.rotate(rotation.conjugate(arm.q[holder, kind]), relative[kind])
        axes.append(principal_axis(f"{kind}_{arm.side}", local, arm.time_step_s))
    both = ("elbow_flexion", "pronation")
    return refine_two_axes(
        axes[0],
        axes[1],
        np.concatenate([arm.q[upper, kind] for kind in both]),
        np.concatenate([arm.q[fore, kind] for kind in both]),
        np.concatenate([relative[kind] for kind in both]),
        arm.time_step_s,
    )


def _signed_from_bent_rest(
    flexion: AxisEstimate, pronation: AxisEstimate, arm: ArmMovements
) -> tuple[AxisEstimate, Float]:
    """Give flexion axis and long axis their signs where the elbow began bent and went both ways.

    The upper arm hangs roughly, so the straighter the elbow the steeper the forearm: where it is steepest its elbow
    end is up, and bending lowers that end.
    """
    upper, fore = arm.limb[0], arm.limb[1]
    height = rotation.rotate(arm.q[fore, "elbow_flexion"], pronation.axis)[:, 2]
    sign = math.copysign(1.0, float(height[int(np.nanargmax(np.abs(height)))]))
    relative = arm.rates[fore, "elbow_flexion"] - arm.rates[upper, "elbow_flexion"]
    about = rotation.rotate(arm.q[upper, "elbow_flexion"], flexion.axis)
    bent = np.cumsum(np.nan_to_num(np.sum(relative * about, axis=1))) * arm.time_step_s
    rises = float(np.nanmean((bent - bent.mean()) * sign * (height - np.nanmean(height)))) > 0.0
    turned = replace(flexion, axis=-flexion.axis) if rises else flexion
    return turned, np.asarray(sign * pronation.axis)


def _proximal(axis: Float, up: Float, arm: ArmMovements, flexion: AxisEstimate) -> Float:
    """Give the forearm's long axis the sign that points to the elbow.

    A hanging forearm points down, so the elbow is up. From a bent rest: the more the elbow bends the less the
    axis points up.
    """
    if abs(float(axis @ up)) > _UPRIGHT:
        return axis * math.copysign(1.0, float(axis @ up))
    upper, fore = arm.limb[0], arm.limb[1]
    relative = arm.rates[fore, "elbow_flexion"] - arm.rates[upper, "elbow_flexion"]
    about = rotation.rotate(arm.q[upper, "elbow_flexion"], flexion.axis)
    bent = np.cumsum(np.sum(relative * about, axis=1)) * arm.time_step_s
    height = rotation.rotate(arm.q[fore, "elbow_flexion"], axis)[:, 2]
    covariance = float(np.mean((bent - bent.mean()) * (height - height.mean())))
    return axis * (-1.0 if covariance > 0.0 else 1.0)
