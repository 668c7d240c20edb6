"""Three columns each that are one quantity of one sensor, and which of them make whole sensors."""

import re
from collections import defaultdict
from dataclasses import dataclass, field, replace

from app.readers.tables.head import TableHead
from app.readers.tables.names import Named, named, placement_of
from app.readers.tables.rows import Turns
from app.readers.tables.units import Body


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


def triples_of(columns: tuple[str, ...]) -> list[Triple]:
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


def of_kinds(head: TableHead, body: Body, kinds: Turns) -> list[Triple]:
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


def of_devices(triples: list[Triple], turns: Turns) -> list[Triple]:
    """Return the triples once for each device whose rows take turns."""
    # Words that say a place stay: two sensors of one device, or the one that all wear.
    several = len({one.device for one in triples}) > 1 or placement_of(triples[0].device) is not None
    found: list[Triple] = []
    for value in turns.values:
        name = re.sub(r"[^\w .-]+", "_", value).strip("_ .-")[:60] or str(turns.values.index(value) + 1)
        name = f"{turns.column}_{name}".replace(" ", "_") if name.isdigit() else name
        found += [
            replace(
                one,
                device=f"{name}_{one.device}" if several else name,
                rows={**one.rows, turns.column: value},
            )
            for one in triples
        ]
    return found


def whole_sensors(triples: list[Triple]) -> tuple[list[Triple], list[Triple]]:
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
