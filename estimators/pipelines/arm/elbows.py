"""Arms without compasses: how their sensors face, given by the elbows of the recording itself."""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from estimators import rotation
from estimators.calibration import CONTRADICTED_SCORE, OrdinaryElbow, bendings, elbow_from_movement, raisings
from estimators.conventions import SIDES, Placement, Side
from estimators.errors import CalibrationError
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Frames, SessionSetup
from estimators.pipelines.arm.worn import postures_of
from estimators.recording import Float
from estimators.sentences import say

WORST_SIGMA_RAD: Final = math.radians(12.0)
"""Known worse than this, the mounting rule, which people keep to about ten degrees, stands."""
_MOST_RAD: Final = math.radians(115.0)
"""A sensor that seems turned further may be back to front, or the elbow was bent in the pose: nobody can tell."""

_RATE_HZ: Final = 10.0
"""What the elbow tells takes so many poses a second; an hour of them is small."""


def elbow_poses(frames: Frames) -> Frames:
    """Return the frames thinned to those that tell the elbows, so that thinned pieces continue each other."""
    stride = max(1, round(1.0 / (frames.time_step_s * _RATE_HZ)))
    ticks = np.arange(-frames.first_tick % stride, frames.tick_count, stride)
    arrays = (
        "q_room_segment", "point_room_m", "angle_rad", "angle_sigma_rad", "scalar", "segment_flags", "angle_flags",
    )  # fmt: skip
    return replace(
        frames,
        first_tick=-(-frames.first_tick // stride),
        time_step_s=frames.time_step_s * stride,
        segment_sigma_rad=None,
        point_sigma_m=None,
        **{name: getattr(frames, name)[ticks] for name in arrays},
    )


def elbows_to_refine(setup: SessionSetup) -> tuple[Side, ...]:
    """Return the arms whose mounting a standing pose left to the mounting rule, for want of compasses."""
    found = setup.calibration
    if found is None or "pose" not in found.method or "elbows" in found.method or found.contradicted:
        return ()
    return tuple(
        side
        for side in SIDES
        if {f"upper_arm_{side}", f"forearm_{side}"} <= found.heading_offset_rad.keys() & set(setup.placements)
    )


def refine_elbows(frames: Frames, setup: SessionSetup, pose_s: float) -> SessionSetup:
    """Correct mountings and headings of arms whose headings were assumed by the mounting rule.

    Parameters
    ----------
    frames : Frames
        Of a whole recording under `setup`.
    setup : SessionSetup
        Calibrated by a standing pose.
    pose_s : float
        Middle of that pose.

    Returns
    -------
    SessionSetup
        With a corrected calibration, whose reasons say how well it is known, and elbows and wrists bounding what
        drifts afterwards. The mounting rule stands, and the reasons say so, where the elbows were hardly bent or
        tell it worse than to `WORST_SIGMA_RAD`; the same setup where no arm has sensors on upper arm and forearm
        without a compass, or movements have shown the mounting already. An arm of which a sensor seems turned by more
        than about a quarter of a turn is named in `contradicted`.
    """
    found = setup.calibration
    if found is None:
        return setup
    mounted, offsets = dict(found.q_sensor_segment), dict(found.heading_offset_rad)
    reasons, doubted = list(found.reasons), set[Placement]()
    backward = _went_backward(frames, pose_s)
    for side in elbows_to_refine(setup):
        upper: Placement = "upper_arm_left" if side == "left" else "upper_arm_right"
        fore: Placement = "forearm_left" if side == "left" else "forearm_right"
        if side in backward:
            # Which the mounting rule, judged afterwards, does not survive.
            continue
        columns = [frames.layout.segments.index(p) for p in (upper, fore)]
        lost = (frames.segment_flags[:, columns] & int(OrientationFlag.INVALID)) != 0
        try:
            elbow = elbow_from_movement(
                side,
                frames.q_room_segment[:, columns[0]],
                frames.q_room_segment[:, columns[1]],
                frames.time_s,
                ~lost.any(axis=1),
                pose_s=pose_s,
            )
        except CalibrationError as error:
            reasons.append(error.message)
            continue
        if elbow.sigma_rad > WORST_SIGMA_RAD:
            reasons.append(say("calibration.elbow_uncertain", side=side, sigma_rad=elbow.sigma_rad))
            continue
        turned = _turn_at(elbow, pose_s)
        furthest = max(abs(elbow.upper_turn_rad), abs(turned))
        if furthest > _MOST_RAD:
            doubted |= {upper, fore, *(p for p in setup.placements if p == f"hand_{side}")}
            reasons.append(say("placement.arm_unclear", side=side, angle_rad=furthest, where=[upper, fore]))
            continue
        reasons.append(say("calibration.elbow_measured", side=side, sigma_rad=elbow.sigma_rad))
        # The hand's sensor was put on with the forearm's, and the wrist does not turn: it takes the turn along.
        hand: Placement = "hand_left" if side == "left" else "hand_right"
        for placement, turn, correction in (
            (upper, elbow.upper_turn_rad, elbow.q_upper_correction),
            (fore, turned, elbow.q_forearm_correction),
            *(((hand, turned, rotation.about_z(-turned)),) if hand in offsets else ()),
        ):
            offsets[placement] = math.remainder(offsets[placement] + turn, 2.0 * math.pi)
            mounted[placement] = _corrected(mounted[placement], correction)
    if tuple(reasons) == found.reasons:
        return setup
    contradicted = tuple(p for p in setup.placements if p in doubted)
    score = min(found.score, CONTRADICTED_SCORE) if doubted else found.score
    found = replace(found, reasons=tuple(reasons), contradicted=contradicted, score=score)
    if offsets == found.heading_offset_rad:
        return replace(setup, calibration=found)
    method = f"{found.method}, elbows"
    refined = replace(found, q_sensor_segment=mounted, heading_offset_rad=offsets, method=method)
    return replace(setup, calibration=refined, constrain_joint_headings=True)


def _went_backward(frames: Frames, pose_s: float) -> set[Side]:
    """Return the arms whose elbow bent backward or that rose behind the back: more than the elbow can correct."""
    given = postures_of(frames, pose_s)
    shown = given.names, given.q_room_segment, given.step_s
    elbows = [one for one in bendings(*shown) if one.hinge.joint == "elbow" and one.is_wrong]
    arms = [one for one in raisings(*shown) if one.is_wrong and not one.is_of_trunk]
    return {one.hinge.side for one in elbows if abs(one.mean_rad) > _MOST_RAD} | {one.side for one in arms}


def _turn_at(elbow: OrdinaryElbow, time_s: float) -> float:
    """Return the forearm's turn at the knot to which its mounting belongs."""
    return float(elbow.forearm_turn_rad[int(np.argmin(np.abs(elbow.knots_s - time_s)))])


def _corrected(q: tuple[float, float, float, float], correction: Float) -> tuple[float, float, float, float]:
    w, x, y, z = (float(v) for v in rotation.positive(rotation.multiply(np.array(q), correction)))
    return w, x, y, z
