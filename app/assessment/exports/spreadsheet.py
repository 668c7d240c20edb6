"""Tables of an archive that a spreadsheet opens right: measures by repetition, strides of a walk.

With a byte order mark, or Excel reads letters beyond ASCII wrongly. A spreadsheet takes "1.5" for a date where people
write a decimal comma: who reads the service in German gets commas, and semicolons between cells. Text of people never
begins as a formula does.
"""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from app.assessment.exports.meanings import OF_REPETITION, OF_STRIDE
from app.assessment.schemas import ComparisonDetail, MeasureValue
from app.kinds.walk.schemas import FootStride
from app.recordings.columns import csv_cell

Cell = str | float | int | bool | None

_UNITS: Final = {
    "deg": "_deg",
    "%": "_percent",
    "m/s": "_mps",
    "deg/s": "_degps",
    "1/m": "_per_m",
    "1": "",
    "count": "",
}
_DECIMAL_COMMA: Final = ("de",)


@dataclass(frozen=True)
class Column:
    """One column of a table: its heading, unit and meaning."""

    name: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class Sheet:
    """A table and what its columns mean; a cell that was not measured is empty."""

    columns: Sequence[Column]
    rows: Sequence[Mapping[str, Cell]]


def has_decimal_comma(locale: str) -> bool:
    """Return whether spreadsheets of this language expect 1,5 and semicolons between cells.

    Parameters
    ----------
    locale : str
        Of the account, for example `de`; empty where nobody has chosen one.
    """
    return locale.lower().startswith(_DECIMAL_COMMA)


def csv_bytes(names: Sequence[str], rows: Iterable[Sequence[Cell]], *, decimal_comma: bool) -> bytes:
    """Return a table as UTF-8 with byte order mark, lines that end in CR LF, and text that is no formula.

    Parameters
    ----------
    names : sequence of str
        Headings.
    rows : iterable of sequence of Cell
        Numbers are written with at most nine digits; None and numbers that are not finite as an empty cell.
    decimal_comma : bool
        Decimal commas, and semicolons between cells.
    """
    target = io.StringIO(newline="")
    writer = csv.writer(target, delimiter=";" if decimal_comma else ",", lineterminator="\r\n")
    writer.writerow([csv_cell(name) for name in names])
    for row in rows:
        writer.writerow([_written(cell, decimal_comma) for cell in row])
    return target.getvalue().encode("utf-8-sig")


def _written(cell: Cell, decimal_comma: bool) -> str:
    if cell is None or (isinstance(cell, float) and not abs(cell) < float("inf")):
        return ""
    if isinstance(cell, str):
        return csv_cell(" ".join(cell.split()))
    if isinstance(cell, bool):
        return str(int(cell))
    text = format(cell, ".9g")
    return text.replace(".", ",") if decimal_comma else text


def files_of(name: str, sheet: Sheet, *, decimal_comma: bool) -> dict[str, bytes]:
    """Return `NAME.csv` and its dictionary `NAME-columns.csv` (name, unit, meaning) with their content.

    Parameters
    ----------
    name : str
        With its folder, without ending.
    decimal_comma : bool
        As for `csv_bytes`.
    """
    names = [column.name for column in sheet.columns]
    rows = ([row.get(one) for one in names] for row in sheet.rows)
    said = ((column.name, column.unit, column.meaning) for column in sheet.columns)
    return {
        f"{name}.csv": csv_bytes(names, rows, decimal_comma=decimal_comma),
        f"{name}-columns.csv": csv_bytes(["name", "unit", "meaning"], said, decimal_comma=decimal_comma),
    }


_ABOUT: Final = (
    Column("started_at", "UTC", "when the session began"),
    Column("exercise", "", "name of the exercise"),
    Column("template", "", "template that the session is compared with"),
    Column("repetition", "", "number of the repetition in the session"),
    Column("start_s", "s", "beginning, since the session began"),
    Column("end_s", "s", "end, since the session began"),
    Column("is_kept", "", "1 where the repetition counts in the means, else 0"),
    Column("reason", "", "why it does not count"),
    Column(
        "counted",
        "",
        "how it was counted while it was made: valid, partial or wrong; empty where nobody counted",
    ),
)


def measures_sheet(compared: Sequence[ComparisonDetail], started_at: datetime | None, exercise: str) -> Sheet:
    """Return the measures of a session, a row a repetition; each measure is followed by its uncertainty.

    Parameters
    ----------
    compared : sequence of ComparisonDetail
        Of one session, with each template that it was compared with.
    exercise : str
        Its name; empty for free movement.
    """
    columns = {column.name: column for column in _ABOUT}
    rows: list[Mapping[str, Cell]] = []
    for one in compared:
        for found in one.repetitions:
            repetition = found.repetition
            row: dict[str, Cell] = {
                "started_at": f"{started_at:%Y-%m-%d %H:%M:%S}" if started_at else None,
                "exercise": exercise,
                "template": one.template_name,
                "repetition": repetition.number,
                "start_s": repetition.start_s,
                "end_s": repetition.end_s,
                "is_kept": repetition.is_kept,
                "reason": repetition.reason,
                "counted": repetition.counted,
            }
            for measure in found.measures:
                value, sigma = _columns_of(measure)
                columns.setdefault(value.name, value)
                columns.setdefault(sigma.name, sigma)
                row[value.name], row[sigma.name] = measure.value, measure.uncertainty
            rows.append(row)
    return Sheet(list(columns.values()), rows)


def _columns_of(measure: MeasureValue) -> tuple[Column, Column]:
    family, colon, channel = measure.measure.partition(":")
    unit = "" if measure.unit in ("1", "count") else measure.unit
    # What a channel is called ends in its own unit, which is not that of the value.
    name = f"{family}_{channel.removesuffix('_rad')}" if channel else family
    name += _UNITS.get(measure.unit, f"_{measure.unit}")
    meaning = f"{measure.label}: {OF_REPETITION.get(family + colon, '')}".removesuffix(": ")
    return (
        Column(name, unit, meaning),
        Column(f"{name}_sigma", unit, f"standard deviation of the estimate of {name}"),
    )


def strides_sheet(strides: Sequence[FootStride]) -> Sheet:
    """Return the strides of a walk, a row a stride, in the order of time."""
    columns = [Column("foot", "", "left or right")]
    for name, meaning in OF_STRIDE.items():
        unit = next((unit for unit in ("mps", "rad", "m", "s") if name.endswith(f"_{unit}")), "")
        columns.append(Column(name, unit.replace("mps", "m/s"), meaning))
    rows = [{"foot": one.side, **{name: getattr(one, name) for name in OF_STRIDE}} for one in strides]
    return Sheet(columns, rows)
