"""The order of all tests, which of them are slow, and which of them drive a browser."""

import gc

import pytest

from tests import costs

BROWSER_TESTS = "tests/e2e/"

# What is made while tests are imported stays: looking for garbage in it takes a tenth of the time.
gc.disable()


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop() -> None:
    gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what was measured to be slow and what drives a browser, and put the files with slow tests first.

    Begun last, one of them would keep one of two processes idle. A browser leaves its event loop running in the process
    of the tests, where those that begin a loop of their own fail: the browser tests run apart.
    """
    listed = frozenset() if config.getoption("--write-slow", False) else costs.listed()
    slow = set()
    for item in items:
        if costs.function_of(item.nodeid) in listed:
            item.add_marker(pytest.mark.slow)
        if item.nodeid.startswith(BROWSER_TESTS):
            item.add_marker(pytest.mark.e2e)
        if any(map(item.get_closest_marker, ("slow", "postgres"))):
            slow.add(file_of(item))
    items.sort(key=lambda item: file_of(item) not in slow)


def file_of(item: pytest.Item) -> str:
    """Return the file of a test as its node id names it."""
    return item.nodeid.partition("::")[0]
