"""The meaning of a column's name: quantity, axis, unit, and which sensor at which place."""

import re
from dataclasses import dataclass
from typing import Final

from estimators.conventions import PLACEMENTS, SIDES

AXES: Final = "xyz"
_WORDS: Final = (
    (
        "gyroscope",
        re.compile(r"gyr|omega|angular|ang ?vel|rot(ation)? ?rate|turn ?rate|drehrate|winkelgeschw"),
    ),
    ("accelerometer", re.compile(r"acc|specific ?force|g ?force|acel|beschl")),
    ("magnetometer", re.compile(r"mag(?!nitude)|field|magnetfeld")),
)
_LETTERS: Final = {
    "g": "gyroscope",
    "w": "gyroscope",
    "a": "accelerometer",
    "m": "magnetometer",
    "b": "magnetometer",
}
"""What stands alone before an axis in the tables of small programs: `ax`, `gx`, `mx`."""
_OF_QUANTITIES: Final = re.compile(
    r"^(gyr.*|omega|angular|ang|vel.*|rot.*|rate|turn|drehrate|winkelgeschw.*|acc.*|acel.*|beschl.*|specific|g?force"
    r"|mag.*|field)$"
)
_LAST: Final = frozenset({"force", "velocity", "rate"})
"""End what is called in two words; an axis may follow at once."""
_FILLERS: Final = frozenset({"cal", "calibrated", "raw", "ln", "wr", "value", "data", "axis", "achse"})
"""Say nothing about which sensor it is; columns that differ in them are still not of one triple."""
_NO_GRAVITY: Final = frozenset({"free", "linear", "lin", "user", "dynamic"})
_ORIENTATION: Final = re.compile(r"^(mat|q(uat.*)?|euler|roll|pitch|yaw)$")
_UNITS: Final[dict[str, dict[str, str]]] = {
    "gyroscope": {
        "deg/s": r"deg(rees?)?(/| per )s(ec(ond)?)?|degps|degs|dps|deg\.?s-1|deg s-1",
        "rad/s": r"rad(ians?)?(/| per )s(ec(ond)?)?|radps|rads|rad\.?s-1|rad s-1",
        "mdps": r"mdps|mdeg/s",
    },
    "accelerometer": {
        "m/s^2": r"m/s(ec)?2|m/s/s|mps2|ms2|m\.?s-2|m s-2"
        r"|met(er|re)s?(/| per )s(ec(ond)?)?( ?(2|squared)|(/| per )s(ec(ond)?)?)",
        "g": r"gn?|gs|g-?force",
        "mg": r"mgn?",
    },
    "magnetometer": {
        "uT": r"ut|microtesla",
        "T": r"t|tesla",
        "mT": r"mt",
        "G": r"g|gs|gauss",
        "mG": r"mg|mgauss",
    },
    "time": {
        "s": r"s|secs?|seconds?",
        "ms": r"ms|msec|millis|milliseconds?",
        "us": r"us|usec|micros|microseconds?",
        "ns": r"ns|nsec|nanos|nanoseconds?",
    },
    "none": {
        "": r"counts?|cnt|lsb|bits?|digits?|adc|ticks?|raw|a\.?u\.?|n\.?u\.?|arb\.?( ?u(nits?)?\.?)?|local_flux\*?"
        r"|no unit"
    },
}
_TAIL: Final = re.compile(
    r"[\s_(\[{,;:]+("
    + "|".join(spelling for units in _UNITS.values() for spelling in units.values())
    + r")[\s)\]}]*$",
    re.IGNORECASE,
)
_QUOTIENT: Final = re.compile(r"\s*[\[(][A-Za-z]{1,12}[/*][^\[\]()]{1,12}[\])]\s*$")
"""In brackets what is divided by something is a unit, whichever."""
_G_FORCE: Final = re.compile(r"(?<![A-Za-z])g[Ff](?=[ _]?[XYZxyz](?![A-Za-z]))")
"""`gFx`: specific force in multiples of gravity."""
_RAISED: Final = str.maketrans("⁻¹²³", "-123")
_REPEATED: Final = re.compile(r" \([0-9]+\)$")
"""As `_table_head` numbers repeated names."""
_PLACES: Final = (
    ("head", r"head"),
    ("sternum", r"sternum|chest|trunk|torso|thorax|breastbone"),
    ("pelvis", r"pelvis|lumbar|sacrum|waist|lower_back|l[45](?![0-9])"),
    ("shoulder", r"shoulder|scapula"),
    ("upper_arm", r"upper_?arm|humerus"),
    ("forearm", r"fore_?arm|lower_?arm|wrist"),
    ("hand", r"hand"),
    ("thigh", r"thigh|upper_?leg|femur"),
    ("shank", r"shank|lower_?leg|shin|tibia|calf"),
    ("foot", r"(?<!fore)foot|shoe|instep"),
)


@dataclass(frozen=True)
class Named:
    """What a name says.

    Attributes
    ----------
    axis : str
        `x`, `y` or `z`.
    quantity : str
        Of `CsvColumn`; empty where it is not said.
    stem : tuple of str
        All words but the axis: columns that share it and differ in the axis are one triple.
    device : str
        Words that say which sensor, `left_sensor`; empty where there are none.
    unit : str
        Of `CsvColumn`; empty where it is not said.
    has_gravity : bool
        False for acceleration from which gravity was removed.
    """

    axis: str
    quantity: str
    stem: tuple[str, ...]
    device: str
    unit: str
    has_gravity: bool


def named(column: str, *, letters: bool = False) -> Named | None:
    """Return what the name of a column says; None where it has no axis.

    Parameters
    ----------
    letters : bool
        Whether a letter alone before the axis is a quantity.
    """
    number = match[0] if (match := _REPEATED.search(column)) else ""
    text, written = _without_units(column.removesuffix(number))
    words = words_of(text)
    places = [i for i, word in enumerate(words) if word in AXES]
    if not places:
        return None
    at = places[-1]
    axis = words.pop(at)
    quantity = quantity_of(words)
    letter = at - 1 if letters and not quantity and at and words[at - 1] in _LETTERS else None
    if letter is not None:
        quantity = _LETTERS[words[letter]]
    mine = [
        word
        for k, word in enumerate(words)
        if k != letter and not (_OF_QUANTITIES.match(word) or word in _FILLERS)
    ]
    return Named(
        axis,
        quantity,
        (*words, number),
        "_".join([*mine, *re.findall(r"[0-9]+", number)]),
        next((unit for one in written if (unit := unit_of(one, quantity))), "g" if "gforce" in words else ""),
        not (_NO_GRAVITY & set(words)),
    )


def words_of(text: str) -> list[str]:
    """Return the words of a name in lower case: at blanks, signs and capitals, an axis apart from what it is of."""
    found: list[str] = []
    for part in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-zäöüß]+|[0-9]+", text):
        word = part.lower()
        if (
            len(word) > 1
            and word[-1] in AXES
            and (quantity_of([word[:-1]], letters=True) or word[:-1] in _LAST)
        ):
            found += [word[:-1], word[-1]]
        else:
            found.append(word)
    return found


def unit_of(written: str, quantity: str) -> str:
    """Return the unit of a quantity (or of `time`) that a spelling stands for; empty when it is none of it."""
    for unit, spelling in _UNITS.get(quantity, {}).items():
        if re.fullmatch(spelling, written, re.IGNORECASE):
            return unit
    return ""


def time_unit_of(column: str) -> str:
    """Return the unit that the name of a time column says; empty where it says none."""
    text, written = _without_units(_REPEATED.sub("", column))
    said = [*written, *words_of(text)]
    return next(
        (unit for one in said if len(one) > 1 or one in written if (unit := unit_of(one, "time"))), ""
    )


def without_unit(column: str) -> str:
    """Return the name of a column without the units at its end."""
    return _without_units(_REPEATED.sub("", column))[0]


def placement_of(device: str) -> str | None:
    """Return the placement that the words for a sensor say."""
    plain = re.sub(
        r"(^|_)([lr])(?=foot|thigh|shank|hand|fore|upper|shoulder|shin|wrist)", r"\1\2_", device.lower()
    )
    tokens = plain.split("_")
    sides = [side for side in SIDES if side in plain or side[0] in tokens]
    for place, spelling in _PLACES:
        if re.search(spelling, plain):
            if place in PLACEMENTS:
                return place
            return f"{place}_{sides[0]}" if len(sides) == 1 else None
    return None


def side_of(words: str) -> str | None:
    """Return the side of the body that some words say."""
    plain = re.sub(r"[^a-z]+", "_", words.lower()).split("_")
    found = [side for side in SIDES if side in plain or side[0] in plain]
    return found[0] if len(found) == 1 else None


def is_orientation(column: str) -> bool:
    """Whether a column holds an orientation instead of what a sensor measures."""
    return any(_ORIENTATION.match(word) for word in words_of(column))


def _without_units(text: str) -> tuple[str, list[str]]:
    """Return a name without the units at its end, and those, the last one first."""
    plain = text.translate(_RAISED).replace("^", "").replace("**", "").replace("·", ".")
    # Keyboards have the ordinal sign and the ring where the degree sign is wanted.
    plain = re.sub("[µμ]", "u", re.sub("[°º˚]", "deg", plain)).replace("(s2)", "s2")
    plain = _G_FORCE.sub("gforce ", plain)
    written: list[str] = []
    while len(written) < 3 and (tail := _TAIL.search(plain)):
        if tail[1].lower() in AXES or not plain[: tail.start()].strip():
            break
        written.append(tail[1].lower())
        plain = plain[: tail.start()]
    return _QUOTIENT.sub("", plain), written


def is_of_quantity(word: str) -> bool:
    """Return whether a word is part of what quantities are called, and of no sensor's name."""
    return _OF_QUANTITIES.match(word) is not None


def quantity_of(words: list[str], *, letters: bool = False) -> str:
    """Return the quantity that words name; empty where they name none.

    Parameters
    ----------
    words : list of str
        In lower case.
    letters : bool
        Whether a letter that stands alone is a quantity.
    """
    plain = " ".join(words)
    for name, pattern in _WORDS:
        if pattern.search(plain):
            return name
    return _LETTERS.get(words[-1], "") if letters and words else ""
