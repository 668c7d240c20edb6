"""How drawn tables name and scale their signals."""

from dataclasses import dataclass

import numpy as np

from tests.app.readers.odd_draws.motion import GRAVITY_MPS2

Random = np.random.Generator

_DEG, _G = 180.0 / np.pi, 1.0 / GRAVITY_MPS2
UNITS: dict[str, dict[str, tuple[float, tuple[str, ...]]]] = {
    "gyroscope": {
        "deg/s": (
            _DEG,
            ("deg/s", "°/s", "º/s", "dps", "deg/sec", "degrees per second", "deg.s-1", "deg s^-1"),
        ),
        "rad/s": (1.0, ("rad/s", "rad/sec", "radians per second", "rad.s-1", "rad·s⁻¹")),
        "mdps": (1000.0 * _DEG, ("mdps",)),
    },
    "accelerometer": {
        "m/s^2": (1.0, ("m/s^2", "m/s²", "m/s**2", "m/s2", "m/s/s", "m/(s^2)", "m.s-2")),
        "g": (_G, ("g", "G", "gn")),
        "mg": (1000.0 * _G, ("mg",)),
    },
    "magnetometer": {
        "uT": (1.0, ("uT", "µT", "μT", "microtesla")),
        "G": (0.01, ("gauss", "G", "Gs")),
        "mG": (10.0, ("mG", "mgauss")),
    },
}
"""By unit: what a SI value (microtesla for the field) is multiplied by, and how people write it."""
WORDS = {
    "words": ("gyr", "acc", "mag"),
    "long words": ("Gyroscope", "Accelerometer", "Magnetometer"),
    "short words": ("gyro", "accel", "magn"),
    "physics": ("omega", "specific force", "field"),
    "phrases": ("Angular Velocity", "Acceleration", "Magnetic Field"),
    "german": ("Drehrate", "Beschleunigung", "Magnetfeld"),
    "letters": ("g", "a", "m"),
    "w": ("w", "a", "m"),
    "letters and a word": ("g", "a", "mag"),
}
QUANTITIES = ("gyroscope", "accelerometer", "magnetometer")
DEVICES = (
    ("left_wrist", "right_wrist", "chest", "pelvis"),
    ("forearm_left", "forearm_right", "upper_arm_left", "upper_arm_right"),
    ("LFoot", "RFoot", "LShank", "RShank"),
    ("A", "B", "C", "D"),
    ("imu1", "imu2", "imu3", "imu4"),
    ("S-17", "S-04", "S-05", "S-11"),
    ("WT901a", "WT901b", "WT901c", "WT901d"),
    ("first", "second", "third", "fourth"),
)


@dataclass(frozen=True)
class Style:
    """How the columns of a table are called.

    Attributes
    ----------
    words : tuple of str
        Of gyroscope, accelerometer and magnetometer.
    joint : str
        Between quantity and axis.
    is_upper : bool
        Whether the axis is a capital.
    units : tuple of str
        Of the three, as keys of `UNITS`.
    spelt : tuple of str
        As they are written.
    place : str
        Where: `brackets`, `square`, `behind`, `line` or `none`.
    """

    words: tuple[str, str, str]
    joint: str
    is_upper: bool
    units: tuple[str, str, str]
    spelt: tuple[str, str, str]
    place: str

    def name(
        self, quantity: str, axis: str, device: str = "", where: str = "before", between: str = "_"
    ) -> str:
        """Return the name of a column; a line of units is not of it."""
        at = QUANTITIES.index(quantity)
        name = f"{self.words[at]}{self.joint}{axis.upper() if self.is_upper else axis}"
        if device:
            name = f"{device}{between}{name}" if where == "before" else f"{name}{between}{device}"
        form = {"brackets": "{} ({})", "square": "{} [{}]", "behind": "{}_{}"}.get(self.place, "{}")
        return form.format(name, self.spelt[at])


def style(rng: Random) -> Style:
    """Draw how columns are called and scaled."""
    kind = list(WORDS)[rng.integers(len(WORDS))]
    is_letter = kind in ("letters", "w", "letters and a word")
    chances = {
        "gyroscope": (0.55, 0.4, 0.05),
        "accelerometer": (0.5, 0.42, 0.08),
        "magnetometer": (0.7, 0.15, 0.15),
    }
    units = tuple(str(rng.choice(list(UNITS[q]), p=chances[q])) for q in QUANTITIES)
    spelt = []
    for quantity, unit in zip(QUANTITIES, units, strict=True):
        spellings = UNITS[quantity][unit][1]
        spelt.append(spellings[rng.integers(len(spellings))])
    place = ("brackets", "square", "behind", "line", "none")[rng.integers(5)]
    if place == "behind":
        spelt = [{"deg/s": "dps", "rad/s": "rads", "m/s^2": "ms2"}.get(unit, unit) for unit in units]
    return Style(
        WORDS[kind],
        "" if is_letter else ("_", " ", ".", "", "-")[rng.integers(5)],
        # A capital tells the axis where nothing else does.
        (not is_letter) and bool(rng.random() < 0.5),
        units,
        tuple(spelt),
        place,
    )
