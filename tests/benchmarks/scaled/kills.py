"""Parts of a service on many machines are upgraded, then killed again and again in mid-stream: `make bench-kills`.

NATS, PostgreSQL, two edges and two workers as real processes on this machine; in this other process the gateways, one a
session in real time, and somebody who watches each. First every worker and then every edge is stopped in order and
started again with another version. Then SIGKILL comes at a moment drawn by chance and to a part drawn by chance. At the
end the gateways have forgotten what was acknowledged, so whatever was lost then is lost for good.

Required: every packet is stored once, in order, as it was sent; no session shows nothing new for longer than 2 s while
a part is upgraded; frames of all sessions go on 2 s after a worker's death and 5 s after a broker or a database starts
anew; what session 0 showed equals, tick for tick and bit for bit, what a service in one process shows of the same
packets.
"""

import argparse
import asyncio
import signal
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import psutil

from app.gateway import DeviceStream
from tests.app.live.live_load import swaying
from tests.benchmarks.crash import PERIOD_S
from tests.benchmarks.machine import processor
from tests.scaled.cluster import Cluster
from tests.scaled.database import Database
from tests.scaled.embedded import embedded_shown
from tests.scaled.killing import Kill, Run, streaming
from tests.scaled.streaming import Stored
from tests.scaled.upgrading import Upgrade, parts_of, upgrade

UPGRADE_GAP_S = 2.0
BEFORE_UPGRADE_S = 20.0
"""Longer than from one checkpoint to the next: there is one that another version cannot read."""

WITHIN_S: Mapping[str, float | None] = {"worker": 2.0, "edge": None, "nats": 5.0, "database": 5.0}
PARTS: Mapping[str, Sequence[str]] = {
    "worker": ("worker0", "worker1"),
    "edge": ("edge0", "edge1"),
    "nats": ("nats",),
    "database": ("database",),
}


@contextmanager
def cluster_of(folder: Path, calibration: dict[str, object]) -> Iterator[tuple[Cluster, Database]]:
    """Run a service on many machines in a folder."""
    # The path of its socket must be short.
    database = Database(folder / "pg")
    cluster = Cluster(folder, database.make(), calibration)
    try:
        cluster.begin()
        yield cluster, database
    finally:
        cluster.close()
        database.close()


def kind_of(name: str) -> str:
    """Return what kind of part it is."""
    return name.rstrip("0123456789")


async def run(
    cluster: Cluster,
    database: Database,
    stream: DeviceStream,
    sessions: int,
    names: Sequence[str],
    upgrades: int,
) -> tuple[Run, list[Upgrade], Stored]:
    """Stream, upgrade every part so many times, kill the named ones one after the other, and count."""
    random, upgraded = np.random.default_rng(1), []
    async with streaming(cluster, database, stream, sessions) as going:
        await asyncio.sleep(BEFORE_UPGRADE_S)
        for name in parts_of(cluster) * upgrades:
            one = await upgrade(going, name)
            upgraded.append(one)
            print(
                f"upgraded {name:<9} ended after {one.stop_s:.2f} s, all as before after {one.whole_s:.2f} s,"
                f" nothing new for {one.gap_s:.2f} s; load {psutil.getloadavg()[0]:.1f}",
                flush=True,
            )
        for number, name in enumerate(names, 1):
            await asyncio.sleep(random.uniform(1.0, 4.0))
            seen = await going.kill(name)
            print(
                f"{number:3d} of {len(names)}  {name:<9} shown again after {max(seen.shown_s):.2f} s,"
                f" nothing new for {seen.gap_s:.2f} s",
                flush=True,
            )
        await asyncio.sleep(3.0)
        stored = await going.finish()
    return going, upgraded, stored


def in_time(kills: Sequence[Kill], kind: str) -> tuple[bool, str]:
    """Return whether frames came back in time after each kill of a kind, and what was found."""
    found = np.array([max(one.shown_s) for one in kills if kind_of(one.name) == kind])
    limit = WITHIN_S[kind]
    words = f"{len(found)} kills, median {np.median(found):.2f}, "
    words += f"95 % {np.quantile(found, 0.95):.2f}, most {found.max():.2f} s"
    return limit is None or bool(found.max() <= limit), words


def report(
    going: Run, upgraded: Sequence[Upgrade], stored: Stored, theirs: Mapping[int, bytes] | None
) -> bool:
    """Print what came of it; True when all that is required holds."""
    print(f"\nmachine   {processor()}, {psutil.cpu_count()} cores; {len(going.sessions)} sessions")
    print(
        f"packets   {stored.sent} sent, {stored.resent} of them again, {stored.stored} stored;"
        f" {stored.missing} missing, {stored.twice} twice, {stored.different} different,"
        f" {stored.out_of_order} out of order"
    )
    judged = {
        "every packet stored once, in order, as it was sent": (
            stored.is_whole,
            f"{stored.stored} of {stored.sent}",
        )
    }
    for kind in {kind_of(one.name): None for one in upgraded}:
        gaps = [one.gap_s for one in upgraded if kind_of(one.name) == kind]
        judged[f"no gap above {UPGRADE_GAP_S:.0f} s while {kind}s are upgraded"] = (
            max(gaps) <= UPGRADE_GAP_S,
            f"{len(gaps)} upgrades, median {np.median(gaps):.2f}, most {max(gaps):.2f} s",
        )
    for kind, limit in WITHIN_S.items():
        if any(kind_of(one.name) == kind for one in going.kills):
            words = "" if limit is None else f" within {limit:.0f} s"
            judged[f"frames of all sessions after {kind}{words}"] = in_time(going.kills, kind)
    contradictions = sum(one.contradictions for one in going.sessions)
    judged["no tick shown with two values"] = (contradictions == 0, f"{contradictions}")
    if theirs is not None:
        ours = going.sessions[0].shown
        both = ours.keys() & theirs.keys()
        different = sum(ours[tick] != theirs[tick] for tick in both)
        judged["frames of session 0 equal those of one process"] = (
            bool(both) and not different,
            f"{different} of {len(both)} ticks different",
        )
    for what, (is_met, found) in judged.items():
        print(f"required  {what}: {'met' if is_met else 'MISSED'}: {found}")
    return all(is_met for is_met, _ in judged.values())


def main() -> int:
    """Kill parts as often as is asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sessions", type=int, default=6)
    parser.add_argument("--upgrades", type=int, default=1, help="of every worker and edge")
    for kind, times in (("worker", 20), ("edge", 20), ("nats", 5), ("database", 5)):
        parser.add_argument(f"--{kind}", type=int, default=times, help=f"kills of {kind}")
    parser.add_argument(
        "--no-embedded", action="store_true", help="do not compare with a service in one process"
    )
    arguments = parser.parse_args()
    # Whoever ends this ends what it has started too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    random = np.random.default_rng(2)
    names = [str(random.choice(PARTS[kind])) for kind in PARTS for _ in range(getattr(arguments, kind))]
    random.shuffle(names)
    calibration, stream = swaying(PERIOD_S)
    with tempfile.TemporaryDirectory(prefix="tm-") as name:
        folder = Path(name)
        with cluster_of(folder, calibration) as (cluster, database):
            began_s = time.monotonic()
            going, upgraded, stored = asyncio.run(
                run(cluster, database, stream, arguments.sessions, names, arguments.upgrades)
            )
            print(f"took {time.monotonic() - began_s:.0f} s")
            if not stored.is_whole:
                going.cluster.copy_logs(Path("var/scaled-kills"))
        theirs = None
        if not arguments.no_embedded:
            (folder / "one").mkdir(mode=0o700)
            theirs = embedded_shown(folder / "one", calibration, stream, going.sessions[0])
    return 0 if report(going, upgraded, stored, theirs) else 1


if __name__ == "__main__":
    sys.exit(main())
