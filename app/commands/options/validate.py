"""Words of `telemotion validate`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer


@dataclass(frozen=True, kw_only=True)
class ValidateOptions:
    """Run the published experiments: published figure, required figure, ours. Exit code 1 when one falls short."""

    command: ClassVar[str] = "validate"
    runs: ClassVar[str] = "app.commands.validate:validate"

    names: Annotated[list[str] | None, typer.Argument(help="Protocols to run; all when none is named.")] = (
        None
    )
    seeds: Annotated[int, typer.Option(help="Simulated repetitions of each protocol.", min=1, max=1000)] = 20
    first_seed: Annotated[
        int | None,
        typer.Option(help="Use this seed and those after it; drawn from the version by default.", min=0),
    ] = None
    processes: Annotated[int, typer.Option(help="How many processes work at once.", min=1)] = 1
    data: Annotated[
        Path | None,
        typer.Option(
            help="Folder of recordings (BROAD, PyShoe, gaitmap, x-io); without, their protocols are left out."
        ),
    ] = None
    json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False
    list_only: Annotated[bool, typer.Option("--list", help="Only name the protocols.")] = False
    out: Annotated[
        Path | None, typer.Option(help="Also write the report with its plots to this JSON file.")
    ] = None
    page: Annotated[Path | None, typer.Option(help="Also write a Markdown page to this file.")] = None
    into: Annotated[
        Path | None,
        typer.Option(help="Put the results into this report of all protocols; --page is then of the whole."),
    ] = None
