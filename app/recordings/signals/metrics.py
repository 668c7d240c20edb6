"""Counters of the group commit."""

from dataclasses import dataclass


@dataclass
class WriterMetrics:
    """Counters since the start; read without a lock, for `/metrics` and the bench."""

    packets_stored: int = 0
    packets_duplicate: int = 0
    packets_refused: int = 0
    frame_ticks_stored: int = 0
    frame_ticks_refused: int = 0
    chunks_written: int = 0
    bytes_written: int = 0
    commits: int = 0
    commit_failures: int = 0
    sessions_failed: int = 0
    queued_bytes: int = 0
    queued_bytes_highest: int = 0
    last_commit_s: float = 0.0
    """How long the last commit took, encoding included."""
    longest_commit_s: float = 0.0
