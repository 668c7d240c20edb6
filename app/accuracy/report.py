"""The report that `telemotion validate` makes: results, and what they were measured with."""

import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from os import cpu_count
from typing import Final
from zlib import crc32

import validation
from app.accuracy.schemas import AccuracyProtocol, AccuracyReport
from validation import ProtocolResult

_SEEDS: Final = 1_000_000_000


def make_report(
    results: Sequence[ProtocolResult], *, seeds: int, first_seed: int, command: str, data: Sequence[str] = ()
) -> AccuracyReport:
    """Wrap results with what they were measured with.

    Parameters
    ----------
    command : str
        As typed.
    data : sequence of str
        Names of the recordings.
    """
    return AccuracyReport(
        version=own_version(),
        made_at=datetime.now(UTC).replace(microsecond=0),
        command=command,
        seeds=seeds,
        first_seed=first_seed,
        machine=_machine(),
        data=list(data),
        seconds=round(sum(result.seconds for result in results), 1),
        protocols=[AccuracyProtocol.model_validate(entry) for entry in validation.to_data(results)],
    )


def renewed(report: AccuracyReport, measured: AccuracyReport) -> AccuracyReport:
    """Return a report in which newer experiments stand for those of the same name.

    Parameters
    ----------
    report, measured : AccuracyReport
        The older one, of all experiments, and the newer one, of some.

    Returns
    -------
    AccuracyReport
        In the order of `validation.protocols`; what is no experiment any more, or has other figures now, is left out.
    """
    entries = {entry.name: entry for entry in [*report.protocols, *measured.protocols]}
    current = validation.from_data([entry.model_dump() for entry in entries.values()])
    protocols = [entries[result.name] for result in current]
    return report.model_copy(
        update={
            "version": measured.version,
            "made_at": measured.made_at,
            "data": sorted({*report.data, *measured.data}),
            "seconds": round(sum(entry.seconds for entry in protocols), 1),
            "protocols": protocols,
        }
    )


def own_version() -> str:
    """Return the version that is measured."""
    try:
        return version("telemotion")
    except PackageNotFoundError:
        return "unknown"


def fresh_seed() -> int:
    """Draw the first seed from the version: no setting of a version was chosen with its own seeds."""
    return crc32(own_version().encode()) % _SEEDS


def _machine() -> str:
    """Return the kind of machine, without its name."""
    python = f"{platform.python_implementation()} {platform.python_version()}"
    return f"{platform.system()} {platform.machine()}, {cpu_count()} cores, {python}"
