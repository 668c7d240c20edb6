"""A walk on two instrumented shoes: forces, joint loads and the centre of mass beside the movement of the feet."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.balance import (
    BothFeet,
    MassCentre,
    StabilityMargin,
    body_mass,
    combine_feet,
    combine_turning_feet,
    distance_between_feet,
    smooth_mass_centre,
    sole_corners,
    stability_margin,
)
from estimators.conventions import GRAVITY_MPS2, SIDES, Side
from estimators.errors import SetupError, ShapeError
from estimators.gait import USUAL_APART_M, Measure, Strides, measure_steps, summarise
from estimators.kinetics import ShoeContact, ShoeGeometry, ShoeKinetics, ShoeParameters, analyse_shoe
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import SessionSetup
from estimators.pipelines.walk.layout import BALANCE_POINTS, BALANCE_SCALARS, CENTRE_PER_STATURE, SCALARS
from estimators.pipelines.walk.shoe_checks import (
    EXCHANGED,
    EXCHANGED_M,
    refuse_stairs,
    refuse_wrong_loads,
    saturated,
)
from estimators.pipelines.walk.shoe_mounting import Mounting, shoe_mounting
from estimators.pipelines.walk.turning_steps import steps_on_course
from estimators.pipelines.walk.walk import Walk, event_columns
from estimators.recording import Float, Recording
from estimators.sentences import say

ApartSource = Literal["measured", "forces", "usual"]
_WIDTH_RANGE_M: Final = (0.03, 0.45)
_SUPPORT_HZ: Final = 25.0
_APART_SIGMA_M: Final[dict[ApartSource, float]] = {"measured": 0.01, "forces": 0.02, "usual": 0.04}
_SAME_EVENT_S: Final = 0.25


@dataclass(frozen=True)
class ShoeWalk:
    """What two instrumented shoes tell of a walk over N samples of their own.

    Attributes
    ----------
    time_s : ndarray, shape (N,)
    mass_kg : float
        As the shoes feel it.
    support_s : ndarray, shape (M,)
        Every few samples: when the base of support was looked at.
    margin : StabilityMargin
        At those M moments.
    apart_m, apart_source
        How far the feet stood apart at the start, and whether that was `measured`, given by the `forces`, or is
        `usual` only.
    """

    time_s: Float
    shoes: Mapping[Side, ShoeKinetics]
    feet: BothFeet
    mass_kg: float
    centre: MassCentre
    support_s: Float
    margin: StabilityMargin
    apart_m: float
    apart_source: ApartSource
    reasons: tuple[str, ...] = ()
    """What is doubtful about the forces, for people."""
    relation_sigma_m: float = 0.0
    """On a turning course: one sigma of where the feet are against each other."""


def has_shoes(recording: Recording) -> bool:
    """Return whether both feet have heel and forefoot sensors with load cells."""
    return all(
        f"{part}_{side}" in recording.sensors and recording.sensors[f"{part}_{side}"].force_n is not None
        for side in SIDES
        for part in ("heel", "forefoot")
    )


def analyse_shoes(recording: Recording, setup: SessionSetup, walk: Walk | None = None) -> ShoeWalk:
    """Analyse both shoes of a walk off-line, up to the margin of stability.

    Parameters
    ----------
    recording : Recording
        With sensors `heel_left`, `forefoot_left` and so on, on one even time base.
    setup : SessionSetup
        Stature tells the mean height of the centre of mass; `feet_apart_m` and `feet_apart_end_m` relate the feet.
    walk : Walk, optional
        Of the same recording: its strides tell how the sensors sit on the shoes, and whether the ground is level.
        Without it sensors are taken to be in segment axes.

    Raises
    ------
    SetupError, ShapeError
        A sensor is missing, a cell shows what cannot be, no stance was found, or the walk goes up or down stairs; the
        message says which shoe.
    """
    if not has_shoes(recording):
        raise SetupError(say("shoes.cells_missing"))
    if walk is not None:
        refuse_stairs(walk.strides)
    sensors = recording.sensors
    chosen = ShoeParameters(position_mode="pivot")
    shoes = {side: _shoe(recording, side, chosen, _mounting(recording, setup, walk, side)) for side in SIDES}
    refuse_wrong_loads(shoes)
    height_m = CENTRE_PER_STATURE * setup.body.stature_m
    is_turning = walk is not None and walk.summary.turn_count > 0
    apart_m, source, reasons = _apart(shoes, setup, height_m, is_turning)
    feet, sigma_m = _combined(shoes, apart_m, setup.feet_apart_end_m, source, is_turning)
    mass_kg = _mass(feet)
    centre = smooth_mass_centre(feet.force_n, feet.cop_m, feet.rate_hz, mass_kg, height_m, feet.is_standing)
    corners = {
        side: sole_corners(
            feet.pose[side], chosen.geometry, shoes[side].contact.heel, shoes[side].contact.forefoot
        )
        for side in SIDES
    }
    # The hull of the soles changes with steps, not with samples.
    thin = slice(None, None, max(1, round(feet.rate_hz / _SUPPORT_HZ)))
    margin = stability_margin(
        centre.position_m[thin],
        centre.velocity_mps[thin],
        {side: part[thin] for side, part in corners.items()},
    )
    time_s = sensors["heel_left"].time_s
    reasons += saturated(recording, mass_kg)
    return ShoeWalk(
        time_s, shoes, feet, mass_kg, centre, time_s[thin], margin, apart_m, source, tuple(reasons), sigma_m
    )


def _combined(
    shoes: Mapping[Side, ShoeKinetics],
    apart_m: float,
    end_apart_m: float | None,
    source: ApartSource,
    is_turning: bool,
) -> tuple[BothFeet, float]:
    """Bring both shoes into one room; on a turning course also say how well that is known."""
    left, right = shoes["left"], shoes["right"]
    if not is_turning:
        return combine_feet(left, right, apart_m, end_width_m=end_apart_m), 0.0
    feet, course = combine_turning_feet(
        left, right, apart_m, end_width_m=end_apart_m, width_sigma_m=_APART_SIGMA_M[source]
    )
    return feet, course.step_sigma_m


def _mounting(recording: Recording, setup: SessionSetup, walk: Walk | None, side: Side) -> Mounting | None:
    """Return how the sensors of a shoe sit, where the walk was followed from its heel sensor."""
    if walk is None or f"heel_{side}" not in setup.placements or not walk.strides[side].count:
        return None
    sensors = recording.sensors
    return shoe_mounting(
        rotation.conjugate(walk.strides[side].q_sensor_foot),
        sensors[f"heel_{side}"],
        sensors[f"forefoot_{side}"],
        sensors.get(f"shank_{side}"),
    )


def _shoe(
    recording: Recording, side: Side, chosen: ShoeParameters, mounting: Mounting | None
) -> ShoeKinetics:
    sensors = recording.sensors
    try:
        return analyse_shoe(
            sensors[f"heel_{side}"],
            sensors[f"forefoot_{side}"],
            sensors.get(f"shank_{side}"),
            chosen,
            q_segment_sensor=mounting,
        )
    except (SetupError, ShapeError) as error:
        raise type(error)(say("shoes.of", side=side, reason=error.message)) from error


def with_shoes(walk: Walk, found: ShoeWalk) -> Walk:
    """Put a walk into the room that the shoes share, and add centre of mass, pressure and margin to its frames.

    Parameters
    ----------
    walk : Walk
        Of the same recording.

    Returns
    -------
    Walk
        Its frames have feet a true distance apart, `BALANCE_POINTS` and `BALANCE_SCALARS`; its events are those of
        the forces.

    Raises
    ------
    SetupError
        If a foot is missing.
    """
    frames = walk.frames
    if set(frames.layout.points) != {"foot_left", "foot_right"}:
        raise SetupError(say("shoes.one_foot"))
    nearest = np.searchsorted(found.time_s, frames.time_s - 0.5 / found.feet.rate_hz)
    rows = np.clip(nearest, 0, len(found.time_s) - 1)
    poses = [found.feet.pose[_side(name)] for name in frames.layout.points]
    soles = [pose.heel_m[rows] - [0.0, 0.0, ShoeGeometry().sensor_height_m] for pose in poses]
    strides = {
        side: _by_force(foot, found.shoes[side].contact, found.time_s) for side, foot in walk.strides.items()
    }
    scalar = frames.scalar.copy()
    for number, name in enumerate(frames.layout.points):
        columns = slice(number * len(SCALARS), (number + 1) * len(SCALARS))
        scalar[:, columns] = event_columns(scalar[:, columns], strides[_side(name)], frames.time_s)
        scalar[:, columns.start] = found.shoes[_side(name)].contact.any[rows]
    going = np.stack(
        [np.interp(frames.time_s, found.support_s, part) for part in found.margin.extrapolated_m.T], axis=1
    )
    unknown = np.stack([~pose.is_known[rows] for pose in poses], axis=1)
    outside = (frames.time_s < found.time_s[0] - 0.5 / found.feet.rate_hz) | (
        frames.time_s > found.time_s[-1] + 0.5 / found.feet.rate_hz
    )
    flags = frames.segment_flags | ((unknown | outside[:, None]) * np.uint8(OrientationFlag.INVALID))
    stated = np.interp(frames.time_s, found.support_s, found.margin.margin_m)
    balance = [found.centre.position_m[rows], found.feet.cop_m[rows], going]
    stated[outside] = np.nan
    for part in balance:
        part[outside] = np.nan
    return replace(
        walk,
        strides=strides,
        summary=summarise(strides),
        steps=_steps(strides, found),
        frames=replace(
            frames,
            layout=replace(
                frames.layout,
                points=(*frames.layout.points, *BALANCE_POINTS),
                scalars=(*frames.layout.scalars, *BALANCE_SCALARS),
            ),
            q_room_segment=np.ascontiguousarray(np.stack([pose.q_room_heel[rows] for pose in poses], axis=1)),
            point_room_m=np.ascontiguousarray(np.stack([*soles, *balance], axis=1)),
            scalar=np.column_stack([scalar, stated]),
            segment_flags=np.asarray(flags, dtype=np.uint8),
            point_sigma_m=_with_unknown(frames.point_sigma_m, len(BALANCE_POINTS)),
        ),
    )


def _with_unknown(sigma_m: Float | None, more: int) -> Float | None:
    """Add points of which no sigma is known."""
    if sigma_m is None:
        return None
    return np.concatenate([sigma_m, np.full((len(sigma_m), more, 3), np.nan)], axis=1)


def _steps(strides: Mapping[Side, Strides], found: ShoeWalk) -> Mapping[str, Measure] | None:
    """Measure steps in the room of both shoes, unless nobody measured how far they are apart."""
    if found.apart_source == "usual" or min(foot.count for foot in strides.values()) < 2:
        return None
    places, times = {}, {}
    for side, foot in strides.items():
        times[side] = foot.footholds.quietest_s
        rows = np.clip(np.searchsorted(found.time_s, times[side]), 0, len(found.time_s) - 1)
        places[side] = found.feet.pose[side].heel_m[rows]
    if found.feet.path_m is not None:
        return steps_on_course(
            strides, places["left"], times["left"], places["right"], times["right"], found.relation_sigma_m
        )
    beside = (places["right"][0] - places["left"][0])[:2]
    return measure_steps(places["left"], times["left"], places["right"], times["right"], beside, strides)


def _by_force(strides: Strides, contact: ShoeContact, time_s: Float) -> Strides:
    """Take contacts and toe-offs from the forces, which feel them where inertial signals guess."""
    landed = _nearest(strides.contact_s, time_s[np.minimum(contact.land, len(time_s) - 1)])
    lifted = _nearest(strides.toe_off_s, time_s[np.minimum(contact.lift, len(time_s) - 1)])
    before = np.concatenate([[np.nan], landed[:-1]])
    known = np.isfinite(strides.duration_s)
    return replace(
        strides,
        contact_s=landed,
        toe_off_s=lifted,
        duration_s=np.where(known, landed - before, np.nan),
        stance_s=np.where(known, lifted - before, np.nan),
        swing_s=np.where(known, landed - lifted, np.nan),
    )


def _nearest(guessed_s: Float, felt_s: Float) -> Float:
    if not len(felt_s):
        return guessed_s
    nearest = felt_s[np.argmin(np.abs(guessed_s[:, None] - felt_s[None]), axis=1)]
    return np.where(np.abs(nearest - guessed_s) < _SAME_EVENT_S, nearest, guessed_s)


def _side(point: str) -> Side:
    return "left" if point.endswith("left") else "right"


def _apart(
    shoes: Mapping[Side, ShoeKinetics], setup: SessionSetup, height_m: float, is_turning: bool
) -> tuple[float, ApartSource, list[str]]:
    """Return how far the feet stand apart at the start, who says so, and what contradicts it."""
    # On a turning course the relation itself wants a distance: what the forces add to a usual one is looked for.
    begin_m = USUAL_APART_M if is_turning else 0.0
    alone, _ = _combined(shoes, begin_m, None, "usual", is_turning)
    stated = None
    with contextlib.suppress(ShapeError, SetupError):
        stated = begin_m + distance_between_feet(
            alone.reaction,
            alone.rate_hz,
            _mass(alone),
            height_m,
            is_walking=_walking(alone.is_standing),
        )
    doubts: list[str] = [EXCHANGED] if stated is not None and stated < EXCHANGED_M else []
    if setup.feet_apart_m is not None:
        return setup.feet_apart_m, "measured", doubts
    if stated is not None and _WIDTH_RANGE_M[0] <= stated <= _WIDTH_RANGE_M[1]:
        return stated, "forces", doubts
    return USUAL_APART_M, "usual", doubts


def _walking(is_standing: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return ~is_standing if not is_standing.all() else np.ones_like(is_standing)


def _mass(feet: BothFeet) -> float:
    if feet.is_standing.any():
        return body_mass(feet.force_n, feet.is_standing)
    # Over whole strides the ground carries the weight and nothing else.
    return float(feet.force_n[:, 2].mean() / GRAVITY_MPS2)
