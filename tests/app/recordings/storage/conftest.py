"""A writer that commits soon."""

from collections.abc import Iterator

import pytest
from sqlalchemy import Engine

from app.recordings.signals.group_commit import GroupCommitWriter


@pytest.fixture
def writer(engine: Engine) -> Iterator[GroupCommitWriter]:
    writer = GroupCommitWriter(engine, commit_interval_s=0.01, chunk_s=0.03)
    writer.start()
    yield writer
    writer.close()
