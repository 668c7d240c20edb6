"""Forces, centre of pressure, ankle moment and power of the instrumented shoe: Schepers (2009) chapter 2."""

from collections.abc import Sequence

import numpy as np

from estimators import rotation
from estimators.conventions import SIDES
from estimators.kinetics import GroundReaction, ShoeKinetics, ShoeParameters, ground_reaction
from estimators.recording import Float
from estimators.signals import low_pass
from validation.protocol import Data, Figure, Protocol, Values
from validation.shoes.ankle_shoe import (
    ScoredShoe,
    rms,
    score_shoe,
    simulated_ankle,
    stride_errors,
)

_RATE_HZ = 50.0


def _on_sensor_plane(shoe: ShoeKinetics) -> GroundReaction:
    """Repeat equation 2.8 as printed: the floor is taken to be at the height of the heel sensor (E2)."""
    return ground_reaction(shoe.loads, shoe.pose, floor_m=ShoeParameters().geometry.sensor_height_m)


def _dynamics(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for seed in seeds:
        found: dict[str, list[float]] = {}
        for errors, kind in (("shoe_nominal", ""), ("ideal", ", no sensor errors")):
            recording, truth = simulated_ankle(seed, errors)
            for side in SIDES:
                scored = score_shoe(recording, truth, side, ShoeParameters(position_mode="pivot"))
                measured = stride_errors(scored)
                if kind:
                    measured = {"force": measured["force"]}
                else:
                    literal = score_shoe(recording, truth, side, ShoeParameters(), _on_sensor_plane)
                    printed = score_shoe(recording, truth, side, ShoeParameters(position_mode="published"))
                    measured["pressure centre, as printed"] = stride_errors(literal)["pressure centre"]
                    measured["heel position, as printed"] = stride_errors(printed)["heel position"]
                    measured |= _closure(scored) | _against_optics(scored, seed)
                for name, value in measured.items():
                    found.setdefault(name + kind, []).append(value)
        for name, both in found.items():
            values.setdefault(name, []).append(float(np.mean(both)))
    return {figure.name: np.array(values[figure.name]) for figure in _FIGURES}


def _closure(scored: ScoredShoe) -> dict[str, float]:
    """Energy of a massless foot that does not slip: ankle and hinge power are what the ankle takes in."""
    shoe, truth = scored.shoe, scored.truth
    assert shoe.ankle is not None
    assert shoe.shank_rate_radps is not None
    force, moment = shoe.reaction.force_n, shoe.ankle.moment_nm
    shoe_power = shoe.ankle.power_w + shoe.hinge.power_w
    velocity = rotation.rotate(rotation.conjugate(scored.turn), truth.ankle.velocity)
    taken = np.sum(force * velocity, axis=1) - np.sum(moment * shoe.shank_rate_radps, axis=1)
    stance = scored.stance
    return {"power closure": rms((shoe_power - taken)[stance]) / scored.weight_n}


def _against_optics(scored: ScoredShoe, seed: int) -> dict[str, float]:
    """Power with the rates of a marker-based reference: one rigid foot, differentiated, smoothed at 5 Hz."""
    truth, geometry = scored.truth, ShoeParameters().geometry
    rng = np.random.default_rng([seed, 31])
    own = np.array([[-0.05, 0.0, 0.03], [0.03, -0.04, 0.07]])
    markers = [truth.heel_sensor.position + rotation.rotate(truth.heel.q, point) for point in own]
    toe = np.array([0.05, 0.0, 0.06])
    markers.append(truth.hinge.position + rotation.rotate(truth.forefoot.q, toe))
    reference = np.vstack((own, geometry.hinge_point_m + toe))
    measured = np.stack(markers, axis=1) + 0.0005 * rng.normal(size=(truth.force_n.shape[0], 3, 3))
    foot_rate = _rate_of(_fitted(reference, measured))
    wobble = rotation.exp(0.0005 / 0.15 * rng.normal(size=(truth.force_n.shape[0], 3)))
    shank_rate = _rate_of(rotation.multiply(wobble, truth.shank.q))
    difference = low_pass(foot_rate - shank_rate, _RATE_HZ, 5.0, axis=0)
    reference_power = np.sum(truth.ankle_moment_nm * difference, axis=1)
    assert scored.shoe.ankle is not None
    ours = scored.shoe.ankle.power_w
    stance = scored.stance
    share = rms((ours - reference_power)[stance]) / float(np.abs(truth.ankle_power_w[stance]).max())
    return {"ankle power against markers": 100.0 * share}


def _fitted(reference: Float, measured: Float) -> Float:
    """Return the rotations, shape (N, 4), that lay a rigid set of points best over measured ones (Kabsch)."""
    model = reference - reference.mean(axis=0)
    seen = measured - measured.mean(axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(np.einsum("nki,kj->nij", seen, model))
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    return rotation.continuous(rotation.from_matrix(u @ vt))


def _rate_of(q: Float) -> Float:
    """Return room-frame rates by central differences, shape (N, 3)."""
    rate = np.zeros((q.shape[0], 3))
    rate[1:-1] = rotation.log(rotation.multiply(q[2:], rotation.conjugate(q[:-2]))) * (0.5 * _RATE_HZ)
    return rate


_FIGURES = (
    Figure("force", "N/N", 0.012, 0.012, judged_by="median"),
    Figure("force, no sensor errors", "N/N", 0.003),
    Figure("force forward", "N/N", 0.010, 0.019),
    Figure("force sideways", "N/N", 0.007, 0.007, judged_by="median"),
    Figure("pressure centre", "mm", 2.0, 5.1),
    Figure("pressure centre, as printed", "mm", 7.0, 5.1),
    Figure("heel position", "mm", 6.0, 18.0, judged_by="median"),
    Figure("heel position, as printed", "mm", 55.0, 18.0),
    Figure("ankle moment", "Nm/N", 0.0025, 0.004, judged_by="median"),
    Figure("ankle moment, share", "%", 1.5, 2.3, judged_by="median"),
    Figure("ankle power, share", "%", 2.0, 14.0),
    Figure("ankle power against markers", "%", 19.0, 14.0),
    Figure("heel rate", "rad/s", 0.05, 0.85),
    Figure("hinge power", "W/N", 0.005),
    Figure("power closure", "W/N", 0.005),
)

ANKLE_DYNAMICS = Protocol(
    name="ankle_dynamics",
    title="Forces, centre of pressure, ankle moment and power of the instrumented shoe",
    source="Schepers 2009, chapter 2, section 2.3; method page V1 to V9, errata E2, E3, E5, E7, E8",
    what="One trial of ten steps a seed at 50 Hz and 15 Hz low-pass, both feet, strides 2 to the last but one, loaded "
    "stance, against exact truth; magnitudes are compared as published. 'As printed' repeats the equations with "
    "their errors: the floor at the height of the heel sensor, and rest at heel-down.",
    figures=_FIGURES,
    measure=_dynamics,
)
