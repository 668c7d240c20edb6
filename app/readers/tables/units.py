"""Units guessed from the numbers where the names of the columns say none."""

from copy import copy
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.readers.tables.clocks.counter import COUNT, gone_on, unwrapped
from app.readers.tables.clocks.of_day import CLOCK, seconds_of_clock
from app.readers.tables.clocks.stamps import UNIT_FACTORS
from app.readers.tables.head import TableHead, split_line
from app.readers.units import TO_SI, UNITS
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float

_GRAVITY: Final = (0.5 * GRAVITY_MPS2, 2.5 * GRAVITY_MPS2)
"""Median size of specific force; of running feet twice gravity."""
_ABOUT_GRAVITY: Final = (0.8 * GRAVITY_MPS2, 1.3 * GRAVITY_MPS2)
_FIELD_T: Final = (10e-6, 150e-6)
_ABOUT_LOCAL_T: Final = (0.75 * 45e-6, 1.35 * 45e-6)
"""A field of about one of its unit: in gauss it would be twice the earth's."""
_FASTEST_RADPS: Final = 35.0
"""2000 degrees a second: turns beyond it are written in degrees."""
_RESTING_RADPS: Final = 0.06
"""3.4 degrees a second: no gyroscope reads more than this at rest."""
_STILL_SHARE: Final = 0.02
"""Of gravity: a sensor whose specific force moves by less is at rest."""
_TURNED: Final = 0.3
"""So far (rad) must gravity have turned in the sensor before its turning is compared with the gyroscope."""
_FEWEST: Final = 10
_AGREES: Final = (0.4, 2.5)
_ALIKE: Final = 0.6
"""Least correlation of the two turnings."""
_SMOOTHED_S: Final = 0.15
_ROWS: Final = 4000
_LARGEST: Final = 1e100
"""Beyond it a field is no reading of any unit, and its square no number."""


class Body:
    """The first rows of a table, split once.

    Parameters
    ----------
    most_rows : int
        Of them.
    """

    def __init__(self, head: TableHead, most_rows: int = _ROWS) -> None:
        # The last line may be cut.
        lines = head.body[:-1] if len(head.body) > 1 else head.body
        self._rows = [split_line(line, head.delimiter) for line in lines[:most_rows]]
        self._places = {name: place for place, name in enumerate(head.columns)}
        self._at = np.arange(len(self._rows))
        # Of all rows, split and parsed once.
        self._written: dict[str, NDArray[np.object_]] = {}
        self._parsed: dict[str, Float] = {}

    @property
    def has_rows(self) -> bool:
        """Whether there is any row of numbers."""
        return any(np.isfinite(_float(field)) for row in self._rows for field in row)

    def numbers(self, *columns: str) -> Float:
        """Return some columns as numbers, shape (N, C); NaN where there is none."""
        for name in columns:
            if name not in self._parsed:
                found = np.array([_float(field) for field in self._column(name).tolist()], dtype=np.float64)
                found[np.abs(found) > _LARGEST] = np.nan
                self._parsed[name] = found
        return np.stack([self._parsed[name][self._at] for name in columns], axis=1)

    def texts(self, column: str) -> list[str]:
        """Return a column as it is written; empty where a row ends before it."""
        return [str(one) for one in self._column(column)[self._at].tolist()]

    def of_rows(self, rows: dict[str, str]) -> "Body":
        """Return the rows in which columns hold these texts.

        Parameters
        ----------
        rows : dict of str to str
            See `CsvColumn.rows`.
        """
        found = copy(self)
        for name, value in rows.items():
            found._at = found._at[self._column(name)[found._at] == value]
        return found

    def _column(self, name: str) -> NDArray[np.object_]:
        if name not in self._written:
            at = self._places[name]
            texts = [row[at] if at < len(row) else "" for row in self._rows]
            self._written[name] = np.array(texts, dtype=object)
        return self._written[name]

    def __len__(self) -> int:
        return int(self._at.size)

    def seconds(self, column: str, unit: str, rate_hz: float | None = None) -> Float:
        """Return the time of the rows in seconds, shape (N,); a clock that ran over its end goes on.

        Parameters
        ----------
        unit : str
            Of `CsvMapping.time_unit`.
        rate_hz : float, optional
            Of a counter; without it in its counts.
        """
        found = self.times(column, unit)
        rows = np.isfinite(found)
        if unit == COUNT:
            counted = unwrapped(found[rows])[0]
            steps = np.diff(counted)
            usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 1.0
            found[rows] = counted / (usual * rate_hz if rate_hz else 1.0)
        elif unit != CLOCK:
            found[rows] = gone_on(found[rows]) * UNIT_FACTORS[unit]
        return found

    def times(self, column: str, unit: str) -> Float:
        """Return a time column in its unit, shape (N,), times of day in seconds; NaN where there is none."""
        if unit != CLOCK:
            return self.numbers(column)[:, 0]
        return seconds_of_clock(self.texts(column))[0]


def bodies_of(head: TableHead, most_rows: int = _ROWS) -> list[Body]:
    """Return the first rows of a table, and those of each piece of its rest; see `TableHead.later`."""
    return [Body(replace(head, body=lines), most_rows) for lines in (head.body, *head.later)]


def _float(field: str) -> float:
    try:
        return float(field.replace(",", ".") if field.count(",") == 1 else field)
    except ValueError:
        return np.nan


def accelerometer_unit(values: Float) -> str:
    """Return the unit in which gravity is gravity; empty when there is none.

    Parameters
    ----------
    values : ndarray, shape (N, 3)
    """
    unit = _fitting(values, _GRAVITY, ("m/s^2", "g", "mg"))
    # Counts of a converter have any size: thousandths of gravity only where they are about a thousand.
    return unit if unit != "mg" else _fitting(values, _ABOUT_GRAVITY, ("mg",))


def magnetometer_unit(values: Float) -> str:
    """Return the unit in which the field is the earth's; empty when there is none."""
    if _fitting(values, _ABOUT_LOCAL_T, ("local",)):
        return "local"
    return _fitting(values, _FIELD_T, ("uT", "G", "mG", "T", "mT"))


def gyroscope_unit(gyroscope: Float, force: Float, step_s: float | None, *, is_brief: bool = False) -> str:
    """Return the unit in which the gyroscope turns as far as gravity does; empty when nothing tells.

    Parameters
    ----------
    gyroscope, force : ndarray, shape (N, 3)
        As written; the force in any unit.
    step_s : float or None
        Between two rows.
    is_brief : bool
        A moment: a sensor that turns about the vertical looks as one that rests, and one false reading as its fastest.
    """
    turning = np.linalg.norm(gyroscope[np.isfinite(gyroscope).all(axis=1)], axis=1)
    fastest = float(np.percentile(turning, 99.0)) if turning.size >= _FEWEST else 0.0
    if fastest > _FASTEST_RADPS and not is_brief:
        return "deg/s" if fastest * TO_SI["deg/s"] < 2.0 * _FASTEST_RADPS else "mdps"
    rows = np.isfinite(gyroscope).all(axis=1) & np.isfinite(force).all(axis=1)
    gyroscope, force = gyroscope[rows], force[rows]
    size = np.linalg.norm(force, axis=1)
    if len(gyroscope) < _FEWEST or not (size > 0.0).all():
        return ""
    if step_s and (found := _by_turning(gyroscope, force / size[:, None], size, step_s)):
        return found
    if is_brief:
        return ""
    is_still = float(np.std(force, axis=0).max()) < _STILL_SHARE * float(np.median(size))
    return "deg/s" if is_still and float(np.median(turning)) > _RESTING_RADPS else ""


def _by_turning(gyroscope: Float, down: Float, size: Float, step_s: float) -> str:
    """Compare how gravity turns in the sensor with what the gyroscope says: d/dt down = -rate x down."""
    width = max(1, round(_SMOOTHED_S / step_s))
    if len(down) < 4 * width:
        return ""
    kernel = np.ones(width) / width
    smooth = [
        np.stack([np.convolve(values[:, i], kernel, mode="valid") for i in range(3)], axis=1)
        for values in (gyroscope, down)
    ]
    quiet = np.abs(np.convolve(size, kernel, mode="valid") / np.median(size) - 1.0) < 0.15
    seen = np.gradient(smooth[1], step_s, axis=0)[quiet]
    said = -np.cross(smooth[0], smooth[1])[quiet]
    if float(np.linalg.norm(seen, axis=1).sum() * step_s) < _TURNED:
        return ""
    both, squares, seen_squares = (
        float((a * b).sum()) for a, b in ((seen, said), (said, said), (seen, seen))
    )
    if both < _ALIKE * np.sqrt(squares * seen_squares) or not squares:
        # Shaken, not turned.
        return ""
    scale = both / squares
    return next((u for u in UNITS["gyroscope"] if _AGREES[0] < scale / TO_SI[u] < _AGREES[1]), "")


def _fitting(values: Float, bounds: tuple[float, float], order: tuple[str, ...]) -> str:
    sizes = np.linalg.norm(values[np.isfinite(values).all(axis=1)], axis=1)
    median = float(np.median(sizes)) if sizes.size else 0.0
    return next((unit for unit in order if bounds[0] <= median * TO_SI[unit] <= bounds[1]), "")
