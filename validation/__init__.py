"""Published experiments repeated: protocol, published figure, what we require, what we measure.

::

    results = run(["arm_orientation"], seeds=8)
    print(to_table(results))

No files are read here: recordings for protocols with `needs_data` are handed in by the caller.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from estimators.errors import SetupError
from estimators.recording import Recording
from validation.arm.functional import FUNCTIONAL_CALIBRATION
from validation.arm.hand_motion import BIAS_STATES, HAND_MOTION, SINGULARITY
from validation.arm.iron import MAGNETIC_CALIBRATION
from validation.arm.joint_headings import JOINT_HEADINGS
from validation.arm.kinematics import CONVERSIONS, ELBOW_POSITION, KINEMATIC_IDENTITY
from validation.arm.recording import ARM_RECORDING
from validation.arm.repetitions import ANY_REPETITIONS
from validation.arm.sessions import ARM_SESSION, REPETITIONS, TEMPLATE_COMPARISON
from validation.arm.static import GYROSCOPE_DRIFT, HEADING_SHIFT, STATIC_ANGLES
from validation.disturbance.elbow import ELBOW_FLEXION
from validation.disturbance.static import STATIC_IRON
from validation.disturbance.steel_case import STEEL_CASE
from validation.disturbance.turns import QUARTER_TURNS
from validation.foot.conditions import FOOT_CONDITIONS
from validation.foot.events import FOOT_EVENTS
from validation.foot.placement import FOOT_PLACEMENT
from validation.foot.rates import FOOT_RATES_AND_LINKS
from validation.foot.recordings import (
    FOOT_LOOPS,
    FOOT_PATIENT,
    FOOT_STAIRS,
    FOOT_STRIDES,
    FOOT_WALKS,
)
from validation.guidance import COST, COUNT, CUES, PHASE
from validation.inclination.consistency import CONSISTENCY
from validation.inclination.offset import OFFSET_RECOVERY, STILL_SENSOR
from validation.inclination.tasks import INCLINATION_TASKS
from validation.judgement import Verdict
from validation.magnetic.checks import MAGNETIC_FUSION_CHECKS
from validation.magnetic.checks_model import MAGNETIC_MODEL_CHECKS
from validation.magnetic.checks_tracker import MAGNETIC_TRACKER_CHECKS
from validation.magnetic.tracker import MAGNETIC_MOVEMENTS, MAGNETIC_TRACKER
from validation.magnetic.tracker_fusion import MAGNETIC_FUSION
from validation.magnetic.tracker_loose import MAGNETIC_LOOSE_FUSION
from validation.magnetic.tracker_model import MAGNETIC_BENCH, MAGNETIC_MAPS, MAGNETIC_UPDATES
from validation.optical.checks import OPTICAL_NOISE_CHECKS
from validation.optical.gaps import OPTICAL_GAIT, OPTICAL_GAPS, OPTICAL_RATES
from validation.optical.innovation import OPTICAL_INNOVATION_CHECKS
from validation.optical.recording import OPTICAL_CONSISTENCY, OPTICAL_RECORDING
from validation.optical.refusal import OPTICAL_REFUSAL
from validation.orientation.broad import BROAD
from validation.orientation.broad_conditions import BROAD_CONDITIONS
from validation.orientation.broad_cuts import BROAD_CUTS
from validation.orientation.broad_offline import BROAD_OFFLINE
from validation.orientation.covariance import COVARIANCE
from validation.orientation.false_diagnoses import FALSE_DIAGNOSES
from validation.orientation.honesty import HONESTY
from validation.orientation.wrong_inputs import WRONG_INPUTS
from validation.progress import PROGRESS_FALSE_ALARMS, PROGRESS_INTERVAL, PROGRESS_POWER
from validation.protocol import (
    Curve,
    Data,
    Figure,
    FigureResult,
    Plot,
    Protocol,
    ProtocolResult,
    Values,
    gather,
    measured,
    parts_of,
    run_protocol,
)
from validation.relative_pose.accuracy import (
    RELATIVE_POSE_SMOOTHING,
    RELATIVE_POSE_START,
    RELATIVE_POSE_TABLE,
)
from validation.relative_pose.actuation import (
    RELATIVE_POSE_ACTUATION,
    RELATIVE_POSE_ENERGY,
    RELATIVE_POSE_MODELS,
)
from validation.relative_pose.checks import RELATIVE_POSE_CHECKS
from validation.relative_pose.faults import (
    RELATIVE_POSE_FAULTS,
    RELATIVE_POSE_IRON,
    RELATIVE_POSE_TEN_HOURS,
)
from validation.relative_pose.feet import RELATIVE_POSE_FEET
from validation.render import to_data, to_json, to_markdown, to_table
from validation.shoes.ankle_dynamics import ANKLE_DYNAMICS
from validation.shoes.mass_centre import (
    CUTOFFS,
    FOOT_DISTANCE,
    LONG_WALK,
    MASS_CENTRE,
    STROKE_GAIT,
)
from validation.worlds.ablation import ORIENTATION_ABLATION
from validation.worlds.experiment import ORIENTATION_WORLDS

_PROTOCOLS = (
    STATIC_ANGLES,
    GYROSCOPE_DRIFT,
    CONVERSIONS,
    HAND_MOTION,
    BIAS_STATES,
    SINGULARITY,
    HEADING_SHIFT,
    MAGNETIC_CALIBRATION,
    KINEMATIC_IDENTITY,
    ELBOW_POSITION,
    TEMPLATE_COMPARISON,
    REPETITIONS,
    ANY_REPETITIONS,
    ARM_SESSION,
    PHASE,
    COUNT,
    CUES,
    COST,
    PROGRESS_FALSE_ALARMS,
    PROGRESS_POWER,
    PROGRESS_INTERVAL,
    FUNCTIONAL_CALIBRATION,
    JOINT_HEADINGS,
    INCLINATION_TASKS,
    OFFSET_RECOVERY,
    STILL_SENSOR,
    CONSISTENCY,
    COVARIANCE,
    HONESTY,
    ORIENTATION_WORLDS,
    ORIENTATION_ABLATION,
    STATIC_IRON,
    QUARTER_TURNS,
    ELBOW_FLEXION,
    STEEL_CASE,
    FOOT_PLACEMENT,
    FOOT_CONDITIONS,
    FOOT_EVENTS,
    FOOT_WALKS,
    FOOT_STRIDES,
    FOOT_LOOPS,
    FOOT_STAIRS,
    FOOT_PATIENT,
    FOOT_RATES_AND_LINKS,
    ANKLE_DYNAMICS,
    MASS_CENTRE,
    CUTOFFS,
    FOOT_DISTANCE,
    STROKE_GAIT,
    LONG_WALK,
    MAGNETIC_BENCH,
    MAGNETIC_MAPS,
    MAGNETIC_UPDATES,
    MAGNETIC_TRACKER,
    MAGNETIC_MOVEMENTS,
    MAGNETIC_FUSION,
    MAGNETIC_LOOSE_FUSION,
    MAGNETIC_MODEL_CHECKS,
    MAGNETIC_TRACKER_CHECKS,
    MAGNETIC_FUSION_CHECKS,
    RELATIVE_POSE_TABLE,
    RELATIVE_POSE_SMOOTHING,
    RELATIVE_POSE_START,
    RELATIVE_POSE_ACTUATION,
    RELATIVE_POSE_ENERGY,
    RELATIVE_POSE_MODELS,
    RELATIVE_POSE_FEET,
    RELATIVE_POSE_IRON,
    RELATIVE_POSE_FAULTS,
    RELATIVE_POSE_TEN_HOURS,
    RELATIVE_POSE_CHECKS,
    OPTICAL_GAPS,
    OPTICAL_RATES,
    OPTICAL_GAIT,
    OPTICAL_RECORDING,
    OPTICAL_CONSISTENCY,
    OPTICAL_NOISE_CHECKS,
    OPTICAL_INNOVATION_CHECKS,
    OPTICAL_REFUSAL,
    FALSE_DIAGNOSES,
    ARM_RECORDING,
    BROAD,
    BROAD_CONDITIONS,
    BROAD_OFFLINE,
    BROAD_CUTS,
    WRONG_INPUTS,
)
MOST_SEEDS = 1000


def protocols() -> tuple[Protocol, ...]:
    """Return every protocol, simulations first."""
    return _PROTOCOLS


def run(
    names: Iterable[str] | None = None,
    seeds: int = 20,
    data: Data | None = None,
    *,
    first_seed: int = 0,
    plots: bool = False,
    report: Callable[[ProtocolResult], None] | None = None,
) -> list[ProtocolResult]:
    """Repeat published experiments.

    Parameters
    ----------
    names : iterable of str, optional
        Which; all by default. Without data, those that need recordings are left out unless named.
    seeds : int
        Simulated repetitions of each.
    data : mapping of str to Recording, optional
        Trials of BROAD, recordings of feet, each with its `reference`, and of arms; a protocol gets those of its kind.
    first_seed : int
        The seeds are this one and those after it.
    plots : bool
        Also make the curves of each.
    report : callable, optional
        Called with the result of each protocol as it is done.

    Returns
    -------
    list of ProtocolResult
        In the order of `protocols()`.

    Raises
    ------
    SetupError
        For an unknown name, no seeds, a negative seed, or a protocol named without the recordings it needs.
    """
    results = []
    for protocol, given in chosen(names, seeds, data or {}, first_seed):
        results.append(run_protocol(protocol, seeds, given, first_seed=first_seed, plots=plots))
        if report is not None:
            report(results[-1])
    return results


def chosen(
    names: Iterable[str] | None, seeds: int, data: Data, first_seed: int = 0
) -> list[tuple[Protocol, Data]]:
    """Return the protocols that `run` would repeat, each with the recordings of its kind; raises as `run` does."""
    if not 1 <= seeds <= MOST_SEEDS:
        raise SetupError(f"{seeds} seeds; use 1 to {MOST_SEEDS}")
    if first_seed < 0:
        raise SetupError(f"{first_seed} is no seed; use 0 or more")
    wanted = None if names is None else set(names)
    if wanted is not None and (unknown := sorted(wanted - {protocol.name for protocol in _PROTOCOLS})):
        known = ", ".join(protocol.name for protocol in _PROTOCOLS)
        raise SetupError(f"no protocol {', '.join(unknown)}; known are {known}")
    found: list[tuple[Protocol, Data]] = []
    for protocol in _PROTOCOLS:
        if wanted is not None and protocol.name not in wanted:
            continue
        fitting = {name: one for name, one in data.items() if protocol.needs_data in kinds(one)}
        if protocol.needs_data and not fitting:
            if wanted is not None:
                raise SetupError(
                    f"{protocol.name} needs recordings of {protocol.needs_data}; give them as data"
                )
            continue
        found.append((protocol, fitting))
    return found


def kinds(recording: Recording) -> set[str]:
    """Return what a recording can be used for: its set, and for gaitmap whether it has strides or stairs."""
    found = {recording.metadata.get("format", "broad"), "sensor readings"}
    if "strides_left" in recording.reference:
        found.add("gaitmap strides")
    if "gaitmap" in found and "stair" in recording.metadata.get("walk", ""):
        found.add("gaitmap stairs")
    if "gaitmap" in found and "_ms_" in recording.metadata.get("walk", ""):
        found.add("gaitmap patient")
    return found


def from_data(entries: Iterable[Mapping[str, Any]]) -> list[ProtocolResult]:
    """Return the results that `to_data` wrote, without their plots, in the order of `protocols`.

    Returns
    -------
    list of ProtocolResult
        Of the experiments that there still are; one whose figures or limits have changed since counts as none.
    """
    stored = {entry["name"]: entry for entry in entries}
    found = []
    for protocol in protocols():
        entry = stored.get(protocol.name)
        if entry is None or [(figure.name, figure.required) for figure in protocol.figures] != [
            (one["name"], one["required"]) for one in entry["figures"]
        ]:
            continue
        figures = tuple(
            FigureResult(figure, np.array(one["values"], dtype=np.float64), one["each"])
            for figure, one in zip(protocol.figures, entry["figures"], strict=True)
        )
        found.append(
            ProtocolResult(
                protocol, figures, entry["seeds"], entry["seconds"], first_seed=entry["first_seed"]
            )
        )
    return found


__all__ = [
    "Curve",
    "Data",
    "Figure",
    "FigureResult",
    "Plot",
    "Protocol",
    "ProtocolResult",
    "Values",
    "Verdict",
    "chosen",
    "from_data",
    "gather",
    "kinds",
    "measured",
    "parts_of",
    "protocols",
    "run",
    "to_data",
    "to_json",
    "to_markdown",
    "to_table",
]
