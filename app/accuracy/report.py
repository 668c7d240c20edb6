"""The report that `telemotion validate` makes: results, and what they were measured with."""

import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from os import cpu_count

from app.accuracy.schemas import AccuracyProtocol, AccuracyReport
from estimators import validation
from estimators.validation import ProtocolResult


def make_report(
    results: Sequence[ProtocolResult], *, seeds: int, command: str, data: Sequence[str] = ()
) -> AccuracyReport:
    """Wrap results with what they were measured with.

    Parameters
    ----------
    results : sequence of ProtocolResult
    seeds : int
    command : str
        As typed.
    data : sequence of str
        Names of the recordings.
    """
    return AccuracyReport(
        version=_version(),
        made_at=datetime.now(UTC).replace(microsecond=0),
        command=command,
        seeds=seeds,
        machine=_machine(),
        data=list(data),
        seconds=round(sum(result.seconds for result in results), 1),
        passed=all(result.passed for result in results),
        protocols=[AccuracyProtocol.model_validate(entry) for entry in validation.to_data(results)],
    )


def _version() -> str:
    try:
        return version("telemotion")
    except PackageNotFoundError:
        return "unknown"


def _machine() -> str:
    """Return the kind of machine, without its name."""
    python = f"{platform.python_implementation()} {platform.python_version()}"
    return f"{platform.system()} {platform.machine()}, {cpu_count()} cores, {python}"


__all__ = ["make_report"]
