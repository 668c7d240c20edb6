"""How the value of a place is written in English.

The client writes the same formats in the language of the reader (`web/src/i18n/sentence.ts`); both are held to
`tests/data/sentence_formats.json`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Final

from estimators.sentences._sentence import Sentence


@dataclass(frozen=True)
class Unit:
    """How a number in SI units is shown.

    Attributes
    ----------
    factor : float
        SI to shown.
    suffix : str
        After the number, with its space.
    digits : int
        After the point, unless the place says otherwise.
    """

    factor: float
    suffix: str
    digits: int


UNITS: Final[dict[str, Unit]] = {
    "": Unit(1.0, "", 0),
    "s": Unit(1.0, " s", 0),
    "ms": Unit(1e3, " ms", 0),
    "min": Unit(1.0 / 60.0, " min", 0),
    "hz": Unit(1.0, " Hz", 0),
    "m": Unit(1.0, " m", 1),
    "cm": Unit(1e2, " cm", 0),
    "mm": Unit(1e3, " mm", 0),
    "deg": Unit(180.0 / math.pi, "°", 0),
    "degps": Unit(180.0 / math.pi, " °/s", 0),
    "mps": Unit(1.0, " m/s", 2),
    "mps2": Unit(1.0, " m/s²", 1),
    "ut": Unit(1e6, " µT", 0),
    "percent": Unit(1e2, " %", 0),
    "points": Unit(1e2, "", 0),
    "mib": Unit(2.0**-20, " MiB", 0),
    "gib": Unit(2.0**-30, " GiB", 0),
    "kib": Unit(2.0**-10, " KiB", 0),
    "kg": Unit(1.0, " kg", 0),
}
_LAST: Final[dict[str, str]] = {"and": " and ", "or": " or "}


def written(value: Any, kind: str, style: str) -> str:
    """Return a value in English.

    Parameters
    ----------
    kind : str
        Empty for a value that is written as it is, `number` or `list`.
    style : str
        Of a number: its unit, with `.1` for one digit after the point and `~3` for three in all: `deg`, `s.1`, `~3`.
        Of a list: `and`, which is meant without a style, or `or`: sentences in it begin without a capital; `lines`:
        sentences one after another.
    """
    if not kind:
        return str(value)
    if kind == "list":
        if style == "lines":
            return " ".join(str(one) for one in value)
        return joined([_within(one) for one in value], style or "and")
    name, digits, significant = parts(style)
    unit = UNITS[name]
    number = float(value) * unit.factor
    if significant is not None:
        text = format(Decimal(f"{number:.{significant}g}").normalize(), "f")
    else:
        text = f"{number:.{unit.digits if digits is None else digits}f}"
    # Minus zero is zero; the minus sign is the one of print, as on the pages.
    text = text.lstrip("-") if not any(digit in "123456789" for digit in text) else text
    return text.replace("-", "\u2212") + unit.suffix


def _within(value: Any) -> str:
    """Return a part of a list: within a sentence a sentence has no capital of its own."""
    text = str(value)
    return text[:1].lower() + text[1:] if isinstance(value, Sentence) else text


def parts(style: str) -> tuple[str, int | None, int | None]:
    """Return unit, digits after the point and significant digits of a number's style."""
    name, _, digits = style.partition(".")
    name, _, significant = name.partition("~")
    return name, int(digits) if digits else None, int(significant) if significant else None


def joined(words: Sequence[str], last: str) -> str:
    """Return `a, b and c`.

    Parameters
    ----------
    last : {"and", "or"}
        Between the last two.
    """
    return _LAST[last].join([*([", ".join(words[:-1])] if words[1:] else []), *words[-1:]])
