"""Time zones by their IANA names, and the weeks that begin in them."""

from datetime import UTC, datetime, time, timedelta, tzinfo
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError, available_timezones

UTC_NAME = "UTC"
_LOCAL_TO_A_MACHINE = {"localtime", "Factory"}
"""Names that databases of time zones hold beside those of places."""


def is_time_zone(name: str) -> bool:
    """Return whether a name is one of a time zone."""
    return name == UTC_NAME or (name in available_timezones() and name not in _LOCAL_TO_A_MACHINE)


def time_zone(name: str) -> tzinfo:
    """Return a time zone; UTC where the machine does not know it.

    Parameters
    ----------
    name : str
        Checked by `is_time_zone`, perhaps on another machine: a restored clinic must be readable on one that has no
        database of time zones, or an older one.
    """
    try:
        return UTC if name == UTC_NAME else ZoneInfo(name)
    except ZoneInfoNotFoundError:
        return UTC


def week_start(moment: datetime, zone: tzinfo) -> datetime:
    """Return when the week of a moment began: Monday 00:00 by the clocks of a place.

    Parameters
    ----------
    moment : datetime
        With a zone.

    Returns
    -------
    datetime
        In UTC. A week in which clocks are changed is an hour shorter or longer than others.
    """
    day = moment.astimezone(zone).date()
    monday = day - timedelta(days=day.weekday())
    return datetime.combine(monday, time(), zone).astimezone(UTC)
