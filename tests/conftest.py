"""The order of all tests, and which of them are slow."""

import pytest

from tests import costs


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what was measured to be slow, and put the files with slow tests first.

    Begun last, one of them would keep one of two processes idle.
    """
    listed = frozenset() if config.pluginmanager.has_plugin("costs") else costs.listed()
    for item in items:
        if costs.function_of(item.nodeid) in listed:
            item.add_marker(pytest.mark.slow)
    slow = {item.path for item in items if any(map(item.get_closest_marker, ("slow", "postgres")))}
    items.sort(key=lambda item: item.path not in slow)
