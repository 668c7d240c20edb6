"""A module a format, each with one `Reader`; `app.readers.registry` finds them by looking here."""

from pkgutil import iter_modules


def names() -> tuple[str, ...]:
    """Return the names of all formats, without importing their readers."""
    return tuple(one.name for one in iter_modules(__path__))


__all__ = ["names"]
