"""Which version this is."""

from importlib.metadata import PackageNotFoundError, version


def service_version() -> str:
    """Return the installed version, or `unknown` when run from a tree that was not installed."""
    try:
        return version("telemotion")
    except PackageNotFoundError:
        return "unknown"
