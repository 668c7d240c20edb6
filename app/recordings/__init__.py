"""Stored sessions: raw packets, derived frames, results, events and long tasks."""

from app.recordings.chunks import RawPacket
from app.recordings.group_commit import GroupCommitWriter, WriterMetrics
from app.recordings.ranges import SequenceRanges
from app.recordings.store import iterate_frames, read_frames, read_packets, stored_ranges

__all__ = [
    "GroupCommitWriter",
    "RawPacket",
    "SequenceRanges",
    "WriterMetrics",
    "iterate_frames",
    "read_frames",
    "read_packets",
    "stored_ranges",
]
