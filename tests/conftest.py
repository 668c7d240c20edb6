"""The order of all tests."""

import pytest


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files with slow tests first: begun last, one of them would keep one of two processes idle."""
    slow = {item.path for item in items if any(map(item.get_closest_marker, ("slow", "postgres")))}
    items.sort(key=lambda item: item.path not in slow)
