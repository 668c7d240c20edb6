"""A template made ready for one patient: offsets from the start posture, weights, targets. Equation (1)."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.comparison import PHASES, Template, Trajectory, mirror_template
from estimators.comparison._template import FLOOR_LIMB_RAD, FLOOR_REACH, FLOOR_TRUNK_RAD, is_angle
from estimators.comparison.channels.mirror import check_side
from estimators.comparison.channels.names import tells_movement
from estimators.comparison.channels.sided import TRUNK_CHANNELS
from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.guidance._channel_kernel import PACE_STEP
from estimators.guidance._contract import GuidanceTemplate
from estimators.guidance._records import Model
from estimators.recording import Float

BINS: Final = 64
SIZES: Final = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2)
"""Sizes that are distinguished, as shares of the template's."""
_BAND_SIGMAS: Final = 1.64
_SHARE_OF_RANGE: Final = 0.05
SLOPE_S: Final = 0.24
"""Over how long in the past a line is laid through what is measured, for its slope: longer than a beat of tremor."""
PACES: Final = tuple(PACE_STEP * number for number in range(1, 5))
"""Of a patient, in the template's, for which slopes are made ready; evenly spaced from the first, which is the step."""
WHOLE_PACE: Final = PACES.index(1.0)
_SLOPE_POINTS: Final = 25
_ENOUGH: Final = 1.0
"""Weight of all angles from which they tell the phase alone."""
_PROMINENCE: Final = 0.3
_LEVEL: Final = 0.02
"""Share of the range within which a hold is level."""
_SINGULAR: Final = ("_yxy_plane_of_elevation", "_yxy_axial_rotation")
_FOLLOWING: Final = ("elbow", "hand_")
"""Points that follow from the wrist and the angles."""


def steers(channel: str) -> bool:
    """Say whether a channel may tell the phase: not singular angles, and nothing that shows compensation."""
    if channel.endswith("_lean_forward_rad"):
        return channel not in TRUNK_CHANNELS
    return tells_movement(channel) or ("." in channel and not channel.startswith(_FOLLOWING))


def prepare_template(
    template: Template,
    side: Side,
    reach_m: float,
    *,
    steering: Sequence[str] | None = None,
) -> GuidanceTemplate:
    """Make a template ready to guide one patient.

    Parameters
    ----------
    template : Template
        One of the other side is mirrored; the band is the one that the therapist drew on it.
    side : {"left", "right"}
        The patient's acting side.
    reach_m : float
        The patient's upper arm plus forearm; positions are scaled from the template's person.
    steering : sequence of str, optional
        Channels that tell the phase, in the template's names. By default angles without a singularity, and the wrist
        where they move too little to tell it; the main channel always does. Compensation should not.

    Raises
    ------
    SetupError
        If the reach is not positive, a channel is unknown, or no channel moves enough to tell the phase.

    Notes
    -----
    Weight of a channel: w_c = clip((range / floor - 1) / 3, 0, 1), floors as of the band of `build_template`.

    Angles of a smaller movement are those of the template, smaller. The wrist of a smaller movement is on another arc:
    at its turn it is where it is half-way through the whole movement, which the filter, whose sizes scale each channel,
    takes it for. So it does not steer where angles can.
    """
    check_side(side)
    if not reach_m > 0:
        raise SetupError(f"the reach is {reach_m} m; give upper arm plus forearm, for instance 0.55")
    chosen = [name for name in template.channels if steers(name)] if steering is None else list(steering)
    if set(chosen) - set(template.channels):
        raise SetupError(f"steering {chosen}; the template has {template.channels}")
    chosen.append(template.primary_channel)
    is_chosen = [name in chosen for name in template.channels]
    if template.side != side:
        template = mirror_template(template)
    scale = np.array([reach_m / template.reach_m if "." in name else 1.0 for name in template.channels])
    mean, width = template.mean * scale, template.tolerance * scale
    absolute = np.array([name.endswith(_SINGULAR) for name in template.channels])
    turns = np.array([is_angle(name) for name in template.channels])
    offset = mean - np.where(absolute, 0.0, mean[0])
    extent = np.max(offset, axis=0, initial=-np.inf) - np.min(offset, axis=0, initial=np.inf)
    floor = np.array([_floor(name, reach_m) for name in template.channels])
    weight = np.clip((extent / floor - 1.0) / 3.0, 0.0, 1.0)
    tells = is_chosen & np.isfinite(mean).all(axis=0) & (weight > 0.0)
    if steering is None:
        tells = _without_points(tells, turns, weight, template)
    columns = np.flatnonzero(tells)
    if not len(columns):
        raise SetupError(f"no channel of {template.channels} moves enough to tell the phase")
    main = template.channels.index(template.primary_channel)
    phase, height = _targets(offset[:, main])
    variance = (width / _BAND_SIGMAS) ** 2 + (_SHARE_OF_RANGE * extent) ** 2
    model = Model(
        offset=_by_channel(offset, columns),
        slope=np.stack([_trailing_slope(offset[:, columns], template.duration_s / pace) for pace in PACES]),
        variance=_by_channel(variance, columns),
        weight=np.ascontiguousarray(weight[columns]),
        steering=columns.astype(np.int64),
        excursion=np.ascontiguousarray(np.abs(offset[:, columns]).max(axis=0)),
        whole=_binned(offset),
        turns=turns.astype(np.uint8),
        absolute=absolute.astype(np.uint8),
        sizes=np.array(SIZES),
        target=np.stack([phase, height], axis=1),
    )
    return GuidanceTemplate(
        channels=template.channels,
        side=side,
        main=template.primary_channel,
        steering=tuple(template.channels[c] for c in columns),
        duration_s=template.duration_s,
        mean=mean,
        below=template.below * scale,
        above=template.above * scale,
        target_phase=phase,
        target_offset=height,
        model=model,
    )


def _without_points(
    tells: NDArray[np.bool_], turns: NDArray[np.bool_], weight: Float, template: Template
) -> NDArray[np.bool_]:
    """Leave out what is no angle where angles tell the phase alone; the main channel stays."""
    if weight[tells & turns].sum() < _ENOUGH:
        return tells
    is_main = np.array([name == template.primary_channel for name in template.channels])
    return np.asarray(tells & (turns | is_main))


def _binned(curves: Float) -> Float:
    """Curves of 101 phases at the middles of the bins, shape (B, C)."""
    middle = (np.arange(BINS) + 0.5) / BINS
    at = np.linspace(0.0, 1.0, PHASES)
    return np.ascontiguousarray(np.stack([np.interp(middle, at, c) for c in curves.T], axis=1))


def _by_channel(curves: Float, columns: NDArray[np.intp]) -> Float:
    return np.ascontiguousarray(_binned(curves[:, columns]).T)


def _trailing_slope(curves: Float, duration_s: float) -> Float:
    """Slopes per phase at the middles of the bins, shape (C, B), of lines through the past `SLOPE_S` of a cycle.

    What is measured has its slope over the past, half of that late; held against the slope at the phase itself it would
    draw the phase on where a movement slows down, and back where one begins.
    """
    middle = (np.arange(BINS) + 0.5) / BINS
    before = np.linspace(0.0, SLOPE_S / duration_s, _SLOPE_POINTS)
    at = np.linspace(0.0, 1.0, PHASES)
    past = np.stack([np.interp(middle[:, None] - before, at, curve) for curve in curves.T])
    lever = np.mean(before) - before
    return np.ascontiguousarray(past @ lever / np.sum(lever**2))


def _floor(channel: str, reach_m: float) -> float:
    if "." in channel or channel.endswith("_m"):
        return FLOOR_REACH * reach_m
    return FLOOR_TRUNK_RAD if channel in TRUNK_CHANNELS else FLOOR_LIMB_RAD


def _targets(main: Float) -> tuple[Float, Float]:
    """Phases and offsets of the extremes of the main channel that stand out by 30 % of its range."""
    least = _PROMINENCE * float(np.ptp(main))
    if not least > 0:
        raise SetupError("the main channel of the template does not move or has gaps")
    # Beyond both ends the movement is at rest: an extreme at the very end is none.
    padded = np.concatenate([[main[0]], main, [main[-1]]])
    found = sorted(
        int(place) - 1
        for sign in (1.0, -1.0)
        for place in scipy.signal.find_peaks(sign * padded, prominence=least)[0]
    )
    reached = [place for place in found if abs(main[place]) >= least]
    if not reached:
        reached = [int(np.argmax(np.abs(main)))]
    phases = [_middle(np.abs(main - main[place]) <= _LEVEL * np.ptp(main), place) for place in reached]
    return np.array(phases) / (PHASES - 1.0), main[reached]


def _middle(is_level: NDArray[np.bool_], place: int) -> float:
    """Return the middle of the stretch around a place: noise alone says where a hold is highest."""
    first, last = place, place
    while first > 0 and is_level[first - 1]:
        first -= 1
    while last < len(is_level) - 1 and is_level[last + 1]:
        last += 1
    return 0.5 * (first + last)


def is_place(channel: str) -> bool:
    """Say whether a channel is a coordinate of a point, measured from the shoulder."""
    return "." in channel


def shoulder_of(channel: str) -> str:
    """Return the same coordinate of the shoulder of a point's side."""
    point, _, axis = channel.partition(".")
    return f"shoulder_{point.rpartition('_')[2]}.{axis}"


def signals(source: Trajectory, ready: GuidanceTemplate) -> tuple[Float, Float]:
    """Pick what `Guide.feed` takes out of a session or a piece of one.

    Returns
    -------
    values, sigma : ndarray, shape (N, C)
        In the order of the template's channels: rad, and m relative to the shoulder. NaN where nothing was measured;
        of sigma also where it is not known.
    """
    index = {name: column for column, name in enumerate(source.channels)}
    values = np.full((len(source.time_s), len(ready.channels)), np.nan)
    sigma = np.full_like(values, np.nan)
    for column, name in enumerate(ready.channels):
        is_point = is_place(name)
        origin = shoulder_of(name) if is_point else name
        if name not in index or origin not in index:
            continue
        at, of = index[name], index[origin]
        known = source.valid[:, at] & source.valid[:, of]
        placed = source.values[:, at] - (source.values[:, of] if is_point else 0.0)
        values[:, column] = np.where(known, placed, np.nan)
        if not is_point:
            sigma[:, column] = np.where(known, source.sigma[:, at], np.nan)
    return values, sigma
