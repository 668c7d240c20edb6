"""Gait events from one inertial sensor on each heel, without forces: healthy, slow, shuffling and uneven walking."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimators.conventions import SIDES
from estimators.gait import Strides, find_strides, smooth, turns
from estimators.recording import Float
from estimators.simulation import Bout, FootTruth, GaitScenario, Leg, gait_preset, simulate_gait
from validation.protocol import Data, Figure, Protocol, Values

_RATE_HZ = 100.0
_STEPS = 8
_PAUSE_S = 3.0
_TURN_LIMIT_RAD = 0.02


def _straight(scenario: GaitScenario) -> GaitScenario:
    """Walk twice with a halt between: two initiations and two terminations."""
    bouts = (Bout((Leg(_STEPS),), _PAUSE_S), Bout((Leg(_STEPS),)))
    return replace(scenario, course=bouts)


def _slow() -> GaitScenario:
    healthy = gait_preset("placement")
    walk = replace(healthy.walk, stride_time_s=2.2, stride_length_m=0.7)
    return replace(healthy, walk=walk)


def _styles() -> dict[str, GaitScenario]:
    return {
        "healthy": _straight(gait_preset("placement")),
        "slow": _straight(_slow()),
        "shuffling": _straight(gait_preset("shuffling")),
        "uneven": _straight(gait_preset("stroke")),
        "turning": gait_preset("turns"),
    }


@dataclass(frozen=True)
class _Style:
    """What a way of walking must keep: errors of events and of stride length, rms."""

    lift_s: float
    land_s: float
    length_m: float


_LIMITS = {
    "healthy": _Style(0.02, 0.02, 0.006),
    "slow": _Style(0.03, 0.03, 0.01),
    "shuffling": _Style(0.02, 0.02, 0.006),
    "uneven": _Style(0.02, 0.06, 0.01),
    "turning": _Style(0.02, 0.02, 0.01),
}


def _errors(strides: Strides, truth: FootTruth) -> dict[str, Float] | None:
    """Return found less true, of every stride; none where their numbers differ."""
    if strides.count != len(truth.lift_s) - 1:
        return None
    length = np.linalg.norm(np.diff(truth.foothold_m[:, :2], axis=0), axis=1)
    return {
        "toe-off": strides.toe_off_s - truth.lift_s[:-1],
        "contact": strides.contact_s - truth.land_s[1:],
        "stride length": strides.length_m - length,
        "turn": strides.turn_rad - np.diff(np.unwrap(truth.foothold_yaw_rad)),
    }


def _events(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}

    def note(name: str, value: float) -> None:
        values.setdefault(name, []).append(value)

    for seed in seeds:
        for style, scenario in _styles().items():
            # The weak side in turn.
            given = scenario.mirrored() if seed % 2 else scenario
            walk = simulate_gait(replace(given, rate_hz=_RATE_HZ, seed=seed, has_load_cells=False))
            errors: dict[str, list[Float]] = {"toe-off": [], "contact": [], "stride length": [], "turn": []}
            wrong, off_bout, off_turn = 0, 0, 0
            for side in SIDES:
                strides = find_strides(smooth(walk.recording.sensors[f"heel_{side}"]), side)
                truth = walk.truth.feet[side]
                found = _errors(strides, truth)
                wrong += abs(strides.count - (len(truth.lift_s) - 1))
                for name, all_of_it in errors.items():
                    all_of_it.append(np.full(1, np.nan) if found is None else found[name])
                bouts = len(scenario.course)
                off_bout += abs(int(strides.is_initiation.sum()) - bouts)
                off_bout += abs(int(strides.is_termination.sum()) - bouts)
                if style == "turning":
                    off_turn += abs(len(turns(strides)) - 2)
            note(f"strides missed or invented, {style}", float(wrong))
            note(f"starts and stops missed or invented, {style}", float(off_bout))
            for name, all_of_it in errors.items():
                note(f"{name}, rms error, {style}", float(np.sqrt(np.mean(np.concatenate(all_of_it) ** 2))))
            if style == "turning":
                note("turns missed or invented", float(off_turn))
    return {name: np.array(found) for name, found in values.items()}


FOOT_EVENTS = Protocol(
    name="foot_events",
    title="Gait events and strides from inertial signals alone",
    source="Schepers 2009, chapter 3 (F14); method page on foot placement, 5.4",
    what="Healthy, slow, shuffling and stroke-like people walk eight steps, halt, and walk eight more; another turns "
    "about twice. One sensor a heel at 100 Hz, nominal errors, no forces, one parameter set; events and stride "
    "lengths against exact truth, root mean square over both feet. A dropped foot lands on its toes, softly, "
    "which is why contact of uneven walking is allowed more.",
    figures=(
        *(
            figure
            for style, limits in _LIMITS.items()
            for figure in (
                Figure(f"strides missed or invented, {style}", "1", 0.0),
                Figure(f"starts and stops missed or invented, {style}", "1", 0.0),
                Figure(f"toe-off, rms error, {style}", "s", limits.lift_s),
                Figure(f"contact, rms error, {style}", "s", limits.land_s),
                Figure(f"stride length, rms error, {style}", "m", limits.length_m, judged_by="median"),
                Figure(f"turn, rms error, {style}", "rad", _TURN_LIMIT_RAD, judged_by="median"),
            )
        ),
        Figure("turns missed or invented", "1", 0.0),
    ),
    measure=_events,
)
