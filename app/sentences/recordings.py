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
}

__all__ = ["ENGLISH"]
