"""`make test-costs`: the processor time of each quick test, and which of them only `make test` runs.

A plugin of pytest. Of a test function all cases are added up, with their set-up, teardown and ended child processes:
processor time, which other work on the machine changes little. The costliest functions go into `tests/slow.txt` until
the rest fits into `MOST_QUICK_S`; what stands there is marked `slow` as if it were written at the test. What several
tests share is charged to the first of them, so fixtures that cost much are printed besides.
"""

import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

SLOW_FILE = Path(__file__).with_name("slow.txt")
MOST_QUICK_S = 150.0
"""Of two processes; each imports all tests besides, for a quarter of a minute."""
COSTLY_FIXTURE_S = 1.0


def function_of(node_id: str) -> str:
    """Return the name of a test without its case."""
    return node_id.split("[", 1)[0]


def listed() -> frozenset[str]:
    """Return the functions that are slow by measurement."""
    return frozenset(SLOW_FILE.read_text().split())


def too_costly(costs: dict[str, float], most_s: float = MOST_QUICK_S) -> list[str]:
    """Return the fewest functions without which the others take at most so long, by name."""
    chosen, rest = [], sum(costs.values())
    for name, cost in sorted(costs.items(), key=lambda one: (-one[1], one[0])):
        if rest <= most_s:
            break
        chosen.append(name)
        rest -= cost
    return sorted(chosen)


def processor_s() -> float:
    """Return the processor time of this process and of its children that have ended."""
    return sum(os.times()[:4])


class Costs:
    """Measures where tests run, adds up where they are reported."""

    def __init__(self) -> None:
        self.functions: Counter[str] = Counter()
        self.fixtures: Counter[str] = Counter()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        item.stash[_BEGAN] = processor_s()
        return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_fixture_setup(self, fixturedef: Any, request: pytest.FixtureRequest) -> Iterator[Any]:
        began_s = processor_s()
        try:
            return (yield)
        finally:
            took_s = processor_s() - began_s
            if fixturedef.scope != "function" and took_s >= COSTLY_FIXTURE_S:
                name = f"{request.node.nodeid or 'tests'}: {fixturedef.argname}"
                request._pyfuncitem.user_properties.append(("fixture_s", (name, took_s)))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: Any) -> Iterator[pytest.TestReport]:
        report: pytest.TestReport = yield
        if call.when == "teardown":
            report.user_properties.append(("processor_s", processor_s() - item.stash[_BEGAN]))
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "teardown":
            for name, value in report.user_properties:
                if name == "processor_s":
                    self.functions[function_of(report.nodeid)] += float(value)  # type: ignore[arg-type]
                elif name == "fixture_s":
                    self.fixtures[value[0]] += value[1]  # type: ignore[index]

    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        # Only when asked, and when all have run: of a part of the tests no list of all of them is made.
        is_whole = exitstatus == pytest.ExitCode.OK and not hasattr(session.config, "workerinput")
        if session.config.getoption("--write-slow") and is_whole:
            SLOW_FILE.write_text("".join(f"{name}\n" for name in too_costly(self.functions)))

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        terminalreporter.section("processor time")
        for found in (self.functions, self.fixtures):
            for name, cost_s in found.most_common(40):
                terminalreporter.line(f"{cost_s:7.1f} s {name}")
        chosen = too_costly(self.functions)
        terminalreporter.line(f"{self.functions.total():.0f} s in all; {len(chosen)} functions are slow")


_BEGAN = pytest.StashKey[float]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--write-slow", action="store_true", help="write tests/slow.txt from what this run took")


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Costs(), "costs")
