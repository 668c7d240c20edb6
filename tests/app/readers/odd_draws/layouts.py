"""How drawn tables lay out their sensors: side by side, in rows that take turns, with clocks of their own."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tests.app.readers.odd_draws.clocks import Written, written
from tests.app.readers.odd_draws.motion import Sensor, Signals
from tests.app.readers.odd_draws.names import QUANTITIES, UNITS, Style

Random = np.random.Generator


@dataclass
class Table:
    """Names of columns, and rows of texts.

    Attributes
    ----------
    heads : list of list of str
        Lines of the header.
    rows : list of list of str
    needs_rate : bool
    """

    heads: list[list[str]] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)
    needs_rate: bool = False


def _texts(signals: Signals, quantity: str, style: Style, sign: float, order: str) -> list[list[str]]:
    """Return the samples as they are written, one list of three texts each; of those lost too."""
    factor = UNITS[quantity][style.units[QUANTITIES.index(quantity)]][0]
    factor *= sign if quantity == "accelerometer" else 1.0
    places = ["xyz".index(axis) for axis in order]
    return [[f"{value:.6g}" for value in row] for row in (factor * signals.values[:, places]).tolist()]


def _order(rng: Random) -> str:
    return ("xyz", "xyz", "zyx")[rng.integers(3)]


def _units_line(style: Style, columns: list[tuple[str, str]]) -> list[list[str]]:
    """Return the line of units below the names, where the style has one; `columns`: quantity (or empty) of each."""
    if style.place != "line":
        return []
    return [[style.spelt[QUANTITIES.index(quantity)] if quantity else "" for _, quantity in columns]]


def _mixed(rng: Random, names: list[str]) -> list[str]:
    return [names[at] for at in rng.permutation(len(names))] if rng.random() < 0.4 else names


def wide(rng: Random, sensors: list[Sensor], rate_hz: float, clock: str, style: Style, sign: float) -> Table:
    """Sensors side by side on one clock."""
    first = sensors[0].signals["gyroscope"]
    # Cells are empty where everything else of the row is there.
    is_empty = sum(int((~first.there).sum()) for _ in (0,)) and rng.random() < 0.3
    rows = np.arange(first.time_s.size) if is_empty else np.flatnonzero(first.there)
    time = written(clock, rng, first.time_s[rows], rate_hz, rows)
    order, where, between = (
        _order(rng),
        ("before", "behind")[rng.integers(2)],
        ("_", " ", ".")[rng.integers(3)],
    )
    quantities = _mixed(rng, list(sensors[0].signals))
    names: list[tuple[str, str]] = [(name, "") for name in time.columns]
    parts: list[list[list[str]]] = []
    is_grouped = len(sensors) > 1 and rng.random() < 0.25
    groups = ["" for _ in names]
    for sensor in sensors:
        device = "" if len(sensors) == 1 or is_grouped else sensor.name
        for quantity in quantities:
            names += [(style.name(quantity, axis, device, where, between), quantity) for axis in order]
            groups += [sensor.name] * 3
            parts.append(_texts(sensor.signals[quantity], quantity, style, sign, order))
    stamps = list(time.columns.values())
    body = [
        [*(column[place] for column in stamps)]
        + [text if first.there[k] else "" for part in parts for text in part[k]]
        for place, k in enumerate(rows.tolist())
    ]
    heads = [[name for name, _ in names], *_units_line(style, names)]
    return Table([groups, *heads] if is_grouped else heads, body, time.needs_rate)


def devices(
    rng: Random, sensors: list[Sensor], rate_hz: float, clock: str, style: Style, sign: float
) -> Table:
    """Rows of several devices in turn, which a column names."""
    order = _order(rng)
    column = ("device", "DeviceName", "sensor", "sensor_id", "MAC", "node")[rng.integers(6)]
    called = _called(rng, sensors)
    shift_s = float(rng.uniform(0.0, 0.9)) / rate_hz / len(sensors) if rng.random() < 0.5 else 0.0
    quantities = list(sensors[0].signals)
    entries = []
    for place, sensor in enumerate(sensors):
        for signals in sensor.signals.values():
            signals.time_s = signals.time_s + place * shift_s
        first = sensor.signals["gyroscope"]
        parts = [_texts(sensor.signals[q], q, style, sign, order) for q in quantities]
        entries += [
            (float(first.time_s[k]), place, k, called[place], [text for part in parts for text in part[k]])
            for k in np.flatnonzero(first.there).tolist()
        ]
    is_block = rng.random() < 0.15
    entries.sort(key=(lambda one: (one[1], one[0])) if is_block else (lambda one: (one[0], one[1])))
    # Devices may count from numbers of their own.
    own = int(rng.integers(30, 60)) if "counter" in clock and not is_block and rng.random() < 0.3 else 0
    time = _of_entries(rng, clock, rate_hz, [(one[0], one[2] + own * one[1]) for one in entries])
    names = [(name, "") for name in time.columns] + [(column, "")]
    names += [(style.name(q, axis), q) for q in quantities for axis in order]
    rows = [
        [*(texts[at] for texts in time.columns.values()), one[3], *one[4]] for at, one in enumerate(entries)
    ]
    return Table([[name for name, _ in names], *_units_line(style, names)], rows, time.needs_rate)


def kinds(rng: Random, sensors: list[Sensor], rate_hz: float, clock: str, style: Style, sign: float) -> Table:
    """Rows of several quantities in turn, of one device or of several."""
    order = _order(rng)
    said = (
        ("gyroscope", "accelerometer", "magnetometer"),
        ("GYRO", "ACC", "MAG"),
        ("android.sensor.gyroscope", "android.sensor.accelerometer", "android.sensor.magnetic_field"),
        ("Gyroscope", "TotalAcceleration", "Magnetometer"),
    )[rng.integers(4)]
    called = _called(rng, sensors) if len(sensors) > 1 else [""]
    entries = []
    for place, sensor in enumerate(sensors):
        for number, (quantity, signals) in enumerate(sensor.signals.items()):
            texts = _texts(signals, quantity, style, sign, order)
            entries += [
                (float(signals.time_s[k]), place, number, k, said[QUANTITIES.index(quantity)], texts[k])
                for k in np.flatnonzero(signals.there).tolist()
            ]
    entries.sort(key=lambda one: one[:3])
    time = _of_entries(rng, clock, rate_hz, [(one[0], one[3]) for one in entries])
    head = [*time.columns, *(["device"] if len(sensors) > 1 else []), "sensor", *order]
    rows = [
        [
            *(texts[at] for texts in time.columns.values()),
            *([called[one[1]]] if len(sensors) > 1 else []),
            one[4],
            *one[5],
        ]
        for at, one in enumerate(entries)
    ]
    return Table([head], rows, time.needs_rate)


def own_clocks(
    rng: Random, sensors: list[Sensor], rate_hz: float, clock: str, style: Style, sign: float
) -> Table:
    """Sensors side by side, each with its own clock and begin."""
    order, start_s = _order(rng), float(rng.uniform(0.0, 500.0))
    head: list[tuple[str, str]] = []
    columns: list[list[str]] = []
    for sensor in sensors:
        first = sensor.signals["gyroscope"]
        rows = np.flatnonzero(first.there)
        head.append((f"{sensor.name}_{_STAMPED[clock][0]}", ""))
        columns.append(_stamps(clock, first.time_s[rows] + start_s))
        for quantity, signals in sensor.signals.items():
            texts = _texts(signals, quantity, style, sign, order)
            head += [(style.name(quantity, axis, sensor.name), quantity) for axis in order]
            columns += [[texts[k][at] for k in rows.tolist()] for at in range(3)]
    return _side_by_side(style, head, columns)


def own_clocks_of_quantities(
    rng: Random, sensors: list[Sensor], rate_hz: float, clock: str, style: Style, sign: float
) -> Table:
    """One sensor whose quantities have clocks of their own."""
    order, start_s = _order(rng), float(rng.uniform(0.0, 500.0))
    head: list[tuple[str, str]] = []
    columns: list[list[str]] = []
    for quantity, signals in sensors[0].signals.items():
        rows = np.flatnonzero(signals.there)
        word = style.words[QUANTITIES.index(quantity)]
        word = word if len(word) > 1 else quantity[:3]
        head.append((f"{word}_{_STAMPED[clock][0]}", ""))
        columns.append(_stamps(clock, signals.time_s[rows] + start_s))
        texts = _texts(signals, quantity, style, sign, order)
        head += [(style.name(quantity, axis), quantity) for axis in order]
        columns += [[texts[k][at] for k in rows.tolist()] for at in range(3)]
    return _side_by_side(style, head, columns)


def tall(rng: Random, sensors: list[Sensor], rate_hz: float, clock: str, style: Style, sign: float) -> Table:
    """One value a row: of which signal it is stands in one column, or in one each for device, quantity and axis."""
    order = _order(rng)
    is_one_name, has_unit = rng.random() < 0.6, style.place == "line" or rng.random() < 0.3
    device = ("device", "sensor_id", "node", "placement")[rng.integers(4)]
    entries = []
    for place, sensor in enumerate(sensors):
        for number, (quantity, signals) in enumerate(sensor.signals.items()):
            texts = _texts(signals, quantity, style, sign, order)
            for at, axis in enumerate(order):
                called = sensor.name if len(sensors) > 1 else ""
                said = [style.name(quantity, axis, called)]
                if not is_one_name:
                    said = [*([called] if called else []), style.words[QUANTITIES.index(quantity)], axis]
                    said[-2:] = [quantity if len(said[-2]) == 1 else said[-2], axis]
                said += [style.spelt[QUANTITIES.index(quantity)]] if has_unit else []
                entries += [
                    (float(signals.time_s[k]), place, number, at, k, said, texts[k][at])
                    for k in np.flatnonzero(signals.there).tolist()
                ]
    is_block = len(sensors) == 1 and clock in ("seconds", "milliseconds") and rng.random() < 0.2
    entries.sort(key=lambda one: (one[2:4], one[0]) if is_block else one[:4])
    time = _of_entries(rng, clock, rate_hz, [(one[0], one[4]) for one in entries])
    names = [("channel", "signal", "variable", "name")[rng.integers(4)]]
    if not is_one_name:
        names = [*([device] if len(sensors) > 1 else []), "quantity", "axis"]
    value = ("value", "Value", "reading", "Wert", "val")[rng.integers(5)]
    rows = [
        [*(column[at] for column in time.columns.values()), *one[5], one[6]] for at, one in enumerate(entries)
    ]
    return Table([[*time.columns, *names, *(["unit"] if has_unit else []), value]], rows, time.needs_rate)


_STAMPED = {
    "seconds": ("time", 1.0, 5),
    "milliseconds": ("time_ms", 1e3, 2),
    "microseconds": ("timestamp_us", 1e6, 0),
}


def _stamps(clock: str, time_s: np.ndarray) -> list[str]:
    _, factor, digits = _STAMPED[clock]
    return [f"{factor * t:.{digits}f}" for t in time_s]


def _side_by_side(style: Style, head: list[tuple[str, str]], columns: list[list[str]]) -> Table:
    count = max(map(len, columns))
    columns = [[*column, *[""] * (count - len(column))] for column in columns]
    rows = [list(row) for row in zip(*columns, strict=True)]
    return Table([[name for name, _ in head], *_units_line(style, head)], rows)


def _called(rng: Random, sensors: list[Sensor]) -> list[str]:
    if rng.random() < 0.3:
        return [f"d4:22:cd:00:{at:02x}:9{at}" for at in range(len(sensors))]
    if rng.random() < 0.3:
        return [str(17 + 3 * at) for at in range(len(sensors))]
    return [sensor.name for sensor in sensors]


def _of_entries(rng: Random, clock: str, rate_hz: float, entries: list[tuple[float, int]]) -> Written:
    time_s, number = (np.array(one) for one in zip(*entries, strict=True))
    return written(clock, rng, time_s, rate_hz, number.astype(np.int64))


LAYOUTS: dict[str, Callable[..., Table]] = {
    "one sensor": wide,
    "several sensors": wide,
    "rows of devices": devices,
    "rows of kinds": kinds,
    "rows of devices and kinds": kinds,
    "one value a row": tall,
    "one value a row, several sensors": tall,
    "own clocks": own_clocks,
    "own clocks of quantities": own_clocks_of_quantities,
}
