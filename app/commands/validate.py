"""`telemotion validate`: the published experiments, ours beside theirs."""

import multiprocessing
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import typer

import validation
from app import readers
from app.accuracy import AccuracyReport
from app.accuracy.report import fresh_seed, make_report, renewed
from app.commands.options.validate import ValidateOptions
from app.errors import InvalidInput
from app.readers.tables.schemas import CsvMapping
from estimators.recording import Recording, SensorSignals
from validation import ProtocolResult, Values


def validate(options: ValidateOptions) -> None:
    """Run protocols, print a table or JSON, and exit with 1 when one falls short of what is required."""
    names, into, data = options.names or None, options.into, options.data
    if options.out is not None and into is not None:
        raise InvalidInput("give --out or --into, not both")
    if into is not None and not into.is_file():
        raise InvalidInput(f"there is no report {into}; --out writes a new one")
    if options.list_only:
        for protocol in validation.protocols():
            typer.echo(f"{protocol.name:<32} {protocol.title}")
        return
    known = {protocol.name for protocol in validation.protocols()}
    unknown = set(names or ()) - known
    if unknown:
        raise InvalidInput(
            f"no protocol {', '.join(sorted(unknown))}; `telemotion validate --list` names them all"
        )
    # Before minutes or hours of measuring: what cannot be read or written is said now.
    earlier = AccuracyReport.model_validate_json(into.read_bytes()) if into is not None else None
    recordings = _recordings(data) if data else {}
    first, target = options.first_seed, into or options.out
    if first is None:
        first = fresh_seed()
    drawn = range(first, first + options.seeds)
    results = _run(names, drawn, recordings, options.processes, plots=options.json or target is not None)
    report = make_report(
        results,
        seeds=options.seeds,
        first_seed=first,
        command=_command(options),
        data=sorted(recordings),
    )
    if earlier is not None:
        report = renewed(earlier, report)
    if target:
        target.write_text(report.model_dump_json(indent=1) + "\n", encoding="utf-8")
    if options.json:
        typer.echo(report.model_dump_json(indent=1))
    if options.page is not None:
        shown = validation.from_data([entry.model_dump() for entry in report.protocols])
        options.page.write_text(validation.to_markdown(shown, report.command, report.data), encoding="utf-8")
    if not options.json:
        typer.echo(validation.to_table(results))
        if data is None:
            typer.echo("Protocols on recordings were left out: give their folder with --data.")
    if any(result.verdict == "short" for result in results):
        sys.exit(1)


def _run(
    names: list[str] | None, seeds: range, data: Mapping[str, Recording], processes: int, *, plots: bool
) -> list[ProtocolResult]:
    """Repeat the experiments; batches of seeds are shared among processes, those on recordings stay in this one."""
    chosen = validation.chosen(names, len(seeds), data, seeds.start)
    if processes == 1:
        return validation.run(names, len(seeds), data, first_seed=seeds.start, plots=plots, report=_progress)
    results = []
    # A worker begins again: a fork of a process with threads may stand still.
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool:
        waiting = [
            [pool.submit(_batch, protocol.name, part) for part in validation.parts_of(protocol, seeds)]
            if not protocol.needs_data
            else None
            for protocol, _ in chosen
        ]
        for (protocol, given), tasks in zip(chosen, waiting, strict=True):
            if tasks is None:
                parts = [validation.measured(protocol, seeds, given)]
            else:
                parts = [task.result() for task in tasks]
            curves = protocol.plots(given) if plots and protocol.plots is not None else ()
            results.append(validation.gather(protocol, seeds, parts, curves))
            _progress(results[-1])
    return results


def _batch(name: str, seeds: Sequence[int]) -> tuple[Values, float]:
    (protocol,) = (one for one in validation.protocols() if one.name == name)
    return validation.measured(protocol, seeds, {})


def _progress(result: ProtocolResult) -> None:
    """Say on standard error that one is done, so that the wait has an end in sight."""
    typer.echo(f"{result.name:<36} {result.verdict:<5} {result.seconds:8.1f} s", err=True)


def _command(options: ValidateOptions) -> str:
    words = ["telemotion validate", *(options.names or ()), f"--seeds {options.seeds}"]
    if options.first_seed is not None:
        words.append(f"--first-seed {options.first_seed}")
    return " ".join([*words, "--data FOLDER"] if options.data else words)


def _recordings(folder: Path) -> dict[str, Recording]:
    """Read every recording below a folder that some protocol can use; other files are passed over."""
    found: dict[str, Recording] = {}
    endings = {".mat", ".hdf5", ".csv", ".npz"}
    for path in sorted(path for path in folder.rglob("*") if path.suffix in endings):
        try:
            recording = _arrays(path) if path.suffix == ".npz" else _recording(path)
        except InvalidInput:
            continue
        if recording is not None:
            found[str(path.relative_to(folder).with_suffix(""))] = recording
    if not found:
        raise InvalidInput(f"{folder} holds no recording")
    return found


def _recording(path: Path) -> Recording | None:
    """Read a file of one of the sets, or a table that says itself what is in it; None of any other."""
    kind = readers.guess(path)
    if not readers.reader_of(kind).needs_mapping:
        return readers.read(path, kind)
    start, later = readers.start_of(path), readers.later_of(path)
    guess = readers.preview_text(path.name, start, "orientation", later=later).guess
    if guess is None or guess.missing or not guess.mapping["signals"]:
        return None
    return readers.read(path, "csv", CsvMapping.model_validate(guess.mapping))


def _arrays(path: Path) -> Recording | None:
    """Read `gyr` (rad/s), `acc` (m/s^2), `mag` (microtesla) and `sampling_rate`, as the vqf package has them."""
    with np.load(path) as content:
        if not {"gyr", "acc", "mag", "sampling_rate"} <= set(content.files):
            return None
        rate_hz = float(content["sampling_rate"])
        gyroscope, force, field = (content[name].astype(np.float64) for name in ("gyr", "acc", "mag"))
    time_s = np.arange(len(gyroscope)) / rate_hz
    signals = SensorSignals(time_s, gyroscope, force, 1e-6 * field)
    return Recording({"imu": signals}, rate_hz, metadata={"format": "vqf"})
