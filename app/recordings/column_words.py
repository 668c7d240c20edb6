"""The meaning of columns of results, in the words of `columns.json` and of the metadata of a Parquet file."""

import re
from typing import Final

from estimators.orientation import OrientationFlag
from estimators.pipelines import SLIPPED
from estimators.pipelines.walk.layout import FORCE_STATES

FLAGS: Final = {
    OrientationFlag.INVALID: "nothing is known: no data, or lost",
    OrientationFlag.BRIDGED: "interpolated across a gap of at most 0.2 s",
    OrientationFlag.CONVERGING: "the estimate has just begun",
    OrientationFlag.ACCELERATION_NOT_TRUSTED: "movement hides gravity",
    OrientationFlag.MAGNETIC_DISTURBANCE: "the field is not the earth's",
    OrientationFlag.HEADING_NOT_TRUSTED: "the heading is not known; of a foot after a long gap, nor its place",
    OrientationFlag.SATURATED: "the sensor was at its end",
    OrientationFlag.SINGULAR: "near the singular position of its sequence",
}
"""By bit of the columns `_flags`."""
_SEQUENCE: Final = re.compile(r"_([xyz]{3})_")
_SIDE: Final = re.compile(r"_(left|right)(?=_|$)")
_SCALARS: Final = {
    "stance": "1 while the foot stands",
    "contact": "1 at the tick of the initial contact",
    "toe_off": "1 at the tick of toe-off",
    "speed": "speed of the foot",
    "stride_length": "of the stride that ended last",
    "stride_time": "of the stride that ended last",
    "clearance": "height of the swing of the stride that ended last",
    "toe_out": "toe-out angle of the last stance",
    "force_state": "state of the load cells: "
    + ", ".join(f"{k} {name}" for k, name in enumerate(FORCE_STATES)),
    "margin_of_stability": "from the extrapolated centre of mass to the edge of support",
}
_UNITS: Final = ("rad", "mps2", "mps", "m", "s", "nm", "n", "kg")
_SPELT: Final = {"mps2": "m/s^2", "mps": "m/s", "n": "N", "nm": "N m"}


def flags_words() -> str:
    """Return what the bits of a column of flags mean, in one line."""
    said = "; ".join(f"{int(flag)}: {words}" for flag, words in FLAGS.items())
    return f"bits, 0 is sound; {said}; {SLIPPED}: the sensor has turned in its strap"


def unit_of(column: str) -> str:
    """Return the unit that the end of a name says; 1 where it says none."""
    ending = column.rpartition("_")[2]
    return _SPELT.get(ending, ending) if ending in _UNITS else "1"


def sequence_of(angle: str) -> str:
    """Return the sequence of rotations that an angle is of, `yxy`; empty where its name says none."""
    found = _SEQUENCE.search(angle)
    return found[1] if found else ""


def angle_words(angle: str) -> str:
    """Return what an angle is, from its name: joint, side and meaning."""
    side = _SIDE.search(angle)
    plain = _SIDE.sub("", angle)
    joint, _, meaning = _SEQUENCE.sub("|", plain).partition("|")
    where = f" on the {side[1]}" if side else ""
    return (
        f"{(meaning or joint).replace('_', ' ')} of {joint.replace('_', ' to ', 1).replace('_', ' ')}{where}"
    )


def scalar_words(scalar: str) -> str:
    """Return what another measure is, from its name."""
    plain = re.sub(r"^foot_(left|right)_", "", scalar)
    name = re.sub(rf"_({'|'.join(_UNITS)})$", "", plain)
    return _SCALARS.get(name, name.replace("_", " "))
