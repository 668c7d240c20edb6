"""The doses of a prescription over time: what held on a day, before and after each change."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.exercises.models import Prescription, PrescriptionChange

LEAST_HELD: Final = timedelta(hours=12)
_FIELDS: Final = ("repetitions", "sets", "times_per_week", "days", "times")


@dataclass(frozen=True)
class DoseThen:
    """A dose and the time in which it held.

    Attributes
    ----------
    start, end : datetime
        Half-open; `end` is None while nobody has changed it.
    days : tuple of int
        1 is Monday; empty: any day of the week.
    times : tuple of str
        By the clinic's clocks.
    """

    start: datetime
    end: datetime | None
    repetitions: int
    sets: int
    times_per_week: int
    days: tuple[int, ...]
    times: tuple[str, ...]


DoseHistory = Mapping[str, Sequence[DoseThen]]
"""Doses by prescription, oldest first."""


def doses_of(prescription: Prescription, changes: Iterable[PrescriptionChange] = ()) -> list[DoseThen]:
    """Return the doses of a prescription, oldest first; the last one is that of today.

    Parameters
    ----------
    changes : iterable of PrescriptionChange
        Its own, in any order. What is no part of the dose (band, limits, template) starts no new one.

    Notes
    -----
    A change says what its fields were before it, so the states are read backwards from the present one. A change
    before the prescription began has no time in which the earlier dose held.
    """
    state: dict[str, Any] = {name: getattr(prescription, name) for name in _FIELDS}
    found: list[DoseThen] = []
    end: datetime | None = None
    for change in sorted(changes, key=lambda one: one.number, reverse=True):
        before = {name: value for name, value in change.before.items() if name in _FIELDS}
        if not before:
            continue
        start = max(change.created_at, prescription.starts_at)
        if end is None or start < end:
            found.append(_then(state, start, end))
            end = start
        state |= before
    if end is None or prescription.starts_at < end:
        found.append(_then(state, prescription.starts_at, end))
    return found[::-1]


def lasting(doses: Sequence[DoseThen]) -> list[DoseThen]:
    """Return the doses that held for half a day or longer, and the present one: a slip that was mended is no history.

    Parameters
    ----------
    doses : sequence of DoseThen
        Of one prescription.
    """
    return [one for one in doses if one.end is None or one.end - one.start >= LEAST_HELD]


def dose_on(doses: Sequence[DoseThen], at: datetime) -> DoseThen:
    """Return the dose that held at a moment; before the first one, the first.

    Parameters
    ----------
    doses : sequence of DoseThen
        Of one prescription, oldest first; not empty.
    """
    return next((one for one in reversed(doses) if one.start <= at), doses[0])


def dose_histories(session: Session, prescriptions: Iterable[Prescription]) -> dict[str, list[DoseThen]]:
    """Return the doses of prescriptions over time, by prescription; access was checked."""
    given = list(prescriptions)
    changes: dict[str, list[PrescriptionChange]] = defaultdict(list)
    wanted = PrescriptionChange.prescription_id.in_([one.id for one in given])
    for change in session.scalars(select(PrescriptionChange).where(wanted)):
        changes[change.prescription_id].append(change)
    return {one.id: doses_of(one, changes[one.id]) for one in given}


def _then(state: dict[str, Any], start: datetime, end: datetime | None) -> DoseThen:
    return DoseThen(
        start,
        end,
        state["repetitions"],
        state["sets"],
        state["times_per_week"],
        tuple(state["days"] or ()),
        tuple(state["times"] or ()),
    )
