"""`telemotion mass-centre`: a recording of trunk and legs in, the centre of mass of the body out."""

import csv
import json

import numpy as np
import typer

from app import readers
from app.commands.options.recordings import MassCentreOptions
from app.errors import InvalidInput
from app.readers.tables.schemas import CsvMapping
from estimators import pipelines
from estimators.balance import MASS_SCALARS, has_mass_centre
from estimators.body import body_from_stature
from estimators.conventions import PLACEMENTS
from estimators.pipelines import SessionSetup


def mass_centre(options: MassCentreOptions) -> None:
    """Estimate the centre of mass and write `mass_centre.csv` and `mass_centre.json`.

    Raises
    ------
    InvalidInput
        When the sensors that are needed are not worn.
    """
    columns = CsvMapping.model_validate_json(options.mapping.read_text()) if options.mapping else None
    measured, out = readers.read(options.recording, options.format, columns), options.out
    worn = tuple(name for name in measured.placements if name in PLACEMENTS)
    if not has_mass_centre(worn):
        raise InvalidInput(
            "the centre of mass needs sensors on both thighs and on the sternum or the pelvis; the recording has "
            + (", ".join(measured.placements) or "none")
        )
    setup = SessionSetup(
        pipeline="arm",
        placements=worn,
        rate_hz=options.rate_hz or measured.nominal_rate_hz,
        body=body_from_stature(options.stature_m),
    )
    frames, used = pipelines.run(measured, setup, options.pose_s)
    found = frames.scalar[:, [frames.layout.scalars.index(name) for name in MASS_SCALARS]]
    out.mkdir(parents=True, exist_ok=True)
    with (out / "mass_centre.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", *MASS_SCALARS])
        writer.writerows(np.column_stack([frames.time_s, found]).round(5).tolist())
    assumed = [name for name in PLACEMENTS if name not in worn]
    known = np.asarray(np.isfinite(found[:, :3]).all(axis=1))
    content = {
        "assumed": assumed,
        "known_share": float(known.mean()) if len(known) else 0.0,
        "setup": used.to_dict(),
        **{
            name: {
                "mean": float(found[known, i].mean()),
                "least": float(found[known, i].min()),
                "most": float(found[known, i].max()),
            }
            for i, name in enumerate(MASS_SCALARS)
            if known.any()
        },
    }
    (out / "mass_centre.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    typer.echo(f"{frames.tick_count} ticks, {known.mean():.0%} known -> {out}")
    places, sigmas = np.split(found[known], 2, axis=1)
    for name, values, sigma in zip(MASS_SCALARS, places.T, sigmas.T, strict=False):
        if known.any():
            typer.echo(
                f"  {name:<26} {values.min():7.3f} to {values.max():7.3f} m, sigma {np.median(sigma):.3f} m"
            )
    typer.echo(f"  assumed, without a sensor: {', '.join(assumed) or 'none'}")
