"""English sentences of sessions, their results and tasks."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "job.analysis_failed": "Analysis failed: {reason}",
    "job.internal": "An internal error stopped this task and was logged. The recorded data is stored.",
    "job.unknown_kind": "This service cannot do tasks of the kind {kind}.",
    "job.memory": "This needs more memory than the {limit_bytes:gib.1} that one task may take. Split the recording and"
    " upload the parts.",
    "job.interrupted": "Interrupted; the task starts again.",
    "job.given_up": "The task was interrupted several times and is not tried again; the recorded data is stored.",
    "job.session_deleted": "The session of this task was deleted.",
    "table.endless_line": "The first line has no end; this is no table.",
    "table.not_utf8": "The file is not UTF-8 text. Save it as CSV in UTF-8 and upload it again.",
    "table.no_column": "The file has no column {missing:and}. It has: {present}. Correct the mapping.",
    "table.no_rows": "The file has a header but no rows.",
    "table.too_long": "The file holds more than {rows:number} rows for {columns:number} columns; split it into shorter"
    " recordings.",
    "table.not_a_number": "A value in the column {column} is not a number; the columns of the mapping must hold numbers"
    " only.",
    "table.ragged": "A row has another number of columns than the header; the file is damaged.",
    "table.unreadable": "The file cannot be read as a table; check the character between its columns and its encoding"
    " (UTF-8).",
    "table.in_columns": "{reason} (In the file: {columns:and}.)",
}

__all__ = ["ENGLISH"]
