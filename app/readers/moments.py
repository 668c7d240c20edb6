"""When a recording was made, where its file says so."""

from datetime import UTC, datetime, timedelta
from typing import Final

RECORDED_AT: Final = "recorded_at"
"""In the metadata of a recording: ISO 8601, UTC; absent where the file does not say it."""
_EARLIEST: Final = datetime(2000, 1, 1, tzinfo=UTC)
_AHEAD: Final = timedelta(days=1)
"""How far a clock may be ahead of ours."""


def is_possible(moment: datetime) -> bool:
    """Return whether something can have been recorded then: in this century, and not in the future.

    Parameters
    ----------
    moment : datetime
        With its zone; one without is not possible.
    """
    return moment.tzinfo is not None and _EARLIEST <= moment <= datetime.now(UTC) + _AHEAD


def moment_of(seconds: float) -> datetime | None:
    """Return the moment of a stamp; None where it counts from something else than 1970.

    Parameters
    ----------
    seconds : float
        Since the epoch, where it is one.
    """
    try:
        moment = datetime.fromtimestamp(seconds, UTC)
    except (ValueError, OverflowError, OSError):
        return None
    return moment if is_possible(moment) else None


def as_metadata(seconds: float) -> dict[str, str]:
    """Return what the metadata of a recording says of its first stamp; nothing where that is no moment.

    Parameters
    ----------
    seconds : float
        As of `moment_of`.
    """
    moment = moment_of(seconds)
    return {} if moment is None else {RECORDED_AT: moment.isoformat(timespec="milliseconds")}
