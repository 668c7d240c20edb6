"""The files of a result for a researcher: frames as Parquet and CSV, what their columns mean, how they were made."""

import hashlib
import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from app.recordings.columns import csv_cell, dictionary
from app.version import service_version
from estimators.pipelines import SessionSetup

_PIECE_BYTES: Final = 1 << 20
_ALWAYS: Final = ("pipeline", "placements", "rate_hz")
_APPLIES: Final = {
    "arm": ("orientation", "orientation_parameters", "body", "calibration", "constrain_joint_headings"),
    "orientation": ("orientation", "orientation_parameters", "calibration"),
    "gait": ("orientation_parameters", "feet_apart_m", "feet_apart_end_m"),
}
_LEARNT: Final = ("devices", "device_constants")


def setup_record(setup: SessionSetup) -> dict[str, Any]:
    """Return a setup in plain JSON types without the fields that do not apply to its pipeline.

    Parameters
    ----------
    setup : SessionSetup
        Of a pipeline without a list of its own: all fields.
    """
    values = setup.to_dict()
    wanted = _APPLIES.get(setup.pipeline)
    if wanted is None:
        return values
    columns = {name: values[name] for name in (*_ALWAYS, *wanted) if values[name] is not None}
    return columns | {name: values[name] for name in _LEARNT if values[name]}


def software() -> dict[str, str]:
    """Return name and version of what made a result."""
    return {"name": "telemotion", "version": service_version()}


def origin_of(recording: Path, format: str) -> dict[str, Any]:
    """Return what a result was made from: name, size and hash of the file, and the moment.

    Parameters
    ----------
    format : str
        As it was read.
    """
    found = hashlib.sha256()
    with recording.open("rb") as file:
        while piece := file.read(_PIECE_BYTES):
            found.update(piece)
    return {
        "software": software(),
        "made_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "input": {
            "name": recording.name,
            "bytes": recording.stat().st_size,
            "sha256": found.hexdigest(),
            "format": format,
        },
    }


def write_results(table: pa.Table, setup: SessionSetup, origin: dict[str, Any], out: Path) -> None:
    """Write `frames.parquet`, `frames.csv`, `columns.json` and `setup.json`; see docs/results.md.

    Parameters
    ----------
    table : pyarrow.Table
        Of `frames_table`.
    setup : SessionSetup
        As it was used.
    origin : dict
        Of `origin_of`.
    out : Path
        An existing folder.
    """
    pyarrow.parquet.write_table(table, out / "frames.parquet")
    pyarrow.csv.write_csv(
        table.rename_columns([csv_cell(name) for name in table.column_names]), out / "frames.csv"
    )
    for name, content in (
        ("columns.json", dictionary(table)),
        ("setup.json", {**origin, **setup_record(setup)}),
    ):
        (out / name).write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
