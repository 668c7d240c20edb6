"""Which failed tests a second run may decide: those of `tests/again.txt`, each with its reason.

A plugin of pytest for the run after `make test` that is made with `--last-failed`. Until whole runs pass beside others,
tests that are not listed run again too, and are named: with `TELEMOTION_LISTED_ONLY` set the second run ends before its
first test where one of them failed.
"""

import os
from pathlib import Path

import pytest

from tests.costs import function_of

AGAIN_FILE = Path(__file__).with_name("again.txt")
MOST_AGAIN = 5


def listed(text: str) -> dict[str, str]:
    """Return the reason of each listed test function; a line is a node id, a space, and the reason."""
    lines = (line.partition(" ") for line in text.splitlines())
    return {function: reason.strip() for function, _, reason in lines}


def pytest_collection_finish(session: pytest.Session) -> None:
    """Name failed tests that are not listed; end the run where only listed ones may run again."""
    cache = session.config.cache
    assert cache is not None
    failed = {*cache.get("cache/lastfailed", {}), *(item.nodeid for item in session.items)}
    may_run_again = listed(AGAIN_FILE.read_text())
    others = sorted(name for name in failed if function_of(name) not in may_run_again)
    if not others:
        return
    words = "\n  ".join(["these tests failed, and tests/again.txt does not list them:", *others])
    if os.environ.get("TELEMOTION_LISTED_ONLY"):
        pytest.exit(words, 1)
    session.config.get_terminal_writer().line(f"\n{words}")
