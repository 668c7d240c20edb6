"""Tables of partitions: who may write for each, and how far its stream is stored."""

from datetime import datetime

from sqlalchemy import BigInteger, Integer, String
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
