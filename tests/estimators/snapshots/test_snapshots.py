"""Moving code moves no number: see `cases`."""

import pytest

from tests.estimators.snapshots.cases import CASES, SNAPSHOTS, differences, snapshot

TOLERANCE = 1e-7
"""Of each array's largest value. On the machine that wrote them the difference is 0; another processor rounds some
functions another way, and filters and optimisers carry it on."""


@pytest.mark.parametrize("name", CASES)
def test_numbers_stay(name: str) -> None:
    moved = {
        path: size for path, size in differences(snapshot(CASES[name]()), name).items() if size > TOLERANCE
    }
    assert not moved, f"{name}: write the snapshots anew if this was meant (see cases.py)"


def test_every_snapshot_has_a_case() -> None:
    assert {path.stem for path in SNAPSHOTS.glob("*.json")} == set(CASES)
