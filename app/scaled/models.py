"""What the database knows of partitions: who may write for each, how far its stream is stored, where sessions stand."""

from datetime import datetime

from sqlalchemy import BigInteger, ForeignKey, Integer, LargeBinary, String
from sqlalchemy.orm import Mapped, mapped_column

from app.database.base import Base, UtcDateTime, utc_now


class PartitionHold(Base):
    """The newest holder of a partition of live sessions; empty where the service is one process."""

    __tablename__ = "partition_hold"

    partition: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    fencing: Mapped[int] = mapped_column(BigInteger)
    """Grows with every holder; a transaction of an earlier one is refused."""
    holder: Mapped[str] = mapped_column(String(64))
    position: Mapped[int] = mapped_column(BigInteger, default=0)
    """Everything of the stream up to and including this number is in the other tables."""
    updated_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now, onupdate=utc_now)


class LiveCheckpoint(Base):
    """Where the estimation of a live session stood, committed with the position of its stream."""

    __tablename__ = "live_checkpoint"

    session_id: Mapped[str] = mapped_column(
        ForeignKey("motion_session.id", ondelete="CASCADE"), primary_key=True
    )
    layout: Mapped[int] = mapped_column(Integer)
    """Of the data; one that is not that of the reader is left, see `app.live.session.checkpoint`."""
    sequence: Mapped[int] = mapped_column(BigInteger)
    """First packet that is not in it."""
    data: Mapped[bytes] = mapped_column(LargeBinary)
    updated_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now, onupdate=utc_now)


__all__ = ["LiveCheckpoint", "PartitionHold"]
