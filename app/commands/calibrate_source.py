"""`telemotion calibrate-source`: a bench recording and the places of the sensor in, the coils of a source out."""

import csv
import json
from pathlib import Path
from typing import Any

import typer

from app.commands.options.recordings import CalibrateOptions
from app.database.base import utc_now
from app.errors import InvalidInput
from app.kinds.magnetic.bench import Bench, coils_out, findings
from app.kinds.magnetic.source_schemas import MagneticSourceIn
from app.network.alignment import align_chunks
from app.readers import LogReader
from estimators.errors import SetupError
from estimators.pipelines import SessionSetup


def calibrate_source(options: CalibrateOptions) -> None:
    """Print where the sensor lay still; with places, find the coils and write them as JSON.

    Raises
    ------
    InvalidInput
        The file, the places or the description of the source cannot be, or no coils explain the pulses.
    """
    reader = LogReader(options.recording)
    parameters: dict[str, Any] = {
        "coil_turns": options.turns,
        "coil_radius_m": options.radius_cm / 100.0,
        "coil_offset_m": options.offset_cm / 100.0,
        "current_limit_a": options.current_limit_a,
    }
    if options.source:
        parameters["source"] = options.source
    declared = reader.declaration
    setup = SessionSetup(
        "relative_pose", declared.placements, declared.rate_hz, orientation_parameters=parameters
    )
    if "magnetometer" in declared.full_scales:
        parameters["full_scale_t"] = declared.full_scales["magnetometer"]
    ordered = sorted(reader.packets(), key=lambda pair: pair[0].sequence)
    try:
        bench = Bench(
            align_chunks((packet for _, packet in ordered), reader.declaration),
            setup,
            options.sensor or None,  # type: ignore[arg-type]
        )
    except SetupError as error:
        raise InvalidInput(f"{error}.") from error
    for number, one in enumerate(bench.to_schema(), start=1):
        where = "?" if one.position_m is None else " ".join(f"{value:6.3f}" for value in one.position_m)
        typer.echo(
            f"{number:3d}  {one.start_s:7.1f} to {one.end_s:7.1f} s  {min(one.pulses):3d} pulses  about {where} m"
        )
    if options.places is None:
        typer.echo(f"{len(bench.stops)} places; give them with --places to find the coils")
        return
    if not options.serial or options.out is None:
        raise InvalidInput("Give --serial, the serial number of the source, and --out, the file to write.")
    places = read_places(options.places)
    fit = bench.calibrate(places, options.ruler_mm / 1000.0)
    described = MagneticSourceIn(
        name=options.name or options.serial,
        serial=options.serial,
        coils=coils_out(fit.source),
        current_limit_a=options.current_limit_a,
        gain_sigma=fit.gain_sigma,
        found=findings(fit, sum(place is not None for place in places)),
        method="file",
        calibrated_at=utc_now(),
    )
    options.out.write_text(json.dumps(described.model_dump(mode="json"), indent=1) + "\n")
    typer.echo(
        f"field known to {100.0 * fit.gain_sigma:.2f} % an axis, places off by"
        f" {1000.0 * fit.place_residual_m:.1f} mm; written to {options.out}"
    )


def read_places(path: Path) -> list[tuple[float, float, float] | None]:
    """Return the places of a CSV file: x, y, z in metres a line, in the order of the stops; `-` for no place.

    Raises
    ------
    InvalidInput
        With the line that is not understood.
    """
    places: list[tuple[float, float, float] | None] = []
    with path.open(newline="") as file:
        for number, row in enumerate(csv.reader(file), start=1):
            cells = [cell.strip() for cell in row if cell.strip()]
            if not cells or (number == 1 and cells[0].lower().startswith("x")):
                continue
            if cells == ["-"]:
                places.append(None)
                continue
            try:
                x, y, z = (float(cell) for cell in cells)
            except ValueError as error:
                raise InvalidInput(
                    f"Line {number} of the places is not three numbers: x, y, z in metres."
                ) from error
            places.append((x, y, z))
    return places
