"""Left for right: what the same movement is called on the other side, and which channels change their sign."""

import re
from dataclasses import replace
from typing import Final

import numpy as np

from estimators.comparison._bands import Knot, ToleranceCurve
from estimators.comparison._contract import Template, Trajectory
from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.recording import Float

_MIRRORED_SIGN: Final = {"trunk_lean_lateral_rad", "trunk_axial_rotation_rad"}


def check_side(side: str) -> None:
    """Raise `SetupError` unless the side is one of the two."""
    if side not in ("left", "right"):
        raise SetupError(f"side is {side!r}; use 'left' or 'right'")


def other_side(side: str) -> Side:
    """Return the side across."""
    check_side(side)
    return "left" if side == "right" else "right"


def mirrored_name(name: str) -> str:
    """Return what a channel is called on the other side."""
    return re.sub(r"left|right", lambda found: other_side(found.group()), name)


def _mirrored_signs(channels: tuple[str, ...]) -> Float:
    return np.array([-1.0 if changes_sign(name) else 1.0 for name in channels])


def changes_sign(name: str) -> bool:
    """Return whether a channel has the opposite sign in a mirror: to the side, and turning of the trunk."""
    return name in _MIRRORED_SIGN or name.endswith(".y")


def mirror_trajectory(source: Trajectory) -> Trajectory:
    """Swap left and right: what the same person would show in a mirror.

    Joint angles keep their sign because their positive directions are anatomical on both sides; y
    coordinates, lateral lean and axial rotation of the trunk change it.
    """
    return replace(
        source,
        channels=tuple(mirrored_name(name) for name in source.channels),
        values=source.values * _mirrored_signs(source.channels),
    )


def mirror_template(template: Template) -> Template:
    """Return the template for the other arm; see `mirror_trajectory` for the signs.

    What changes its sign has above where it had below.
    """
    return replace(
        template,
        tolerances=tuple(
            ToleranceCurve(
                mirrored_name(curve.channel),
                tuple(Knot(k.phase, k.above, k.below) for k in curve.knots)
                if changes_sign(curve.channel)
                else curve.knots,
            )
            for curve in template.tolerances
        ),
        watched=tuple(mirrored_name(name) for name in template.watched),
        channels=tuple(mirrored_name(name) for name in template.channels),
        mean=template.mean * _mirrored_signs(template.channels),
        primary_channel=mirrored_name(template.primary_channel),
        side=other_side(template.side),
        measures={mirrored_name(name): value for name, value in template.measures.items()},
        measure_sd={mirrored_name(name): value for name, value in template.measure_sd.items()},
    )
