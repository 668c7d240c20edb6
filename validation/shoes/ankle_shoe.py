"""One instrumented shoe against the truth of a simulated walk, stride by stride."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, Side
from estimators.kinetics import GroundReaction, ShoeKinetics, ShoeParameters, analyse_shoe
from estimators.kinetics.published import REPORT_SHARE
from estimators.recording import Float, Recording
from estimators.simulation import FootTruth, GaitTruth, gait_preset, simulate_gait


@dataclass(frozen=True)
class ScoredShoe:
    """Estimates of one shoe, turned and shifted onto the truth at every stance, as a floor frame renewed there is.

    Attributes
    ----------
    stance : ndarray of bool, shape (N,)
        Loaded with more than a tenth of body weight, first and last stance left out.
    stride : ndarray of bool, shape (N,)
        Between those stances' first rest and last rest.
    turn : ndarray, shape (N, 4)
        Onto the truth.
    heel_m, cop_m : ndarray, shape (N, 3)
    """

    shoe: ShoeKinetics
    truth: FootTruth
    stance: NDArray[np.bool_]
    stride: NDArray[np.bool_]
    weight_n: float
    turn: Float
    heel_m: Float
    cop_m: Float

    def turned(self, vectors: Float) -> Float:
        """Return vectors of the estimate, shape (N, 3), in the room of the truth."""
        return rotation.rotate(self.turn, vectors)


def simulated_ankle(seed: int, errors: str) -> tuple[Recording, GaitTruth]:
    """Return one trial of the ankle protocol."""
    walk = simulate_gait(replace(gait_preset("ankle", seed), errors=errors))
    return walk.recording, walk.truth


def score_shoe(
    recording: Recording,
    truth: GaitTruth,
    side: Side,
    parameters: ShoeParameters,
    reaction_of: Callable[[ShoeKinetics], GroundReaction] | None = None,
) -> ScoredShoe:
    """Analyse one shoe and lay its estimates over the truth.

    Parameters
    ----------
    reaction_of : callable, optional
        Another way to the ground reaction from the shoe's analysis.
    """
    sensors = recording.sensors
    shoe = analyse_shoe(
        sensors[f"heel_{side}"], sensors[f"forefoot_{side}"], sensors[f"shank_{side}"], parameters
    )
    reaction = shoe.reaction if reaction_of is None else reaction_of(shoe)
    foot = truth.feet[side]
    core = shoe.contact.core
    samples = truth.time_s.size
    stride_starts = [0, *(int(a) for a, _ in core[1:])]
    landings = shoe.contact.land
    stance_starts = [0]
    for (_, before), (after, _) in pairwise(core):
        stance_starts.append(int(landings[(landings > before) & (landings <= after)][-1]) - 2)
    heel = _laid_over(shoe.pose.heel_m, shoe, foot, stride_starts)[0]
    cop, turn = _laid_over(reaction.cop_m, shoe, foot, stance_starts)
    weight = truth.mass_kg * GRAVITY_MPS2
    stance = (foot.force_n[:, 2] > REPORT_SHARE * weight) & (reaction.force_n[:, 2] > REPORT_SHARE * weight)
    inner = np.zeros(samples, dtype=np.bool_)
    inner[core[0, 1] : core[-1, 0]] = True
    inside = np.flatnonzero(np.isfinite(foot.land_s) & np.isfinite(foot.lift_s))
    whole = (truth.time_s > foot.land_s[inside[0]]) & (truth.time_s < foot.lift_s[inside[-1]])
    return ScoredShoe(
        replace(shoe, reaction=reaction),
        foot,
        stance & whole,
        inner,
        weight,
        turn,
        heel,
        cop,
    )


def _laid_over(points: Float, shoe: ShoeKinetics, foot: FootTruth, starts: list[int]) -> tuple[Float, Float]:
    """Turn and shift points so that at every rest the foot is where it truly was; piece by piece."""
    result, turns = np.empty_like(points), np.empty((points.shape[0], 4))
    ends = [*starts[1:], points.shape[0]]
    for (a, b), start, end in zip(shoe.contact.core, starts, ends, strict=True):
        middle = (a + b) // 2
        turn = rotation.about_z(_yaw(foot.heel.q[middle]) - _yaw(shoe.pose.q_room_heel[middle]))
        moved = rotation.rotate(turn, points[start:end] - shoe.pose.heel_m[middle])
        result[start:end] = moved + foot.heel_sensor.position[middle]
        turns[start:end] = turn
    return result, turns


def rms(values: Float) -> float:
    """Return the root mean square of numbers."""
    return float(np.sqrt(np.mean(np.square(values))))


def stride_errors(scored: ScoredShoe) -> dict[str, float]:
    """Return the metrics of the protocol, normalised to body weight; magnitudes are compared as published."""
    shoe, truth, weight, stance = scored.shoe, scored.truth, scored.weight_n, scored.stance
    assert shoe.ankle is not None
    assert shoe.shank_rate_radps is not None
    force = scored.turned(shoe.reaction.force_n)
    length = np.linalg.norm
    true_force, true_moment = truth.force_n[stance], truth.ankle_moment_nm[stance]
    moment = scored.turned(shoe.ankle.moment_nm)[stance]
    cop = (scored.cop_m - truth.cop_m)[stance, :2]
    power, true_power = shoe.ankle.power_w[stance], truth.ankle_power_w[stance]
    moment_error = rms(length(moment, axis=1) - length(true_moment, axis=1))
    power_error = rms(power - true_power)
    travelled = _stride_lengths(scored.heel_m, scored) - _stride_lengths(truth.heel_sensor.position, scored)
    rate = rotation.rotate(rotation.conjugate(shoe.pose.q_room_heel), shoe.pose.heel_rate_radps)
    true_rate = rotation.rotate(rotation.conjugate(truth.heel.q), truth.heel.rate)
    return {
        "force": rms(length(force[stance], axis=1) - length(true_force, axis=1)) / weight,
        "force forward": rms((force[stance] - true_force)[:, 0]) / weight,
        "force sideways": rms((force[stance] - true_force)[:, 1]) / weight,
        "pressure centre": 1e3 * rms(length(cop, axis=1)),
        "heel position": 1e3 * rms(travelled[scored.stride]),
        "ankle moment": moment_error / weight,
        "ankle moment, share": 100.0 * moment_error / float(length(true_moment, axis=1).max()),
        "ankle power, share": 100.0 * power_error / float(np.abs(true_power).max()),
        "heel rate": rms(length(rate - true_rate, axis=1)[scored.stride]),
        "hinge power": rms(shoe.hinge.power_w[stance] - truth.hinge_power_w[stance]) / weight,
    }


def _stride_lengths(points: Float, scored: ScoredShoe) -> Float:
    """Return how far points are from where the foot last rested, shape (N,)."""
    result = np.zeros(points.shape[0])
    core = scored.shoe.contact.core
    for (_, rest), (_, next_rest) in pairwise(core):
        result[rest:next_rest] = np.linalg.norm(points[rest:next_rest] - points[rest - 1], axis=1)
    return result


def _yaw(q: Float) -> float:
    axis = rotation.rotate(q, np.array([1.0, 0.0, 0.0]))
    return float(np.arctan2(axis[1], axis[0]))
