"""`telemotion validate`: the published experiments, ours beside theirs."""

import sys
from pathlib import Path

import typer

from app.accuracy.report import make_report
from app.errors import InvalidInput, RecordingFormatError
from app.ingest import readers
from estimators import validation
from estimators.recording import Recording
from estimators.validation import ProtocolResult

_SETS = ("broad", "pyshoe", "gaitmap", "gait_tracking", "qmt_mat")


def validate(
    names: list[str] | None,
    seeds: int,
    data: Path | None,
    json: bool,
    list_only: bool,
    out: Path | None,
    page: Path | None,
) -> None:
    """Run protocols, print a table or JSON, and exit with 1 when one falls short.

    Parameters
    ----------
    names : list of str or None
        None runs all.
    seeds : int
        Simulated repetitions of each.
    data : Path or None
        Folder with recordings of BROAD, qmt or of feet (`.mat`, `.hdf5`, `.csv`), also below it.
    json, list_only : bool
    out : Path or None
        Also write the report, with plots, to this file.
    page : Path or None
        Also write a Markdown page to this file.
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
    recordings = _recordings(data) if data else None
    results = validation.run(names, seeds, recordings, plots=json or out is not None, report=_progress)
    if json or out is not None:
        report = make_report(
            results, seeds=seeds, command=_command(names, seeds, data), data=sorted(recordings or {})
        ).model_dump_json(indent=1)
        if out is not None:
            out.write_text(report + "\n", encoding="utf-8")
        if json:
            typer.echo(report)
    if page is not None:
        text = validation.to_markdown(results, _command(names, seeds, data), sorted(recordings or {}))
        page.write_text(text, encoding="utf-8")
    if not json:
        typer.echo(validation.to_table(results))
        if data is None:
            typer.echo("Protocols on recordings were left out: give their folder with --data.")
    if not all(result.passed for result in results):
        sys.exit(1)


def _progress(result: ProtocolResult) -> None:
    """Say on standard error that one is done, so that the wait has an end in sight."""
    verdict = "pass" if result.passed else "FAIL"
    typer.echo(f"{result.name:<36} {verdict} {result.seconds:8.1f} s", err=True)


def _command(names: list[str] | None, seeds: int, data: Path | None) -> str:
    words = ["telemotion validate", *(names or ()), f"--seeds {seeds}"]
    return " ".join([*words, "--data FOLDER"] if data else words)


def _recordings(folder: Path) -> dict[str, Recording]:
    """Read every recording below a folder that some protocol can use; other files are passed over."""
    found = {}
    for path in sorted(path for path in folder.rglob("*") if path.suffix in {".mat", ".hdf5", ".csv"}):
        try:
            kind = readers.guess(path)
        except RecordingFormatError:
            continue
        if kind in _SETS:
            found[str(path.relative_to(folder).with_suffix(""))] = readers.read(path, kind)
    if not found:
        raise InvalidInput(f"{folder} holds no recordings of {', '.join(_SETS)}")
    return found
