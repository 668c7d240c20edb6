"""Shares of the body's mass and where they lie: tables for men and women, or a patient's own."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final, Literal

from estimators.errors import SetupError

Sex = Literal["man", "woman"]

SEGMENTS: Final = (
    "head",
    "upper_trunk",
    "middle_trunk",
    "lower_trunk",
    "upper_arm",
    "forearm",
    "hand",
    "thigh",
    "shank",
    "foot",
)
"""Parts of the body; those of the limbs exist twice."""
PAIRED: Final = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")

THIGH_PER_STATURE = 0.245
SHANK_PER_STATURE = 0.246
FOOT_PER_STATURE = 0.152
HEAD_PER_STATURE = 0.182
"""Drillis and Contini (1966), as in `estimators.body`; the head with the neck, above the shoulders."""


@dataclass(frozen=True)
class BodySegments:
    """Masses and centres of the parts of a body.

    Attributes
    ----------
    mass_share : dict of str to float
        Of the whole mass, each limb once; both sides together with the rest make one.
    centre_share : dict of str to float
        Of the length of the part, from its upper or inner end (the foot: from the heel, head: from the top).
    trunk_share : tuple of 3 floats
        Length of upper, middle and lower trunk as parts of the trunk.
    own_mass_share : dict of str to float
        Measured masses of parts with their side, `shank_left` say, in place of the table's: a prosthesis, an
        amputation, a cast. The rest is scaled so that everything still makes one.
    """

    mass_share: Mapping[str, float]
    centre_share: Mapping[str, float]
    trunk_share: tuple[float, float, float]
    own_mass_share: Mapping[str, float] = field(default_factory=dict)

    def masses(self) -> dict[str, float]:
        """Return the share of every part with its side; they add up to one."""
        whole: dict[str, float] = {}
        for name in SEGMENTS:
            for part in (f"{name}_left", f"{name}_right") if name in PAIRED else (name,):
                whole[part] = self.mass_share[name]
        unknown = set(self.own_mass_share) - set(whole)
        if unknown:
            raise SetupError(
                f"no part of the body is named {', '.join(sorted(unknown))}; use {', '.join(whole)}"
            )
        own = dict(self.own_mass_share)
        measured = sum(own.values())
        rest = sum(share for part, share in whole.items() if part not in own)
        if measured >= 1.0 or min(own.values(), default=0.0) < 0.0:
            raise SetupError("measured parts must not be negative nor outweigh the whole body")
        return {part: own.get(part, share * (1.0 - measured) / rest) for part, share in whole.items()}


_CENTRE_WOMAN: Final = {
    "head": 0.374,
    "upper_trunk": 0.2077,
    "middle_trunk": 0.4512,
    "lower_trunk": 0.4920,
    "upper_arm": 0.5754,
    "forearm": 0.4559,
    "hand": 0.7474,
    "thigh": 0.3612,
    "shank": 0.4352,
    "foot": 0.4014,
}
_CENTRE_MAN: Final = {
    "head": 0.384,
    "upper_trunk": 0.2999,
    "middle_trunk": 0.4502,
    "lower_trunk": 0.6115,
    "upper_arm": 0.5772,
    "forearm": 0.4574,
    "hand": 0.7900,
    "thigh": 0.4095,
    "shank": 0.4395,
    "foot": 0.4415,
}
_MASS_WOMAN: Final = (0.0668, 0.1545, 0.1465, 0.1247, 0.0255, 0.0138, 0.0056, 0.1478, 0.0481, 0.0129)
_MASS_MAN: Final = (0.0694, 0.1596, 0.1633, 0.1117, 0.0271, 0.0162, 0.0061, 0.1416, 0.0433, 0.0137)


def body_segments(sex: Sex, own_mass_share: Mapping[str, float] | None = None) -> BodySegments:
    """Return the table for a man or a woman.

    Parameters
    ----------
    own_mass_share : mapping of str to float, optional
        The patient's own, see `BodySegments`.

    Raises
    ------
    SetupError
        For another word, or masses that cannot be.

    Notes
    -----
    De Leva (1996), J. Biomech. 29:1223, table 4: Zatsiorsky's gamma-ray masses with centres moved to joint
    centres; suprasternal notch to mid hip for the trunk. The centre of head and neck is given there from the
    vertex to the seventh vertebra (48.41 % and 50.02 %) and here from the vertex to shoulder height. Printed
    shares add up to 0.9999 to 1.0001.
    """
    if sex not in ("man", "woman"):
        raise SetupError(f"body segments are known for 'man' and 'woman', not {sex!r}")
    is_man = sex == "man"
    found = BodySegments(
        dict(zip(SEGMENTS, _MASS_MAN if is_man else _MASS_WOMAN, strict=True)),
        _CENTRE_MAN if is_man else _CENTRE_WOMAN,
        (0.321, 0.405, 0.274) if is_man else (0.269, 0.388, 0.343),
    )
    return replace(found, own_mass_share=dict(own_mass_share)) if own_mass_share else found


def mean_segments() -> BodySegments:
    """Return the mean of the tables for men and women, for a person of whom only the lengths are known."""
    man, woman = body_segments("man"), body_segments("woman")

    def mean(one: Mapping[str, float], other: Mapping[str, float]) -> dict[str, float]:
        return {name: 0.5 * (one[name] + other[name]) for name in one}

    upper, middle, lower = (0.5 * (a + b) for a, b in zip(man.trunk_share, woman.trunk_share, strict=True))
    return BodySegments(
        mean(man.mass_share, woman.mass_share),
        mean(man.centre_share, woman.centre_share),
        (upper, middle, lower),
    )
