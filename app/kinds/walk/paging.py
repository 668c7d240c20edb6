"""A walk of hours in answers of bounded size: its beginning with the numbers of all of it, and its strides in pages."""

from typing import Final

from app.kinds.walk.schemas import BalanceOut, FootOut, FootStride, WalkContent
from app.pages import Page

FIRST_STRIDES: Final = 200
"""Of each foot, in the answer with the numbers: a walk of about four minutes is whole."""
MOST_PATH: Final = 5_000
"""Places of a path, which is drawn and not measured from."""


def beginning(content: WalkContent) -> WalkContent:
    """Return a walk with its numbers whole, and of its lists what belongs to the first strides."""
    feet = [_first(foot) for foot in content.feet]
    is_whole = all(len(foot.strides) == foot.stride_count for foot in feet)
    balance = content.balance
    if balance is not None and not is_whole:
        balance = _until(balance, max(foot.footholds[-1].stop_s for foot in feet if foot.footholds))
    return content.model_copy(update={"feet": feet, "balance": balance})


def page_of(content: WalkContent, page: Page) -> list[FootStride]:
    """Return a page of the strides of both feet, in the order of their contacts."""
    strides = [
        FootStride.model_construct(side=foot.side, **dict(one))
        for foot in content.feet
        for one in foot.strides
    ]
    place = lambda one: [one.contact_s or 0.0, one.side, one.number]  # noqa: E731
    return page.cut(sorted(strides, key=place), place)


def thinned(path_m: list[list[float]]) -> list[list[float]]:
    """Return every n-th place of a path, so that at most `MOST_PATH` are left."""
    return path_m[:: max(1, -(-len(path_m) // MOST_PATH))]


def _first(foot: FootOut) -> FootOut:
    return foot.model_copy(
        update={
            "stride_count": len(foot.strides),
            "counted_count": sum(one.is_counted for one in foot.strides),
            "strides": foot.strides[:FIRST_STRIDES],
            "footholds": foot.footholds[: FIRST_STRIDES + 1],
            "path_m": thinned(foot.path_m),
        }
    )


def _until(balance: BalanceOut, end_s: float) -> BalanceOut:
    count = sum(time_s <= end_s for time_s in balance.time_s)
    cut = {
        name: getattr(balance, name)[:count]
        for name in ("time_s", "centre_m", "centre_sigma_m", "pressure_m", "margin_m")
    }
    support = [one for one in balance.support if one.time_s <= end_s]
    return balance.model_copy(update={**cut, "support": support})
