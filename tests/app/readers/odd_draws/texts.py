"""How drawn tables are written down: comments, foreign lines, heads that stand again, commas and encodings."""

import re

import numpy as np

from tests.app.readers.odd_draws.layouts import Table

Random = np.random.Generator
_MISLEADING = (
    "# notch filter: 60 Hz",
    "# low pass 40 Hz",
    "# screen refresh rate 90 Hz",
    "Heart rate: 72",
    "DLPF: 42 Hz",
    "# mains 50 Hz",
    "Range: 2000 dps, bandwidth 188 Hz",
)
_HARMLESS = (
    "# subject 7",
    "Device: Sensor 7",
    "Comment: slow, then fast",
    "// firmware 1.4.2",
    "# exported 2026-11-22",
)
_MORE = {
    "temperature": lambda k: f"{24.0 + 0.001 * k:.2f}",
    "battery": lambda k: str(90 - k // 300),
    "button": lambda k: str(k // 70 % 2),
    "activity": lambda k: ("rest", "reach", "back")[k // 90 % 3],
    "pressure": lambda k: f"{1013.2 + 0.01 * (k % 7):.2f}",
    "roll": lambda k: f"{k % 360 - 180}",
}


def as_bytes(rng: Random, table: Table, said_hz: float | None) -> tuple[bytes, dict[str, str]]:
    """Return a table as a file, and which kinds of text were drawn.

    Parameters
    ----------
    rng : Generator
    table : Table
    said_hz : float or None
        A rate that a line above it says.
    """
    delimiter, decimal = (
        (",", "."),
        (",", "."),
        (";", "."),
        (";", ","),
        ("\t", "."),
        ("\t", ","),
        ("|", "."),
    )[rng.integers(7)]
    heads, rows = _with_more(rng, [list(head) for head in table.heads], table.rows)
    above, kind = _above(rng, said_hz)
    again = str(rng.choice(["", "", "", "head", "comment", "blank", "words"]))
    if again == "head" and len(heads) > 1:
        again = ""
    lines = [
        delimiter.join(row).replace(".", decimal) if decimal == "," else delimiter.join(row) for row in rows
    ]
    if decimal == ",":
        lines = [delimiter.join(_comma(field) for field in row) for row in rows]
    foreign = {
        "head": delimiter.join(heads[0]),
        "comment": "# sensor reconnected",
        "blank": "",
        "words": "connection lost",
    }
    if again:
        lines.insert(int(rng.integers(len(lines) // 3, len(lines) - 5)), foreign[again])
    end = ("\n", "\n", "\r\n")[rng.integers(3)]
    content = end.join([*above, *(delimiter.join(head) for head in heads), *lines]) + end
    encoding = str(rng.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "latin-1"]))
    try:
        raw = content.encode(encoding)
    except UnicodeEncodeError:
        encoding, raw = "utf-8", content.encode()
    return raw, {"above": kind, "again": again, "delimiter": f"{delimiter}{decimal}", "encoding": encoding}


def _comma(field: str) -> str:
    """Return a number with a decimal comma; a date keeps its points."""
    return re.sub(r"(?<=\d)[.](?=\d)", ",", field) if field.count(".") == 1 else field


def _above(rng: Random, said_hz: float | None) -> tuple[list[str], str]:
    kind = str(rng.choice(["nothing", "nothing", "harmless", "misleading"]))
    pool = {"nothing": (), "harmless": _HARMLESS, "misleading": _MISLEADING}[kind]
    lines = [pool[at] for at in rng.permutation(len(pool))[: int(rng.integers(1, 3))]]
    if said_hz is not None:
        forms = ("Sample rate: {:g} Hz", "# sampling rate {:g} Hz", "Update Rate: {:g}Hz", "# fs = {:g} Hz")
        lines.append(forms[rng.integers(len(forms))].format(said_hz))
    return lines, kind


def _with_more(
    rng: Random, heads: list[list[str]], rows: list[list[str]]
) -> tuple[list[list[str]], list[list[str]]]:
    """Add columns that are no signal, in front or behind."""
    if rng.random() < 0.4:
        name = list(_MORE)[rng.integers(len(_MORE))]
        column = [_MORE[name](k) for k in range(len(rows))]
        rows = [[*row, one] for row, one in zip(rows, column, strict=True)]
        names = ["" for _ in heads]
        names[-2 if len(heads) > 1 and any("_" in one or "x" in one.lower() for one in heads[-2]) else -1] = (
            name
        )
        heads = [[*head, one] for head, one in zip(heads, names, strict=True)]
    return heads, rows
