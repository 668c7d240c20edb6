"""The pieces of a table with one value a row that were looked at: its beginning, and parts of its rest."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.readers.tables.head import TableHead
from app.readers.tables.tall.samples import Order, order_of
from app.readers.tables.tall.signals import called_by
from app.readers.tables.units import Body


@dataclass(frozen=True)
class Piece:
    """Rows of a table that follow each other, those that name a signal.

    Attributes
    ----------
    texts : dict of str to ndarray, shape (N,)
        Of all columns.
    called : list of tuple of str
        What the names say of each row.
    stamps : ndarray, shape (N,), or None
    """

    texts: dict[str, NDArray[Any]]
    called: list[tuple[str, ...]]
    stamps: NDArray[Any] | None

    @staticmethod
    def of(body: Body, head: TableHead, chosen: tuple[str, ...], clock: str | None) -> "Piece":
        """Return the rows of a body; one that names nothing, or a head that stands again, is of no signal."""
        texts = {column: np.array(body.texts(column), dtype=str) for column in head.columns}
        called = called_by(texts, chosen, None)
        rows = np.array([any(one) and one != chosen for one in called], dtype=np.bool_)
        texts = {column: one[rows] for column, one in texts.items()}
        return Piece(texts, called_by(texts, chosen, None), None if clock is None else texts[clock])

    @property
    def first(self) -> list[tuple[str, ...]]:
        """The signals, as they come."""
        return list(dict.fromkeys(self.called))

    @property
    def signal(self) -> NDArray[np.intp]:
        """Of each row its place among them."""
        return self.numbered(self.first)

    @property
    def order(self) -> Order:
        """How the rows of a sample are found."""
        return order_of(self.signal, self.stamps)

    def numbered(self, signals: Sequence[tuple[str, ...]]) -> NDArray[np.intp]:
        """Return the place of each row among some signals, shape (N,)."""
        at = {one: number for number, one in enumerate(signals)}
        return np.array([at[one] for one in self.called], dtype=np.intp)
