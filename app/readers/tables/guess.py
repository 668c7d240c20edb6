"""How to read a table, guessed from the names of its columns and its first numbers; a person corrects it.

The upload page asks the service for it, `telemotion process --guess` and `telemotion mapping` use it as it is.
"""

import re
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np

from app.readers.tables.clocks.guess import TimeGuess, guess_time, own_clocks
from app.readers.tables.clocks.mended import spaced, usual_interval
from app.readers.tables.head import TableHead
from app.readers.tables.names import is_orientation, placement_of, side_of
from app.readers.tables.rows import devices_of_pieces, kinds_of_rows, only_device
from app.readers.tables.streams import joined, share_rows
from app.readers.tables.triples import Triple, of_devices, of_kinds, triples_of, whole_sensors
from app.readers.tables.units import (
    Body,
    accelerometer_unit,
    bodies_of,
    gyroscope_unit,
    magnetometer_unit,
)
from estimators.conventions import PLACEMENTS
from estimators.recording import Float
from estimators.sentences import Sentence, say

PipelineName = Literal["arm", "gait", "orientation"]
SINGLE: Final = "imu"
"""What a sensor is called whose table does not name it."""
_DEFAULT: Final = {"gyroscope": "rad/s", "accelerometer": "m/s^2", "magnetometer": "uT"}


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
    name : str
        Of the file without its ending: may say the side of a foot.
    pipeline : str, optional
        What it is for; by default what its sensors are worn for.
    rate_hz : float, optional
        Of the samples, where a person said it.
    """
    notes: list[Sentence] = []
    missing: list[Sentence] = []
    bodies = bodies_of(head)
    body = bodies[0]
    kinds = kinds_of_rows(head, body)
    triples, left_out = whole_sensors(of_kinds(head, body, kinds) if kinds else triples_of(head.columns))
    if left_out:
        notes.append(say("guess.left_out", columns=[column for one in left_out for column in one.columns]))
    if not body.has_rows:
        missing.append(say("table.no_rows"))
    elif not triples:
        missing.append(_why_none(head, left_out))
    signals_of = {column for one in triples for column in one.columns}
    time = guess_time(head, body.of_rows(triples[0].rows) if triples else body, signals_of, rate_hz)
    if triples:
        no_device = {*signals_of, time.column, kinds.column if kinds else None}
        others = [column for column in head.columns if column not in no_device]
        # Where kinds of rows take turns, those of the field may come first; a field shows no device by its jumps.
        first = next(one for one in triples if one.quantity != "magnetometer")
        mine = [one.of_rows(first.rows) for one in bodies]
        of_first = [one for one in triples if (one.device, one.rows) == (first.device, first.rows)]
        measured = tuple(c for one in of_first if one.quantity != "magnetometer" for c in one.columns)
        is_told_apart = len({one.device for one in triples}) > 1
        turns = devices_of_pieces(mine, others, time.column, time.unit, measured, is_told_apart=is_told_apart)
        if turns and turns.is_one:
            notes.append(say("guess.one_device", column=turns.column, values=list(turns.values)))
        elif turns:
            triples = of_devices(triples, turns)
            notes.append(say("guess.devices", column=turns.column, values=list(turns.values)))
            time = guess_time(head, body.of_rows(triples[0].rows), signals_of, rate_hz)
        elif head.later and (only := only_device(mine, others)):
            # Rows of another one, between what was looked at, are none of it.
            triples = [replace(one, rows={**one.rows, **only}) for one in triples]
    if clocks := own_clocks(head, body, [(one.device, one.quantity) for one in triples], signals_of):
        triples = [replace(one, clock=clocks[one.device, one.quantity]) for one in triples]
        time = replace(time, column=triples[0].clock, notes=())
        notes.append(say("guess.own_clocks", columns=sorted(set(clocks.values()))))
    notes += time.notes
    missing += time.missing
    units = _units(bodies, triples, time)
    turning = {u for one, u in zip(triples, units, strict=True) if u and one.quantity == "gyroscope"}
    known = [
        _with_unit(bodies, one, u, turning, notes, missing) for one, u in zip(triples, units, strict=True)
    ]
    triples = [one for one in known if one is not None]
    if len(triples) < len(known):
        # Magnetometers all or none.
        triples = [one for one in triples if one.quantity != "magnetometer"]
    signals, chosen = _placed(triples, name, pipeline, notes, missing)
    mapping = {
        "time_column": time.column,
        "time_unit": time.unit,
        "rate_hz": time.rate_hz,
        "delimiter": head.delimiter,
        "signals": signals,
    }
    return Guess(mapping, chosen, tuple(notes), tuple(missing))


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
    bodies: list[Body],
    one: Triple,
    unit: str,
    turning: set[str],
    notes: list[Sentence],
    missing: list[Sentence],
) -> Triple | None:
    """Return signals with a unit: that of the name, or that of the numbers; a magnetometer in no unit is left out.

    A gyroscope that rests says none: then it has that of all others, `turning`.
    """
    mine = [body.of_rows(one.rows).numbers(*one.columns) for body in bodies]
    whole = np.concatenate([values[np.isfinite(values).all(axis=1)] for values in mine])
    if one.quantity == "magnetometer" and not len(whole):
        notes.append(say("guess.left_out", columns=list(one.columns)))
        return None
    if one.unit:
        return one
    if one.quantity == "accelerometer" and not unit:
        size = float(np.median(np.linalg.norm(whole, axis=1))) if len(whole) else float("nan")
        missing.append(say("guess.no_unit", columns=list(one.columns), size=size))
        return one
    if one.quantity == "magnetometer" and not unit:
        notes.append(say("guess.left_out", columns=list(one.columns)))
        return None
    if unit == "local":
        notes.append(say("guess.field_relative", columns=list(one.columns)))
    elif unit:
        notes.append(say("guess.unit_from_numbers", columns=list(one.columns), unit=unit))
    elif len(turning) == 1:
        (unit,) = turning
        notes.append(say("guess.unit_of_others", columns=list(one.columns), unit=unit))
    else:
        unit = _DEFAULT[one.quantity]
        notes.append(say("guess.unit_assumed", columns=list(one.columns), unit=unit))
    return replace(one, unit=unit)


def _units(bodies: list[Body], triples: list[Triple], time: TimeGuess) -> list[str]:
    """Return the unit of each signal, by its name or its numbers; empty where neither says it.

    Devices whose rows stand under the same headings have one unit. One that turns about the vertical looks as if it
    rested in another: what turns as gravity does decides for all of them.
    """
    units = [one.unit or _unit_of_numbers(bodies, one, triples, time) for one in triples]
    for columns, quantity in {(one.columns, one.quantity) for one in triples if not one.unit}:
        same = [at for at, one in enumerate(triples) if (one.columns, one.quantity) == (columns, quantity)]
        if quantity == "gyroscope" and len({units[at] for at in same}) > 1:
            turned = {
                _unit_of_rows(body, triples[at], triples, time, is_brief=True)
                for at in same
                for body in bodies
            }
            if len(turned - {""}) == 1:
                (unit,) = turned - {""}
                units = [unit if at in same else one for at, one in enumerate(units)]
    return units


def _unit_of_numbers(bodies: list[Body], one: Triple, all_: list[Triple], time: TimeGuess) -> str:
    """Return the unit that the numbers of a signal are in; empty where they do not say it."""
    units = (_unit_of_rows(body, one, all_, time, is_brief=at > 0) for at, body in enumerate(bodies))
    return next((unit for unit in units if unit), "")


def _unit_of_rows(body: Body, one: Triple, all_: list[Triple], time: TimeGuess, *, is_brief: bool) -> str:
    mine = body.of_rows(one.rows)
    values = mine.numbers(*one.columns)
    if one.quantity == "accelerometer":
        return accelerometer_unit(values)
    if one.quantity == "magnetometer":
        return magnetometer_unit(values)
    force = next(o for o in all_ if o.device == one.device and o.quantity == "accelerometer")
    forces = mine.numbers(*force.columns)
    if (force.rows, force.clock) == (one.rows, one.clock) and share_rows(values, forces):
        return gyroscope_unit(values, forces, time.step_s, is_brief=is_brief)
    at_s, values = _in_time(mine, one, time)
    forces = joined(*_in_time(body.of_rows(force.rows), force, time), at_s)
    step_s = usual_interval(at_s) if at_s.size > 1 else None
    return gyroscope_unit(values, forces, step_s, is_brief=is_brief)


def _in_time(body: Body, one: Triple, time: TimeGuess) -> tuple[Float, Float]:
    """Return the rows of a signal in the order of their time, s, and that."""
    column = one.clock or time.column
    at_s = np.arange(float(len(body))) if column is None else body.seconds(column, time.unit, time.rate_hz)
    # Rows of another quantity are none of its own.
    at_s[~np.isfinite(body.numbers(*one.columns)).any(axis=1)] = np.nan
    order = np.argsort(at_s, kind="stable")[: int(np.isfinite(at_s).sum())]
    # Samples that arrived together get times of their own, as when the table is read.
    return spaced(at_s[order])[0], body.numbers(*one.columns)[order]


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
