"""Import of the packages beside this one, also in a folder that has an `app.py` of its own."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

_PLACE: Final = Path(__file__).parents[1]
_BESIDE: Final = ("app", "estimators", "messages", "migrations", "published", "validation")


@contextmanager
def make_room() -> Iterator[None]:
    """Let imports in this statement find the packages of this installation first.

    Raises
    ------
    ImportError
        Another module of one of these names was imported before.
    """
    for name in _BESIDE:
        found = sys.modules.get(name)
        file = getattr(found, "__file__", None)
        if found is not None and (file is None or _PLACE.resolve() not in Path(file).resolve().parents):
            raise ImportError(
                f"a module {name!r} of another project was imported before ({file}): import telemotion first"
            )
    sys.path.insert(0, str(_PLACE))
    try:
        yield
    finally:
        sys.path.remove(str(_PLACE))
