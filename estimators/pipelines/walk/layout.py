"""Names of what a walk's frames hold, and which sensors of a setup are on which foot."""

from typing import Final

from estimators.conventions import SIDES, Side
from estimators.errors import SetupError
from estimators.pipelines._contract import FrameLayout, SessionSetup
from estimators.sentences import say

WORN: Final[tuple[str, ...]] = (
    "foot_left",
    "foot_right",
    "heel_left",
    "forefoot_left",
    "heel_right",
    "forefoot_right",
)
"""Placements that the gait pipeline follows; others are left out."""
SCALARS: Final = (
    "stance",
    "contact",
    "toe_off",
    "speed_mps",
    "stride_length_m",
    "stride_time_s",
    "clearance_m",
    "toe_out_rad",
)
"""Per foot, named `foot_left_stance` and so on. Stance, contact and toe-off are 0 or 1; the last four are those of the
stride that the last contact ended, NaN before the first. Live there are only stance, speed, stride length and toe-out,
of the last stance that ended."""
STANCE, CONTACT, TOE_OFF, SPEED, STRIDE_LENGTH, STRIDE_TIME, CLEARANCE, TOE_OUT = range(len(SCALARS))
"""Columns of a foot."""
FORCE_SCALARS: Final = ("force_x_n", "force_y_n", "force_z_n", "force_state")
"""Per foot, live on two instrumented shoes: of the ground on it, room axes, and an index into `FORCE_STATES`."""
FORCE_STATES: Final = ("measured", "not_tared", "missing", "implausible")
BALANCE_POINTS: Final = ("centre_of_mass", "centre_of_pressure", "extrapolated_centre")
"""Points of the frames beside the feet; the last two lie on the floor."""
BALANCE_SCALARS: Final = ("margin_of_stability_m",)
PRESSURE_POINTS: Final = ("pressure_left", "pressure_right")
"""Centre of pressure of each foot alone, live."""
LIVE_BALANCE_SCALARS: Final = (*BALANCE_SCALARS, "centre_of_mass_sigma_m", "body_mass_kg")
CENTRE_PER_STATURE: Final = 0.55
"""Height of the centre of mass of somebody who stands."""


def feet_of(setup: SessionSetup) -> dict[Side, int]:
    """Return which sensor of a setup is on which foot, a whole foot before a heel.

    Raises
    ------
    SetupError
        When there is none.
    """
    found: dict[Side, int] = {}
    for side in SIDES:
        for name in (f"foot_{side}", f"heel_{side}"):
            if name in setup.placements and side not in found:
                found[side] = list(setup.placements).index(name)
    if not found:
        raise SetupError(say("walk.needs_foot", places=list(WORN)))
    return found


def cells_of(setup: SessionSetup) -> list[list[int]] | None:
    """Return heel and forefoot sensor of the left and the right shoe; None unless all four are worn."""
    names: list[str] = list(setup.placements)
    wanted = [[f"heel_{side}", f"forefoot_{side}"] for side in SIDES]
    if not all(name in names for pair in wanted for name in pair):
        return None
    return [[names.index(name) for name in pair] for pair in wanted]


def layout_of(sides: tuple[Side, ...], *, with_forces: bool = False) -> FrameLayout:
    """Return the columns of the gait pipeline for the feet that are worn, and live those of two shoes' forces."""
    names = tuple(f"foot_{side}" for side in sides)
    scalars = tuple(f"{name}_{scalar}" for name in names for scalar in SCALARS)
    points: tuple[str, ...] = names
    if with_forces:
        points += (*BALANCE_POINTS, *PRESSURE_POINTS)
        scalars += tuple(f"{name}_{scalar}" for name in names for scalar in FORCE_SCALARS)
        scalars += LIVE_BALANCE_SCALARS
    return FrameLayout(segments=names, points=points, angles=(), scalars=scalars)
