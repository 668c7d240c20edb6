"""`telemotion validate`: the published experiments, ours beside theirs."""

import sys
from pathlib import Path

import typer

from app.errors import InvalidInput
from app.ingest import readers
from estimators import validation
from estimators.recording import Recording


def validate(names: list[str] | None, seeds: int, data: Path | None, json: bool, list_only: bool) -> None:
    """Run protocols, print a table or JSON, and exit with 1 when one falls short.

    Parameters
    ----------
    names : list of str or None
        None runs all.
    seeds : int
        Simulated repetitions of each.
    data : Path or None
        Folder with BROAD recordings (`.mat`, `.hdf5`).
    json, list_only : bool
    """
    if list_only:
        for protocol in validation.protocols():
            typer.echo(f"{protocol.name:<32} {protocol.title}")
        return
    known = {protocol.name for protocol in validation.protocols()}
    unknown = set(names or ()) - known
    if unknown:
        raise InvalidInput(
            f"no protocol {', '.join(sorted(unknown))}; `telemotion validate --list` names them all"
        )
    recordings = _broad(data) if data else None
    results = validation.run(names, seeds, recordings)
    typer.echo(validation.to_json(results) if json else validation.to_table(results))
    if data is None and not json:
        typer.echo("Protocols on recordings were left out: give their folder with --data.")
    if not all(result.passed for result in results):
        sys.exit(1)


def _broad(folder: Path) -> dict[str, Recording]:
    files = sorted(path for path in folder.glob("*") if path.suffix in {".mat", ".hdf5"})
    if not files:
        raise InvalidInput(f"{folder} holds no .mat or .hdf5 recordings")
    return {path.stem: readers.read(path, "broad", None) for path in files}
