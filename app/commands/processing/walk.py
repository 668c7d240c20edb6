"""Output of `telemotion process --pipeline gait` beside the frames: a table of strides and the walk in numbers."""

import csv
import json
import math
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import numpy as np
import typer

from app.kinds.walk.balance import balance_of
from estimators import pipelines
from estimators.conventions import SIDES
from estimators.errors import EstimationError
from estimators.gait import Measure, Strides
from estimators.pipelines import SessionSetup, ShoeWalk, Walk
from estimators.recording import Recording

_SHOWN = ("stride_length", "stride_time", "speed", "cadence", "stance_share", "clearance", "toe_out")


def analyse(
    measured: Recording, shoes: Recording | None, setup: SessionSetup
) -> tuple[Walk, ShoeWalk | None, str]:
    """Follow the feet, and where the recording has load cells under both, the forces and the centre of mass.

    Parameters
    ----------
    measured : Recording
        Of the feet.
    shoes : Recording or None
        Heels and forefeet with their load cells.

    Returns
    -------
    walk : Walk
    shoes : ShoeWalk or None
    note : str
        Why there are no forces although cells were worn; else empty.
    """
    walk = pipelines.analyse_walk(measured, setup)
    if shoes is None:
        return walk, None, ""
    try:
        forces = pipelines.analyse_shoes(shoes, setup, walk)
    except EstimationError as error:
        return walk, None, f"no forces: {error}"
    return pipelines.with_shoes(walk, forces), forces, ""


OF_THE_FOOT: Final = frozenset(
    {"side", "footholds", "q_sensor_foot", "is_backward", "is_trembling", "is_carried", "rolled_s"}
)
"""Fields of `Strides` that are no columns."""


def write_walk(walk: Walk, out: Path, shoes: ShoeWalk | None = None, note: str = "") -> None:
    """Write `strides.csv`, `walk.json` and with forces `forces.csv`, and say the main numbers.

    Parameters
    ----------
    out : Path
        An existing folder.
    note : str
        A reason to be reported with the walk's own.
    """
    names = [field.name for field in fields(Strides) if _is_column(field.name)]
    with (out / "strides.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["foot", *names, "foothold_x_m", "foothold_y_m", "foothold_z_m"])
        for side, strides in walk.strides.items():
            columns = [np.asarray(getattr(strides, name)).tolist() for name in names]
            holds = strides.footholds.position_m[1:].tolist()
            for row in zip(*columns, holds, strict=True):
                writer.writerow([side, *row[:-1], *row[-1]])
    summary = walk.summary
    reasons = [*summary.reasons, *(() if shoes is None else shoes.reasons), *([note] if note else [])]
    content: dict[str, Any] = {
        "feet": {side: _numbers(numbers) for side, numbers in summary.feet.items()},
        "turning": {side: _numbers(numbers) for side, numbers in summary.turning.items()},
        "both": _numbers({**summary.both, **(walk.steps or {})}),
        "asymmetry": _numbers(summary.asymmetry),
        "turns": summary.turn_count,
        "bouts": summary.bout_count,
        "reasons": reasons,
    }
    if shoes is not None:
        balance = balance_of(shoes)
        content["balance"] = {
            "mass_kg": balance.mass_kg,
            "feet_apart_m": balance.apart_m,
            "feet_apart_source": balance.apart_source,
            **{found.measure: found.model_dump(exclude={"measure"}) for found in balance.measures},
        }
        _write_forces(shoes, out / "forces.csv")
    (out / "walk.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    for side, numbers in summary.feet.items():
        for name in _SHOWN:
            found = numbers[name]
            typer.echo(
                f"  {side:<5} {name:<14} {found.value:8.3f} +- {found.sigma:.3f} {found.unit}, {found.count} strides"
            )
    for reason in reasons:
        typer.echo(f"  {reason}")


def _write_forces(shoes: ShoeWalk, path: Path) -> None:
    """Write what the ground does to each foot, room axes, with the ankle where a lower leg was measured."""
    names, columns = ["time_s"], [shoes.time_s]
    for side in SIDES:
        found = shoes.shoes[side]
        reaction = shoes.feet.reaction[side]
        parts = {"force_{}_n": reaction.force_n, "pressure_{}_m": reaction.cop_m[:, :2]}
        if found.ankle is not None:
            parts["ankle_moment_{}_nm"] = found.ankle.moment_nm
        for name, values in parts.items():
            names += [f"{side}_{name.format(axis)}" for axis in "xyz"[: values.shape[1]]]
            columns += list(values.T)
        if found.ankle is not None:
            names.append(f"{side}_ankle_power_w")
            columns.append(found.ankle.power_w)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows(np.column_stack(columns).round(5).tolist())


def _is_column(name: str) -> bool:
    # What is of the foot as a whole stands in `walk.json`, as numbers or as a reason.
    return name not in OF_THE_FOOT


def _numbers(measures: Any) -> dict[str, dict[str, Any]]:
    return {name: _plain(found) for name, found in measures.items()}


def _plain(found: Measure) -> dict[str, Any]:
    """Return a measure in JSON's own words, which have none for what is not known."""
    values = {"value": found.value, "sigma": found.sigma, "spread": found.spread}
    known = {name: value if math.isfinite(value) else None for name, value in values.items()}
    return {**known, "count": found.count, "unit": found.unit}
