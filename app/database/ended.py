"""The register of what was ended for good: erasures, revocations and what was put right, apart from the database.

A backup is older than what came after it. Whoever was erased since, and whatever was revoked, must not come back with
a restore; so each such event of the audit trail is also a line of a file in the data folder, which a restore reads
(`app.assessment.records.ended_again`). A line holds identifiers and words, never names or measurements. The file is
written after the commit; what a crash in between lost of it is copied from the audit trail at the next
start, and every hour (`app.accounts.audit_reading.note_ended`). Every backup carries the register as it was then.
"""

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from app.settings import Settings

OPTION: Final = "register_of_ended"
"""Execution option of an engine: where its register lies."""
ENTRY: Final = "register"
"""Of a backup: the rows that are lines of the register."""

ACTIONS: Final = (
    "patient.erase",
    "session.delete",
    "session.move_in",
    "device_token.revoke",
    "grant.revoke",
    "consent.change",
    "account.switch_off",
    "account.switch_on",
    "account.password_change",
    "account.password_reset",
)
"""Of the audit trail: what ends something, and what withdraws such an end."""
_DETAILS: Final = ("purpose", "granted")


@dataclass(frozen=True)
class Ended:
    """One event.

    Attributes
    ----------
    action : str
        One of `ACTIONS`.
    at : str
        ISO 8601, UTC.
    details : dict
        Of a consent, for what it is and whether it was given.
    hash : str
        Of the event in the audit trail, by which it is known.
    """

    action: str
    at: str
    clinic_id: str
    patient_id: str | None
    resource_id: str | None
    hash: str
    details: dict[str, Any] = field(default_factory=dict)

    @property
    def moment(self) -> datetime:
        """When it was."""
        return datetime.fromisoformat(self.at)


def path_of(settings: Settings) -> Path:
    """Return where the register of a service lies."""
    return settings.data_dir / "ended.jsonl"


def of_event(row: Mapping[str, Any]) -> Ended | None:
    """Return what a row of the audit trail is in the register; None for what ends nothing.

    Parameters
    ----------
    row : mapping
        Columns of `audit_event`.
    """
    if row["action"] not in ACTIONS:
        return None
    return Ended(
        action=row["action"],
        at=row["at"].astimezone(UTC).isoformat(timespec="microseconds"),
        clinic_id=row["clinic_id"],
        patient_id=row["patient_id"],
        resource_id=row["resource_id"],
        hash=row["hash"],
        details={name: row["details"][name] for name in _DETAILS if name in row["details"]},
    )


def add(path: Path, entries: Iterable[Ended]) -> None:
    """Write what is not in a register yet, and note that it is known until now; makes the file when there is none.

    Raises
    ------
    OSError
        It cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    wanted = list(entries)
    known = {entry.hash for entry in read(path)} if wanted else set()
    lines = b"".join(_line(entry) for entry in wanted if entry.hash not in known)
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600)
    with os.fdopen(descriptor, "r+b") as file:
        end = file.seek(0, os.SEEK_END)
        if lines:
            if end and os.pread(file.fileno(), 1, end - 1) != b"\n":
                # The last line was cut off by a crash; it is in the audit trail too.
                lines = b"\n" + lines
            file.write(lines)
            file.flush()
            os.fsync(file.fileno())
    os.utime(path)


def read(path: Path) -> list[Ended]:
    """Return what a register holds, oldest first; nothing when there is none. Lines that are cut off are left out."""
    if not path.exists():
        return []
    return parse(path.read_bytes().splitlines())


def parse(lines: Iterable[bytes]) -> list[Ended]:
    """Return the events of lines, each once, oldest first; what is no whole line is left out."""
    found: dict[str, Ended] = {}
    for line in lines:
        try:
            entry = Ended(**json.loads(line))
        except (ValueError, TypeError):
            continue
        found.setdefault(entry.hash, entry)
    return sorted(found.values(), key=lambda entry: entry.at)


def lines_of(path: Path) -> list[bytes]:
    """Return the register as rows of a backup."""
    return [_line(entry).rstrip(b"\n") for entry in read(path)]


def _line(entry: Ended) -> bytes:
    return json.dumps(asdict(entry), separators=(",", ":")).encode() + b"\n"
