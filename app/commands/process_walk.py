"""What `telemotion process --pipeline gait` writes beside the frames: a table of strides and the walk in numbers."""

import csv
import json
import math
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import typer

from estimators.gait import Measure, Strides
from estimators.pipelines import Walk

_SHOWN = ("stride_length", "stride_time", "speed", "cadence", "stance_share", "clearance", "toe_out")


def write_walk(walk: Walk, out: Path) -> None:
    """Write `strides.csv` and `walk.json`, and say the main numbers.

    Parameters
    ----------
    walk : Walk
    out : Path
        An existing folder.
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
    content: dict[str, Any] = {
        "feet": {side: _numbers(numbers) for side, numbers in summary.feet.items()},
        "both": _numbers(summary.both),
        "asymmetry": _numbers(summary.asymmetry),
        "turns": summary.turn_count,
        "bouts": summary.bout_count,
        "reasons": list(summary.reasons),
    }
    (out / "walk.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    for side, numbers in summary.feet.items():
        for name in _SHOWN:
            found = numbers[name]
            typer.echo(
                f"  {side:<5} {name:<14} {found.value:8.3f} +- {found.sigma:.3f} {found.unit}, {found.count} strides"
            )
    for reason in summary.reasons:
        typer.echo(f"  {reason}")


def _is_column(name: str) -> bool:
    return name not in ("side", "footholds", "q_sensor_foot")


def _numbers(measures: Any) -> dict[str, dict[str, Any]]:
    return {name: _plain(found) for name, found in measures.items()}


def _plain(found: Measure) -> dict[str, Any]:
    """Return a measure in JSON's own words, which have none for what is not known."""
    values = {"value": found.value, "sigma": found.sigma, "spread": found.spread}
    known = {name: value if math.isfinite(value) else None for name, value in values.items()}
    return {**known, "count": found.count, "unit": found.unit}


__all__ = ["write_walk"]
