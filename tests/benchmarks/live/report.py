"""What a live load showed, as a table, and whether that is what is required."""

import platform
from typing import Any

import numpy as np
import psutil

from tests.benchmarks.live.load import Opened, Outcome
from tests.benchmarks.live.watching import MB, Memory
from tests.benchmarks.machine import processor

FEW_SESSIONS, FEW_LIMIT_MS, LIMIT_MS = 50, 15.0, 50.0
"""The 99th percentile from a packet to its frame, for up to so many sessions and for more."""
LIMIT_CPU_MS = 3.5
"""Of a processor, for a second of a session."""
LIMIT_STORED_MB = 50.0
"""A session hour, of packets and live frames together."""
LIMIT_SESSION_MB = 4.0
"""Of the service's memory."""
SETTLED_MINUTES = 3.0
"""What sessions remember of their last minutes is full by then."""
LIMIT_GROWTH_MB = 0.3
"""Of the service's memory in a minute, after that."""


def verdict(is_met: bool) -> str:
    """Say whether a requirement is met."""
    return "met" if is_met else "MISSED"


def judge(judged: dict[str, tuple[bool, str]]) -> bool:
    """Print each requirement and what was found; True when all are met."""
    for what, (is_met, found) in judged.items():
        print(f"required  {what}: {verdict(is_met)} with {found}")
    return all(is_met for is_met, _ in judged.values())


def row(name: str, values: Any) -> str:
    """Return percentiles as a line of the table."""
    found = np.asarray(values)
    p = np.percentile(found, [50, 95, 99])
    return f"{name:<44}{p[0]:9.2f}{p[1]:9.2f}{p[2]:9.2f}{found.max():9.2f}"


def heading(of: str = "latency, ms") -> str:
    """Return the heading of lines of `row`."""
    return f"\n{of:<44}{'p50':>9}{'p95':>9}{'p99':>9}{'max':>9}"


def machine() -> str:
    """Return what it was measured on."""
    frequency = psutil.cpu_freq()
    rest = f", {frequency.current:.0f} MHz" if frequency else ""
    return f"{platform.node()}, {psutil.cpu_count()} cores, {processor()}{rest}"


def print_load(outcome: Outcome, opened: Opened, seconds: float) -> None:
    """Print what was sent, how late it was shown and what it took."""
    counts = {name: sum(part.name == name for part in opened.parts) for name in outcome.of_part}
    print(f"\nmachine   {machine()}")
    print(
        f"load      {', '.join(f'{count} {name}' for name, count in counts.items())}; {seconds:.0f} s,",
        end="",
    )
    print(f" {outcome.sent} packets, {len(outcome.published_ms)} frame blocks measured")
    print(heading())
    print(row("packet sent -> frame published", outcome.published_ms))
    print(row("packet sent -> frame at the dashboard", outcome.received_ms))
    if len(counts) > 1:
        for name, found in outcome.of_part.items():
            print(row(f"  published, {name}", found.published_ms))
    # Overloaded, a session may have shown nothing.
    known = [one for one in outcome.health.values() if one.latency_ms_median is not None]
    medians = [one.latency_ms_median for one in known]
    highs = [one.latency_ms_p99 or np.nan for one in known]
    print(
        f"{'packet read -> published, by the service':<44}{np.median(medians):9.2f}{'':>9}{max(highs):9.2f}"
        "   (median of sessions, worst session)"
    )
    print(row("load generator late", outcome.late_ms))
    print(
        f"\nCPU       service with its processes {100 * outcome.server_cpu:.0f} %,"
        f" load {100 * outcome.load_cpu:.0f} % of one core"
    )


def stored_mb(kept: dict[str, tuple[int, int, int]], streamed_s: float) -> float:
    """Print what is stored of so many seconds of all sessions together; return it in MB a session hour."""
    hours = streamed_s / 3600.0
    for kind, (chunks, ticks, size) in kept.items():
        print(
            f"stored    {kind:<7}{chunks:7d} chunks {ticks:9d} ticks {size / MB:8.1f} MB"
            f" {size / MB / hours:7.1f} MB per session hour"
        )
    return sum(size for _, _, size in kept.values()) / MB / hours


def judge_load(
    outcome: Outcome, sessions: int, in_database: int, mb_an_hour: float
) -> dict[str, tuple[bool, str]]:
    """Return what is required of any load, and what was found."""
    high = float(np.percentile(outcome.published_ms, 99))
    limit_ms = FEW_LIMIT_MS if sessions <= FEW_SESSIONS else LIMIT_MS
    cpu_ms = 1e3 * outcome.server_cpu / sessions
    return {
        "every packet stored": (in_database == outcome.sent > 0, f"{in_database} of {outcome.sent}"),
        f"p99 below {limit_ms:.0f} ms": (high < limit_ms, f"{high:.1f} ms"),
        f"at most {LIMIT_CPU_MS} ms of a processor a session-second": (
            cpu_ms <= LIMIT_CPU_MS,
            f"{cpu_ms:.1f} ms",
        ),
        f"at most {LIMIT_STORED_MB:.0f} MB stored a session hour": (
            mb_an_hour <= LIMIT_STORED_MB,
            f"{mb_an_hour:.1f} MB",
        ),
    }


def judge_memory(memory: Memory, sessions: int) -> dict[str, tuple[bool, str]]:
    """Print the memory of the service; return what is required of it, and what was found."""
    first, last = memory.minutes[0][1], memory.minutes[-1][1]
    a_session, growth = memory.a_session_mb(sessions), memory.growth_mb(SETTLED_MINUTES)
    print(
        f"memory    idle {memory.idle_mb:.0f} MB, first {first:.0f}, last {last:.0f}; {a_session:.2f} MB a session"
    )
    found = {
        f"at most {LIMIT_SESSION_MB:.0f} MB of memory a session": (
            a_session <= LIMIT_SESSION_MB,
            f"{a_session:.2f} MB",
        )
    }
    if np.isfinite(growth):
        what = f"less than {LIMIT_GROWTH_MB} MB of growth a minute after minute {SETTLED_MINUTES:.0f}"
        found[what] = (growth < LIMIT_GROWTH_MB, f"{growth:.2f} MB")
    return found


def list_slow(outcome: Outcome) -> None:
    """Print stretches of slow packets: from, for how long, how many, the worst."""
    latency, sent = outcome.published_ms, outcome.sent_s
    slow = np.sort(sent[latency > 25.0])
    for group in np.split(slow, np.flatnonzero(np.diff(slow) > 0.2) + 1):
        if group.size:
            worst = latency[(sent >= group[0]) & (sent <= group[-1])].max()
            print(
                f"slow at {group[0]:7.2f} s for {group[-1] - group[0]:5.2f} s: {group.size:4d} packets, {worst:6.1f} ms"
            )
