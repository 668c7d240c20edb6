"""How to read a table, guessed from the names of its columns and its first numbers; a person corrects it.

The upload page asks the service for it, `telemotion process --guess` and `telemotion mapping` use it as it is.
"""

import re
from collections import defaultdict
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal

import numpy as np

from app.readers.tables.clocks.guess import guess_time, own_clocks
from app.readers.tables.head import TableHead
from app.readers.tables.names import (
    Named,
    is_orientation,
    named,
    placement_of,
    side_of,
)
from app.readers.tables.rows import Turns, devices_of_rows, kinds_of_rows
from app.readers.tables.units import Body, accelerometer_unit, gyroscope_unit, magnetometer_unit
from app.sentences import Sentence, say
from estimators.conventions import PLACEMENTS

PipelineName = Literal["arm", "gait", "orientation"]
SINGLE: Final = "imu"
"""What a sensor is called whose table does not name it."""
_DEFAULT: Final = {"gyroscope": "rad/s", "accelerometer": "m/s^2", "magnetometer": "uT"}


@dataclass(frozen=True)
class Triple:
    """Three columns of one quantity of one sensor; x, y, z."""

    columns: tuple[str, str, str]
    quantity: str
    device: str
    unit: str
    has_gravity: bool
    rows: dict[str, str] = field(default_factory=dict)
    """Which rows hold it; see `CsvColumn.rows`."""
    clock: str | None = None
    """Its own time column."""


@dataclass(frozen=True)
class Guess:
    """A mapping as far as the table says it.

    Attributes
    ----------
    mapping : dict
        Fields of `CsvMapping`; of a signal whose place on the body nobody has said yet `placement` is None.
    pipeline : str
        What the recording seems to be for, or what was asked for.
    notes : tuple of Sentence
        What was assumed or left out.
    missing : tuple of Sentence
        What a person must add before the table can be read; empty when nothing is.
    """

    mapping: dict[str, Any]
    pipeline: PipelineName
    notes: tuple[Sentence, ...] = ()
    missing: tuple[Sentence, ...] = ()


def guess_of_head(
    head: TableHead, name: str = "", pipeline: PipelineName | None = None, rate_hz: float | None = None
) -> Guess:
    """Guess the mapping of a table.

    Parameters
    ----------
    head : TableHead
    name : str
        Of the file without its ending: may say the side of a foot.
    pipeline : str, optional
        What it is for; by default what its sensors are worn for.
    rate_hz : float, optional
        Of the samples, where a person said it.
    """
    notes: list[Sentence] = []
    missing: list[Sentence] = []
    body = Body(head)
    kinds = kinds_of_rows(head, body)
    triples, left_out = _sensors(_of_kinds(head, body, kinds) if kinds else _triples(head.columns))
    if left_out:
        notes.append(say("guess.left_out", columns=[column for one in left_out for column in one.columns]))
    if not body.has_rows:
        missing.append(say("table.no_rows"))
    elif not triples:
        missing.append(_why_none(head, left_out))
    signals_of = {column for one in triples for column in one.columns}
    time = guess_time(head, body.of_rows(triples[0].rows) if triples else body, signals_of, rate_hz)
    if not kinds and triples:
        others = [c for c in head.columns if c not in signals_of and c != time.column]
        if turns := devices_of_rows(body, others, time.column, time.unit, triples[0].columns):
            triples = _of_devices(triples, turns)
            notes.append(say("guess.devices", column=turns.column, values=list(turns.values)))
            time = guess_time(head, body.of_rows(triples[0].rows), signals_of, rate_hz)
    if clocks := own_clocks(head, body, [(one.device, one.quantity) for one in triples], signals_of):
        triples = [replace(one, clock=clocks[one.device, one.quantity]) for one in triples]
        time = replace(time, column=triples[0].clock, notes=())
        notes.append(say("guess.own_clocks", columns=sorted(set(clocks.values()))))
    notes += time.notes
    missing += time.missing
    known = [_with_unit(body, one, triples, time.step_s, notes, missing) for one in triples]
    triples = [one for one in known if one is not None]
    signals, chosen = _placed(triples, name, pipeline, notes, missing)
    mapping = {
        "time_column": time.column,
        "time_unit": time.unit,
        "rate_hz": time.rate_hz,
        "delimiter": head.delimiter,
        "signals": signals,
    }
    return Guess(mapping, chosen, tuple(notes), tuple(missing))


def _triples(columns: tuple[str, ...]) -> list[Triple]:
    """Group columns whose names differ in the axis only."""
    plain = [named(column) for column in columns]
    said = {one.quantity for one in plain if one is not None}
    for place, column in enumerate(columns):
        # A letter alone is what no word of the table is: `ax` beside `magx`.
        found = named(column, letters=True)
        if found is not None and found.quantity not in said:
            plain[place] = found
    groups: dict[tuple[str, ...], dict[str, tuple[str, Named]]] = defaultdict(dict)
    for column, one in zip(columns, plain, strict=True):
        if one is not None and one.quantity:
            groups[one.stem].setdefault(one.axis, (column, one))
    return [
        Triple(
            (axes["x"][0], axes["y"][0], axes["z"][0]),
            axes["x"][1].quantity,
            axes["x"][1].device,
            axes["x"][1].unit,
            axes["x"][1].has_gravity,
        )
        for axes in groups.values()
        if len(axes) == 3
    ]


def _of_kinds(head: TableHead, body: Body, kinds: Turns) -> list[Triple]:
    """Return a triple for each kind of rows; all stand in the same three columns."""
    plain = [(column, named(column, letters=True)) for column in head.columns]
    axes: dict[tuple[str, ...], dict[str, str]] = defaultdict(dict)
    for column, one in plain:
        if one is not None:
            axes[one.stem].setdefault(one.axis, column)
    whole = next((found for found in axes.values() if len(found) == 3), None)
    if whole is None:
        return []
    columns = (whole["x"], whole["y"], whole["z"])
    return [
        Triple(columns, quantity, "", "", True, {kinds.column: value})
        for value, quantity in kinds.quantities.items()
    ]


def _of_devices(triples: list[Triple], turns: Turns) -> list[Triple]:
    """Return the triples once for each device whose rows take turns."""
    # Words that say a place stay: two sensors of one device, or the one that all wear.
    several = len({one.device for one in triples}) > 1 or placement_of(triples[0].device) is not None
    found: list[Triple] = []
    for value in turns.values:
        name = re.sub(r"[^\w .-]+", "_", value).strip("_ .-")[:60] or str(turns.values.index(value) + 1)
        name = f"{turns.column}_{name}".replace(" ", "_") if name.isdigit() else name
        found += [
            replace(one, device=f"{name}_{one.device}" if several else name, rows={turns.column: value})
            for one in triples
        ]
    return found


def _sensors(triples: list[Triple]) -> tuple[list[Triple], list[Triple]]:
    """Return the signals of whole sensors, one a quantity, and those that are left out."""
    with_gravity = [one for one in triples if one.has_gravity or one.quantity != "accelerometer"]
    first: dict[tuple[str, str], Triple] = {}
    for one in with_gravity:
        first.setdefault((one.device, one.quantity), one)
    by_quantity: dict[str, list[Triple]] = defaultdict(list)
    for one in first.values():
        by_quantity[one.quantity].append(one)
    gyroscopes = {one.device for one in by_quantity["gyroscope"]}
    whole = gyroscopes & {one.device for one in by_quantity["accelerometer"]}
    if len(whole) <= 1 and all(len(found) == 1 for found in by_quantity.values()):
        # One of each, whatever they are called: one sensor.
        device = next(iter(whole), next(iter(gyroscopes), ""))
        chosen = [replace(one, device=device) for one in first.values()] if len(by_quantity) > 1 else []
        if not {"gyroscope", "accelerometer"} <= {one.quantity for one in chosen}:
            chosen = []
    else:
        chosen = [one for one in first.values() if one.device in whole]
    fields = {one.device for one in chosen if one.quantity == "magnetometer"}
    if fields != {one.device for one in chosen}:
        # Magnetometers all or none.
        chosen = [one for one in chosen if one.quantity != "magnetometer"]
    used = {one.columns for one in chosen}
    return chosen, [one for one in triples if one.columns not in used]


def _why_none(head: TableHead, left_out: list[Triple]) -> Sentence:
    """Return why no sensor was found."""
    if all(re.fullmatch(r"column [0-9]+", column) for column in head.columns):
        return say("guess.no_names")
    if any(not one.has_gravity for one in left_out):
        return say(
            "guess.no_gravity", columns=[c for one in left_out if not one.has_gravity for c in one.columns]
        )
    if left_out:
        return say("guess.not_whole")
    orientation = [column for column in head.columns if is_orientation(column)]
    if orientation:
        return say("guess.orientation_only", columns=orientation[:9])
    return say("guess.no_signal")


def _with_unit(
    body: Body,
    one: Triple,
    all_: list[Triple],
    step_s: float | None,
    notes: list[Sentence],
    missing: list[Sentence],
) -> Triple | None:
    """Return signals with a unit: that of the name, or that of the numbers; a magnetometer in no unit is left out."""
    if one.unit:
        return one
    mine = body.of_rows(one.rows)
    values = mine.numbers(*one.columns)
    if one.quantity == "accelerometer":
        unit = accelerometer_unit(values)
        if not unit:
            whole = values[np.isfinite(values).all(axis=1)]
            size = float(np.median(np.linalg.norm(whole, axis=1))) if len(whole) else float("nan")
            missing.append(say("guess.no_unit", columns=list(one.columns), size=size))
            return one
    elif one.quantity == "magnetometer":
        unit = magnetometer_unit(values)
        if not unit:
            notes.append(say("guess.left_out", columns=list(one.columns)))
            return None
    else:
        force = next(o for o in all_ if o.device == one.device and o.quantity == "accelerometer")
        if force.rows == one.rows:
            unit = gyroscope_unit(values, mine.numbers(*force.columns), step_s)
        else:
            # In rows of its own: nothing of it was measured with this.
            unit = gyroscope_unit(values, np.full_like(values, np.nan), None)
    if unit:
        notes.append(say("guess.unit_from_numbers", columns=list(one.columns), unit=unit))
        return replace(one, unit=unit)
    notes.append(say("guess.unit_assumed", columns=list(one.columns), unit=_DEFAULT[one.quantity]))
    return replace(one, unit=_DEFAULT[one.quantity])


def _placed(
    triples: list[Triple],
    name: str,
    pipeline: PipelineName | None,
    notes: list[Sentence],
    missing: list[Sentence],
) -> tuple[list[dict[str, Any]], PipelineName]:
    """Return the signals with the place or the name of their sensor, and what they are for."""
    devices = list(dict.fromkeys(one.device for one in triples))
    places = {device: placement_of(device) for device in devices}
    chosen = pipeline or pipeline_for([place or "" for place in places.values()])
    if chosen == "gait":
        for device in devices:
            if places[device] is None:
                side = side_of(device) or (side_of(name) if len(devices) == 1 else None)
                if side is None and len(devices) == 1:
                    side = "right"
                    notes.append(say("guess.foot_side"))
                places[device] = f"foot_{side}" if side else None
    signals = [
        {
            "placement": places[one.device],
            "sensor": one.device or SINGLE,
            "quantity": one.quantity,
            "columns": list(one.columns),
            "unit": one.unit,
            **({"rows": one.rows} if one.rows else {}),
            **({"time_column": one.clock} if one.clock else {}),
        }
        for one in triples
    ]
    without = [column for one in triples if places[one.device] is None for column in one.columns]
    if without and chosen != "orientation":
        missing.append(say("guess.no_place", columns=without))
    return signals, chosen


def pipeline_for(placements: list[str]) -> PipelineName:
    """Return what sensors at these places are worn for: feet alone to walk, anywhere on the body for its joints.

    Parameters
    ----------
    placements : list of str
        Names that are no `Placement` are worn nowhere in particular: single sensors.
    """
    worn = [place for place in placements if place in PLACEMENTS or place.startswith(("heel_", "forefoot_"))]
    if not worn:
        return "orientation"
    is_walk = all(place.startswith(("foot_", "heel_", "forefoot_", "shank_", "pelvis")) for place in worn)
    return "gait" if is_walk and any(place.startswith(("foot_", "heel_")) for place in worn) else "arm"


__all__ = ["SINGLE", "Guess", "PipelineName", "guess_of_head", "pipeline_for"]
