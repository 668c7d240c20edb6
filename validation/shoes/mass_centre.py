"""Centre of mass from instrumented shoes: Schepers (2009) chapter 4, and our improved form."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimators.balance import distance_between_feet, smooth_mass_centre, stride_balance
from estimators.balance.published import LiveMassCentre, pressure_only, published_mass_centre, total_reaction
from estimators.conventions import SIDES, Side
from estimators.kinetics import GroundReaction, ShoeParameters, ground_reaction
from estimators.recording import Float
from estimators.simulation import Bout, Leg, gait_preset
from validation.protocol import Data, Figure, Protocol, Values
from validation.shoes.walk import AnalysedWalk, analysed_walk, axis_errors_mm, com_scenario

_HEIGHT_M = 1.80
_AXES = ("x", "y", "z")


def _mass_centre(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}

    def note(name: str, value: float) -> None:
        values.setdefault(name, []).append(value)

    for seed in seeds:
        for arm, kind in ((0.0, ""), (0.02, ", lively trunk")):
            walk = analysed_walk(com_scenario(seed, arm))
            published = axis_errors_mm(published_mass_centre(*walk.fused).position_m, walk.truth)
            smoothed = smooth_mass_centre(*walk.fused, walk.feet.is_standing).position_m
            improved = axis_errors_mm(smoothed, walk.truth)
            for axis, name in enumerate(_AXES):
                note(f"published form, {name}{kind}", published[axis])
                note(f"improved form, {name}{kind}", improved[axis])
            if kind:
                continue
            note("published form, distance", float(np.linalg.norm(published)))
            note("published form, share of height", 0.1 * float(published[0]) / _HEIGHT_M)
            _, literal = total_reaction(walk.feet.reaction, weights="published")
            force, _, *rest = walk.fused
            weights = published_mass_centre(force, literal, *rest).position_m
            note("printed weights, x more by", axis_errors_mm(weights, walk.truth)[0] - published[0])
            single = published_mass_centre(*walk.fused, zero_phase=False, ends_at_rest=False).position_m
            times = axis_errors_mm(single, walk.truth)[:2] / published[:2]
            note("single pass, times the error", float(times.min()))
            live = LiveMassCentre(*walk.fused[2:]).update(force, walk.feet.cop_m, walk.feet.is_standing)
            for axis, name in enumerate(_AXES):
                note(f"live, {name}", axis_errors_mm(live.position_m, walk.truth)[axis])
    return {name: np.array(found) for name, found in values.items()}


_PUBLISHED_MM = (20.0, 13.0, 7.0)
_IMPROVED_MM = (8.0, 7.0, 2.5)

MASS_CENTRE = Protocol(
    name="com_mass_centre",
    title="Centre of mass from two instrumented shoes",
    source="Schepers 2009, section 4.3 (P1 to P3); method page V1 to V5, V9, V10, errata E1 and E4",
    what="Stroke patients' pace, 18 steps from standing to standing, 50 Hz, nominal sensors; RMS with the mean "
    "of x and y taken out. Published fusion and ours, with a quiet and a lively trunk; what the printed weights and a "
    "single pass would do; and our live form.",
    figures=(
        *(
            Figure(f"{form}, {axis}{kind}", "mm", limit, source, judged_by="median")
            for kind in ("", ", lively trunk")
            for form, limits, sources in (
                ("published form", _PUBLISHED_MM, _PUBLISHED_MM),
                ("improved form", _IMPROVED_MM, (None, None, None)),
            )
            for axis, limit, source in zip(_AXES, limits, sources, strict=True)
        ),
        Figure("published form, distance", "mm", 25.0, 25.0, judged_by="median"),
        Figure("published form, share of height", "%", 1.1, 1.1, judged_by="median"),
        Figure("printed weights, x more by", "mm", 4.0, at_most=False, judged_by="median"),
        Figure("single pass, times the error", "", 2.0, at_most=False, judged_by="median"),
        Figure("live, x", "mm", 20.0, judged_by="median"),
        Figure("live, y", "mm", 13.0, judged_by="median"),
        Figure("live, z", "mm"),
    ),
    measure=_mass_centre,
)

_CUTOFFS_HZ = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0)


def _cutoffs(seeds: Sequence[int], data: Data) -> Values:
    fused = np.empty((len(seeds), len(_CUTOFFS_HZ), 3))
    ratio = []
    for number, seed in enumerate(seeds):
        walk = analysed_walk(com_scenario(seed))
        for column, cutoff in enumerate(_CUTOFFS_HZ):
            found = published_mass_centre(*walk.fused, cutoff_hz=(cutoff, cutoff, cutoff))
            fused[number, column] = axis_errors_mm(found.position_m, walk.truth)
        alone = walk.truth.com.position.copy()
        alone[:, :2] = pressure_only(walk.feet.cop_m, walk.feet.rate_hz, (0.2, 0.2))
        plain = axis_errors_mm(alone, walk.truth)
        ratio.append(fused[number, _CUTOFFS_HZ.index(0.2), :2] / plain[:2])
    best = np.array(_CUTOFFS_HZ)[fused.mean(axis=0).argmin(axis=0)]
    shares = np.array(ratio)
    return {
        "best cut-off, x": np.array([best[0]]),
        "best cut-off, y": np.array([best[1]]),
        "best cut-off, z": np.array([best[2]]),
        "fused by pressure centre alone, x": shares[:, 0],
        "fused by pressure centre alone, y": shares[:, 1],
    }


CUTOFFS = Protocol(
    name="com_cutoffs",
    title="Cut-off of the centre-of-mass fusion",
    source="Schepers 2009, section 4.3 and figure 4.3 (P4, P6); method page V6 and V7",
    what="The cut-off with the smallest mean error over all seeds, from 0.1 to 1 Hz; and the fused error at 0.2 Hz "
    "over that of the low-passed pressure centre alone.",
    figures=(
        Figure("best cut-off, x", "Hz", 0.3, 0.2),
        Figure("best cut-off, y", "Hz", 0.3, 0.2),
        Figure("best cut-off, z", "Hz", 0.7, 0.5),
        Figure("fused by pressure centre alone, x", "", 0.5, judged_by="median"),
        Figure("fused by pressure centre alone, y", "", 0.5, judged_by="median"),
    ),
    measure=_cutoffs,
)


def _from_zero(walk: AnalysedWalk) -> dict[Side, GroundReaction]:
    """Return the reactions as if nothing were known of the feet's distance: both start at y = 0."""
    result: dict[Side, GroundReaction] = {}
    for side in SIDES:
        pose = walk.feet.pose[side]
        aside = np.array([0.0, -float(pose.heel_m[0, 1]), 0.0])
        result[side] = ground_reaction(walk.shoes[side].loads, pose.moved(0.0, aside))
    return result


def _distance(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, Float] = {}
    for arm, kind in ((0.0, ""), (0.02, ", lively trunk")):
        errors = []
        for seed in seeds:
            scenario = com_scenario(seed, arm)
            walk = analysed_walk(scenario)
            found = distance_between_feet(
                _from_zero(walk),
                walk.feet.rate_hz,
                walk.mass_kg,
                walk.height_m,
                is_walking=~walk.feet.is_standing,
            )
            errors.append(1e3 * (found - scenario.walk.step_width_m))
        table = np.array(errors)
        values[f"distance, mean error{kind}"] = np.array([abs(table.mean())])
        spread = float(table.std(ddof=1)) if len(seeds) > 1 else 0.0
        values[f"distance, standard deviation{kind}"] = np.array([spread])
    return values


FOOT_DISTANCE = Protocol(
    name="com_foot_distance",
    title="Distance of the feet from the forces alone",
    source="Schepers 2009, sections 4.4 and 7.2 (recommendation); method page V11",
    what="The feet start 180 mm apart, which is not given; found from the law of rotation. Mean error and standard "
    "deviation over the seeds. The simulated feet have mass, which the law leaves out.",
    figures=(
        Figure("distance, mean error", "mm", 10.0),
        Figure("distance, standard deviation", "mm", 20.0),
        Figure("distance, mean error, lively trunk", "mm", 40.0),
        Figure("distance, standard deviation, lively trunk", "mm", 25.0),
    ),
    measure=_distance,
)


def _stroke(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for seed in seeds:
        base = gait_preset("stroke", seed)
        scenario = base if seed % 2 else base.mirrored()
        paretic: Side = "left" if seed % 2 else "right"
        sound: Side = "right" if seed % 2 else "left"
        walk = analysed_walk(replace(scenario, errors="shoe_nominal"), ShoeParameters())
        truth, poses = walk.truth, walk.feet.pose
        found = smooth_mass_centre(*walk.fused, walk.feet.is_standing)
        errors = axis_errors_mm(found.position_m, truth)
        inner = (truth.time_s > truth.active_s[0, 0]) & (truth.time_s < truth.active_s[0, 1])
        strides = stride_balance(
            walk.feet, {side: shoe.contact for side, shoe in walk.shoes.items()}, found, walk.mass_kg
        )
        # Positive is to the left.
        aside = float(strides.aside_m.mean()) * (1.0 if sound == "left" else -1.0)
        turned = {side: _outward(poses[side].q_room_heel, walk, side) for side in SIDES}
        true = {side: _outward(truth.feet[side].heel.q, walk, side) for side in SIDES}
        stance = {side: float(np.mean(walk.shoes[side].contact.any[inner])) for side in SIDES}
        apart, truly = turned[paretic] - turned[sound], true[paretic] - true[sound]
        for name, value in (
            ("toward the sound leg", 1e3 * aside),
            ("toe-out difference, error", abs(float(np.degrees(apart - truly)))),
            ("paretic foot turned outward more by", float(np.degrees(apart))),
            ("sound leg's stance longer by", 100.0 * (stance[sound] - stance[paretic])),
            *((f"improved form, {axis}", errors[i]) for i, axis in enumerate(_AXES)),
        ):
            values.setdefault(name, []).append(value)
    return {name: np.array(found) for name, found in values.items()}


def _outward(q_room_heel: Float, walk: AnalysedWalk, side: Side) -> float:
    """Return how far a foot points outward at rest, mean over its inner stances."""
    rests = walk.shoes[side].contact.core[1:-1].mean(axis=1).astype(int)
    yaws = [_yaw(q_room_heel[at]) for at in rests]
    return float(np.mean(yaws)) * (1.0 if side == "left" else -1.0)


def _yaw(q: Float) -> float:
    return float(np.arctan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] ** 2 + q[3] ** 2)))


STROKE_GAIT = Protocol(
    name="com_stroke_gait",
    title="Asymmetric gait after a stroke",
    source="Schepers 2009, figure 4.6 (P9); method page V13",
    what="Dropped, circumducted and outward-turned paretic foot, left and right in turn; the centre of mass, mean of "
    "whole strides, must lie toward the sound leg from the middle between the soles, and the difference of toe-out "
    "must come back.",
    figures=(
        Figure("toward the sound leg", "mm", 0.0, at_most=False),
        Figure("toe-out difference, error", "deg", 3.0),
        Figure("paretic foot turned outward more by", "deg", 10.0, at_most=False),
        Figure("sound leg's stance longer by", "%", 2.0, at_most=False),
        *(
            Figure(f"improved form, {axis}", "mm", limit, judged_by="median")
            for axis, limit in zip(_AXES, (12.0, 9.0, 4.0), strict=True)
        ),
    ),
    measure=_stroke,
)


def _long(seeds: Sequence[int], data: Data) -> Values:
    errors, relative = [], []
    for seed in seeds:
        scenario = replace(com_scenario(seed, 0.02), course=(Bout((Leg(59),)),))
        walk = analysed_walk(scenario)
        found = published_mass_centre(*walk.fused)
        errors.append(axis_errors_mm(found.position_m, walk.truth))
        lean = found.position_m - walk.feet.cop_m - (walk.truth.com.position - walk.truth.cop_m)
        half = lean.shape[0] // 2
        relative.append([1e3 * np.sqrt(np.mean(part[:, :2] ** 2)) for part in (lean[:half], lean[half:])])
    table, halves = np.array(errors), np.array(relative)
    return {
        "x": table[:, 0],
        "y": table[:, 1],
        "z": table[:, 2],
        "over the pressure centre, first half": halves[:, 0],
        "over the pressure centre, second half": halves[:, 1],
    }


LONG_WALK = Protocol(
    name="com_long_walk",
    title="Centre of mass over a walk of fifty seconds",
    source="Method page V12",
    what="59 steps with a lively trunk. The drift of the feet enters the absolute position; against the pressure "
    "centre the second half must keep the limit of the first.",
    figures=(
        Figure("x", "mm", 40.0, judged_by="median"),
        Figure("y", "mm", 25.0, judged_by="median"),
        Figure("z", "mm", 7.0, judged_by="median"),
        Figure("over the pressure centre, first half", "mm", 20.0, judged_by="median"),
        Figure("over the pressure centre, second half", "mm", 20.0, judged_by="median"),
    ),
    measure=_long,
)
