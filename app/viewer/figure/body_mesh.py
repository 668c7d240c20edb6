"""A human figure made from body dimensions: one closed mesh per segment and material, in segment frames.

Frames are those of `estimators.conventions`: x forward, y left, z up in the anatomical position, origin at
the proximal joint, so limbs extend along -z and palms face +x. Neighbouring segments share the radius of a
sphere at their joint, so a bent joint shows no gap. Widths scale with stature; lengths are the measured ones.

The left side is modelled and mirrored: no difference between the sides can come from the drawing.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from app.viewer.figure import limbs, trunk
from app.viewer.figure.proportions import REFERENCE_STATURE_M
from app.viewer.figure.surface import Mesh
from estimators.body import BodyDimensions

MATERIALS: Final = ("skin", "hair", "shirt", "trousers", "shoe", "band")
"""What a piece is made of; the scene gives each a colour."""

_LIMBS: Final[list[tuple[str, str, Callable[[BodyDimensions, float], Mesh]]]] = [
    ("upper_arm", "skin", limbs.upper_arm),
    ("upper_arm", "shirt", limbs.sleeve),
    ("upper_arm", "band", limbs.arm_band),
    ("forearm", "skin", limbs.forearm),
    ("hand", "skin", limbs.hand),
    ("thigh", "trousers", limbs.thigh),
    ("shank", "trousers", limbs.shank),
    ("shank", "skin", limbs.ankle),
    ("foot", "shoe", limbs.shoe),
]


@dataclass(frozen=True)
class Piece:
    """A mesh of one material, rigid on one segment."""

    segment: str
    material: str
    mesh: Mesh


@lru_cache(maxsize=32)
def build_figure(body: BodyDimensions) -> tuple[Piece, ...]:
    """Return all pieces of a figure.

    Returns
    -------
    tuple of Piece
        Segments: `pelvis`, `sternum` (the thorax, origin at the middle of the hips), `head`, and per side
        `upper_arm`, `forearm`, `hand`, `thigh`, `shank`, `foot` with `_left` or `_right`.
    """
    wide = body.stature_m / REFERENCE_STATURE_M
    pieces = [
        Piece("pelvis", "trousers", trunk.pelvis(body, wide)),
        Piece("sternum", "shirt", trunk.torso(body, wide)),
        Piece("head", "skin", trunk.head(body, wide)),
        Piece("head", "hair", trunk.hair(body, wide)),
    ]
    for segment, material, make in _LIMBS:
        left = make(body, wide)
        pieces.append(Piece(f"{segment}_left", material, left))
        pieces.append(Piece(f"{segment}_right", material, left.mirrored()))
    return tuple(pieces)
