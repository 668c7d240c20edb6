"""Which columns of a table hold what: from a file that a person wrote, or guessed; see docs/mappings.md."""

import json
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.errors import InvalidInput
from app.ingest.readers import guess_mapping
from app.recordings.schemas import CsvMapping


def mapping_from(path: Path) -> CsvMapping:
    """Read a mapping file.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InvalidInput
        It is no JSON, or says something that is no mapping; with the signal and its columns.
    """
    try:
        content = json.loads(path.read_text("utf-8"))
        return CsvMapping.model_validate(content)
    except ValidationError as error:
        raise InvalidInput(
            f"{path}: {'; '.join(_complaint(one, content) for one in error.errors())}"
        ) from None
    except ValueError as error:
        raise InvalidInput(f"{path} is no JSON file: {error}") from None


def guessed_mapping(recording: Path, out: Path, rate_hz: float | None) -> CsvMapping:
    """Guess the mapping of a table from its names, as the upload page does, and write it beside the results.

    Parameters
    ----------
    recording : Path
    out : Path
        Folder, made when absent; `mapping.json` is written there, also when it is not complete.
    rate_hz : float or None
        Of the samples, where no column holds the time.

    Raises
    ------
    InvalidInput
        The names do not tell everything; says which columns, and where to complete the mapping.
    """
    guess = guess_mapping(recording)
    if guess["time_column"] is None:
        guess["rate_hz"] = rate_hz or guess["rate_hz"]
    out.mkdir(parents=True, exist_ok=True)
    written = out / "mapping.json"
    written.write_text(json.dumps(guess, indent=2, ensure_ascii=False) + "\n", "utf-8")
    missing = _missing(guess)
    if missing:
        raise InvalidInput(f"{' '.join(missing)} Complete {written} and pass it with --mapping.")
    return CsvMapping.model_validate(guess)


def _missing(guess: dict[str, Any]) -> list[str]:
    found = []
    if not guess["signals"]:
        found.append("No three columns are named as x, y and z of an angular rate or an acceleration.")
    unplaced = [signal for signal in guess["signals"] if signal["placement"] is None]
    if unplaced:
        columns = "; ".join(", ".join(signal["columns"]) for signal in unplaced)
        found.append(f"These columns do not say where on the body the sensor is (placement): {columns}.")
    if guess["time_column"] is None and guess["rate_hz"] is None:
        found.append("No column looks like time and no line above the table tells a rate: give --rate.")
    return found


def _complaint(error: Any, content: Any) -> str:
    """Say what is wrong in a mapping file, with the columns of the signal it is about."""
    where = error["loc"]
    if len(where) > 1 and where[0] == "signals":
        signal = content["signals"][where[1]]
        columns = signal.get("columns") if isinstance(signal, dict) else None
        named = f" ({', '.join(map(str, columns))})" if isinstance(columns, list) else ""
        return f"signal {where[1] + 1}{named}, {'.'.join(map(str, where[2:]))}: {error['msg']}"
    return f"{'.'.join(map(str, where))}: {error['msg']}"


__all__ = ["guessed_mapping", "mapping_from"]
