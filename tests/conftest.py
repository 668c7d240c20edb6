"""The order of all tests, which of them are slow, and which of them drive a browser."""

from pathlib import Path

import pytest

from tests import costs

BROWSER_TESTS = Path(__file__).parent / "e2e"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what was measured to be slow and what drives a browser, and put the files with slow tests first.

    Begun last, one of them would keep one of two processes idle. A browser leaves its event loop running in the process
    of the tests, where those that begin a loop of their own fail: the browser tests run apart.
    """
    listed = frozenset() if config.pluginmanager.has_plugin("costs") else costs.listed()
    for item in items:
        if costs.function_of(item.nodeid) in listed:
            item.add_marker(pytest.mark.slow)
        if BROWSER_TESTS in item.path.parents:
            item.add_marker(pytest.mark.e2e)
    slow = {item.path for item in items if any(map(item.get_closest_marker, ("slow", "postgres")))}
    items.sort(key=lambda item: item.path not in slow)
