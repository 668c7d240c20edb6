"""`python -m tests.app.readers.odd_draws --draws 2000`: draws odd tables, reads them and prints what came of them."""

import argparse
import time
import traceback
from collections import Counter, defaultdict

from tests.app.readers.odd_draws.drawn import draw
from tests.app.readers.odd_draws.judged import judge


def main() -> None:
    """Draw, judge and count."""
    parser = argparse.ArgumentParser(prog="odd_draws")
    parser.add_argument("--draws", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--write", default="", help="folder for the tables that are not read right")
    asked = parser.parse_args()
    began = time.monotonic()
    counts: Counter[str] = Counter()
    reasons: dict[str, list[str]] = defaultdict(list)
    for seed in range(asked.first, asked.first + asked.draws):
        table = draw(seed)
        try:
            verdict = judge(table)
            kind, why = verdict.kind, verdict.why
        except Exception:
            kind, why = "failed", traceback.format_exc(limit=-2)
        counts[kind] += 1
        if kind != "right":
            kinds = ", ".join(f"{name} {value}" for name, value in table.kinds.items() if value)
            reasons[kind].append(
                f"{seed}: {why}\n      {kinds}, {len(table.sensors)} sensors, {table.rate_hz:g} Hz"
            )
            if asked.write:
                with open(f"{asked.write}/{kind}-{seed}.csv", "wb") as file:
                    file.write(table.content)
    for kind, lines in reasons.items():
        print(f"== {kind}")
        for line in lines:
            print("  ", line)
    total = sum(counts.values())
    shares = ", ".join(f"{kind} {count} ({count / total:.2%})" for kind, count in counts.items())
    print(f"{total} draws from seed {asked.first} in {time.monotonic() - began:.0f} s: {shares}")


if __name__ == "__main__":
    main()
