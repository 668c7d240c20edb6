"""An experiment with one seed: it runs, all of it is measured, and nothing is grossly wrong.

Limits are judged over fifty seeds, by `make accuracy`: one seed decides none of them.
"""

from typing import Final

import numpy as np

import validation
from tests.validation.passed_before import modules_of, unless_passed_before
from validation import FigureResult

SCRIPTED: Final = frozenset({"relative_pose_ten_hours"})
"""Minutes long: run by the command alone."""
TIMED: Final = frozenset({"guidance_cost"})
"""Measure processor time: how busy a machine is proves nothing of the code."""
SEVERAL: Final = {
    "com_foot_distance": 8,
    "disturbance_iron_cylinder": 6,
    "disturbance_quarter_turns": 20,
    "disturbance_steel_case": 8,
    "guidance_phase": 8,
}
"""With how many seeds where one alone may be anything: what is judged there is a mean, or a tail."""
GROSS: Final = 2.0
"""By so much a limit may be missed."""
UNMET: Final = {
    "orientation_honesty": {
        f"whole field off, {method}, {figure}"
        for method in ("our filter", "our smoother")
        for figure in ("inside the 95 % region", "NEES of a run")
    }
}
"""What is far from its limit today, and `telemotion validate` says so."""
SIMULATED: Final = tuple(
    sorted(one.name for one in validation.protocols() if not one.needs_data and one.name not in SCRIPTED)
)


def amiss(found: FigureResult, *, is_timed: bool = False) -> bool:
    """Return whether a figure was not measured, or is beyond twice its limit; no time is too long."""
    if not np.isfinite(found.values).all():
        return True
    limit, at_most = found.figure.required, found.figure.at_most
    if limit is None or is_timed:
        return False
    gross = limit * (GROSS if at_most == (limit > 0.0) else 1.0 / GROSS)
    return found.judged.value > gross if at_most else found.judged.value < gross


def check(name: str, seed: int = 0) -> None:
    """Run an experiment unless it passed before with the same code; fail where a figure is amiss."""
    protocol = next(one for one in validation.protocols() if one.name == name)
    with unless_passed_before(name, modules_of(protocol)):
        (result,) = validation.run([name], seeds=SEVERAL.get(name, 1), first_seed=seed)
        found = {one.figure.name for one in result.figures if amiss(one, is_timed=name in TIMED)}
        assert found <= UNMET.get(name, set()), validation.to_table([result])
