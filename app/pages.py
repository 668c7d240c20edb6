"""Pages of the lists that grow with use: a patient's sessions, the audit trail, the patients themselves.

A list answers `limit` rows and, while there are more, the header `Link: <address>; rel="next"` (RFC 8288). The address
holds `after`: the place of the last row in the list's order, sealed, so that nothing about a patient stands in an
address and nobody can make one up. What follows is asked for by that place and not by counting rows: rows that come
or go between two pages neither repeat nor hide others.

A list takes part with three words: its route takes `WantedPage`, its query goes through `rows_of` (or, where the order
is worked out and not stored, its rows through `Page.cut`), and the description says the rest by itself.
"""

import base64
import json
import secrets
from bisect import bisect_right
from collections.abc import Callable, Sequence
from datetime import datetime
from typing import Annotated, Any, Final, TypeAlias, TypeVar

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305
from fastapi import Depends, Query, Request, Response
from sqlalchemy import Select, literal, tuple_
from sqlalchemy.orm import InstrumentedAttribute, Session
from sqlalchemy.sql.elements import ColumnElement

from app.errors import InvalidInput
from app.services import services_of
from app.settings import Settings
from estimators.sentences import say

ROWS: Final = 50
"""Rows of a page when the request does not say."""
MOST_ROWS: Final = 200

_NONCE_BYTES: Final = 12

Place: TypeAlias = list[Any]
"""A row's values in the columns that order the list."""
_Row = TypeVar("_Row")


class Page:
    """Which part of a list is wanted, and where the next one begins.

    Parameters
    ----------
    limit : int, optional
        Most rows; without it the whole list, for code of the service that needs it whole.
    after : list, optional
        The row before the first; without it the list is read from its beginning.
    more : callable(list), optional
        Called with the place of the page's last row when others follow.
    """

    def __init__(
        self,
        limit: int | None = None,
        after: Place | None = None,
        more: Callable[[Place], None] | None = None,
    ) -> None:
        self.limit = limit
        self.after = after
        self._more = more

    def end(self, rows: Sequence[Any], place: Callable[[Any], Place]) -> int:
        """Return how many of the rows belong to the page, and tell where the next one begins.

        Parameters
        ----------
        rows : sequence
            One more than `limit`, where there are so many.
        place : callable
            Row to its place.
        """
        if self.limit is None or len(rows) <= self.limit:
            return len(rows)
        if self._more is not None:
            self._more(place(rows[self.limit - 1]))
        return self.limit

    def cut(self, rows: Sequence[_Row], place: Callable[[_Row], Place]) -> list[_Row]:
        """Return the page of a list whose order is worked out in memory.

        Parameters
        ----------
        rows : sequence
            All, ascending by `place`.
        place : callable
            Row to its place, unlike every other row's.
        """
        start = 0 if self.after is None else bisect_right(rows, self.after, key=place)
        rest = rows[start:]
        return list(rest[: self.end(rest, place)])


def rows_of(
    session: Session,
    query: Select[*tuple[Any, ...]],
    order: Sequence[ColumnElement[Any] | InstrumentedAttribute[Any]],
    page: Page,
    *,
    newest_first: bool = False,
) -> list[tuple[Any, ...]]:
    """Return a page of a query's rows.

    Parameters
    ----------
    query : Select
        Already limited to what the subject may see; without an order.
    order : sequence of column
        The list's order; together unlike in every two rows, none of them null.
    newest_first : bool
        Descending, by all columns.

    Returns
    -------
    list of tuple
        With the query's own columns only.

    Raises
    ------
    InvalidInput
        The page does not begin at a place of this list.
    """
    if page.after is not None:
        if len(page.after) != len(order):
            raise _unknown()
        place = tuple_(
            *(literal(_read(value), column.type) for value, column in zip(page.after, order, strict=True))
        )
        query = query.where(tuple_(*order) < place if newest_first else tuple_(*order) > place)
    query = query.order_by(*(column.desc() if newest_first else column.asc() for column in order))
    if page.limit is not None:
        query = query.limit(page.limit + 1)
    width = len(query.column_descriptions)
    keyed = query.add_columns(*(column.label(f"page_{number}") for number, column in enumerate(order)))
    rows = session.execute(keyed).all()
    count = page.end(rows, lambda row: [_written(value) for value in row[width:]])
    return [row[:width] for row in rows[:count]]


def _written(value: Any) -> Any:
    """Return a value as JSON can hold it; times say that they are times."""
    return {"at": value.isoformat()} if isinstance(value, datetime) else value


def _read(value: Any) -> Any:
    return datetime.fromisoformat(value["at"]) if isinstance(value, dict) else value


async def wanted_page(
    request: Request,
    response: Response,
    limit: Annotated[int, Query(ge=1, le=MOST_ROWS, description="Most rows of this page.")] = ROWS,
    after: Annotated[
        str | None,
        Query(max_length=4000, description="From the header `Link` of the page before; not to be made up."),
    ] = None,
) -> Page:
    """Read the page that a request wants; the answer gets its `Link` when there is more.

    Raises
    ------
    InvalidInput
        `after` is not from a page of this list.
    """
    settings, path = services_of(request).settings, request.url.path

    def more(place: Place) -> None:
        following = request.url.include_query_params(limit=limit, after=_sealed(settings, path, place))
        response.headers["Link"] = f'<{path}?{following.query}>; rel="next"'

    return Page(limit, None if after is None else _opened(settings, path, after), more)


WantedPage = Annotated[Page, Depends(wanted_page)]


# Names of patients are places of their list, and addresses are written down by proxies: a place is encrypted. The path
# is authenticated with it and binds it to its list: a place in one patient's sessions is none in another's.


def _sealed(settings: Settings, path: str, place: Place) -> str:
    nonce = secrets.token_bytes(_NONCE_BYTES)
    text = json.dumps(place, separators=(",", ":")).encode()
    sealed = _cipher(settings).encrypt(nonce, text, path.encode())
    return base64.urlsafe_b64encode(nonce + sealed).decode().rstrip("=")


def _opened(settings: Settings, path: str, after: str) -> Place:
    try:
        raw = base64.b64decode(after + "=" * (-len(after) % 4), altchars=b"-_", validate=True)
        text = _cipher(settings).decrypt(raw[:_NONCE_BYTES], raw[_NONCE_BYTES:], path.encode())
    except (ValueError, InvalidTag):
        raise _unknown() from None
    place: Place = json.loads(text)
    return place


def _cipher(settings: Settings) -> ChaCha20Poly1305:
    return ChaCha20Poly1305(settings.key_for("page-place"))


def _unknown() -> InvalidInput:
    return InvalidInput(say("edge.no_such_page"), field="after")
