"""The processor time of tests: which of them only `make test` runs, and the budget of each folder.

A plugin of pytest. Of a test function all cases are added up, with their set-up, teardown and ended child processes:
processor time, which other work on the machine changes little. What several tests share is charged to the first of
them, so fixtures that cost much are printed besides.

`make test-costs` measures the tests that are not marked slow. The costliest functions go into `tests/slow.txt` until
the rest fits into `MOST_QUICK_S`; what stands there is marked `slow` as if it were written at the test. What the rest
takes in each folder is the folder's budget, in `tests/budget.txt`. `make test-quick` names folders beyond theirs, by
their share of the whole, which is alike on a slow machine; `make test` names functions above `NEEDS_REASON_S` of which
nobody says why, by `@pytest.mark.slow("reason")`.
"""

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

SLOW_FILE = Path(__file__).with_name("slow.txt")
MOST_QUICK_S = 150.0
"""Of two processes; each imports all tests besides, for a quarter of a minute."""
COSTLY_FIXTURE_S = 1.0
BUDGET_FILE = Path(__file__).with_name("budget.txt")
NEEDS_REASON_S = 5.0
BEYOND = 1.5
"""Times its budget that a folder may take, and a hundredth of the whole besides."""


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


def folder_of(name: str) -> str:
    """Return the folder of a test, two below `tests` at most."""
    return "/".join(name.partition("::")[0].split("/")[:-1][:3])


def by_folder(costs: Mapping[str, float]) -> Counter[str]:
    """Return what the functions of each folder take."""
    found: Counter[str] = Counter()
    for name, cost in costs.items():
        found[folder_of(name)] += cost  # type: ignore[assignment]
    return found


def written(budget: Mapping[str, float]) -> str:
    """Return the text of `tests/budget.txt`: a line a folder, with its processor seconds."""
    return "".join(f"{budget[name]:7.1f} s {name}\n" for name in sorted(budget))


def budgets(text: str) -> dict[str, float]:
    """Return the budget of each folder, processor seconds."""
    return {name: float(cost) for cost, _, name in map(str.split, text.splitlines())}


def beyond(costs: Mapping[str, float], budget: Mapping[str, float]) -> list[str]:
    """Return a line for each folder whose share of what was measured is far beyond that of its budget.

    Only folders that were measured are compared, so a run of some folders compares these.
    """
    there = {name: budget.get(name, 0.0) for name in costs}
    whole, planned = sum(costs.values()), sum(there.values())
    if not whole or not planned:
        return []
    return [
        f"{name}: {cost / whole:.1%} of the processor time, its budget is {there[name] / planned:.1%}"
        for name, cost in sorted(costs.items())
        if cost / whole > BEYOND * there[name] / planned + 0.01
    ]


def reason_of(item: pytest.Item) -> str:
    """Return why a test is slow, as its marker says."""
    marker = item.get_closest_marker("slow")
    return str(marker.args[0]) if marker and marker.args else ""


def processor_s() -> float:
    """Return the processor time of this process and of its children that have ended."""
    return sum(os.times()[:4])


class Costs:
    """Measures where tests run, adds up where they are reported."""

    def __init__(self) -> None:
        self.functions: Counter[str] = Counter()
        self.fixtures: Counter[str] = Counter()
        self.marked: set[str] = set()
        self.explained: set[str] = set()

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
            if any(map(item.get_closest_marker, ("slow", "postgres", "e2e"))):
                report.user_properties.append(("is_marked", True))
            if reason_of(item):
                report.user_properties.append(("is_explained", True))
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "teardown":
            function = function_of(report.nodeid)
            for name, value in report.user_properties:
                if name == "processor_s":
                    self.functions[function] += float(value)  # type: ignore[arg-type]
                elif name == "fixture_s":
                    self.fixtures[value[0]] += value[1]  # type: ignore[index]
                elif name == "is_marked":
                    self.marked.add(function)
                elif name == "is_explained":
                    self.explained.add(function)

    def unmarked(self, without: Iterable[str] = ()) -> dict[str, float]:
        """Return the functions that no marker keeps out of `make test-quick`."""
        left_out = self.marked.union(without)
        return {name: cost for name, cost in self.functions.items() if name not in left_out}

    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        # Only when asked, and when all have run: of a part of the tests no list of all of them is made.
        is_whole = exitstatus == pytest.ExitCode.OK and not hasattr(session.config, "workerinput")
        if session.config.getoption("--write-slow") and is_whole:
            slow = too_costly(self.functions)
            SLOW_FILE.write_text("".join(f"{name}\n" for name in slow))
            BUDGET_FILE.write_text(written(by_folder(self.unmarked(slow))))

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        terminalreporter.section("processor time")
        if terminalreporter.config.getoption("--write-slow"):
            for found in (self.functions, self.fixtures, by_folder(self.functions)):
                for name, cost_s in found.most_common(40):
                    terminalreporter.line(f"{cost_s:7.1f} s {name}")
            chosen = too_costly(self.functions)
            terminalreporter.line(f"{self.functions.total():.0f} s in all; {len(chosen)} functions are slow")
        for line in beyond(by_folder(self.unmarked()), budgets(BUDGET_FILE.read_text())):
            terminalreporter.line(line)
        for name, cost_s in self.functions.most_common():
            if cost_s > NEEDS_REASON_S and name not in self.explained:
                terminalreporter.line(f"{cost_s:7.1f} s {name}: say why, in `@pytest.mark.slow`")


_BEGAN = pytest.StashKey[float]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--write-slow", action="store_true", help="write tests/slow.txt and tests/budget.txt")


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Costs(), "costs")
