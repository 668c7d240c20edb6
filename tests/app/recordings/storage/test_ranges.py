"""The ledger of sequences against a plain set."""

import itertools

from hypothesis import given
from hypothesis import strategies as st

from app.network.ranges import SequenceRanges

SEQUENCES = st.lists(st.integers(0, 60), max_size=80)
SPANS = st.lists(st.tuples(st.integers(0, 60), st.integers(0, 60)), max_size=30)


@given(SEQUENCES)
def test_it_is_the_set_that_was_added(sequences: list[int]) -> None:
    ranges, plain = SequenceRanges(), set()
    for sequence in sequences:
        assert ranges.add(sequence) == (sequence not in plain)
        plain.add(sequence)
    assert len(ranges) == len(plain)
    assert {s for s in range(-1, 62) if s in ranges} == plain
    assert [s for a, b in ranges for s in range(a, b)] == sorted(plain)
    assert ranges.highest == max(plain, default=-1)
    assert {s for a, b in ranges.missing() for s in range(a, b)} == set(range(max(plain, default=-1))) - plain
    assert ranges.missing_count == ranges.highest + 1 - len(plain)
    first_missing = next(s for s in range(100) if s not in plain)
    assert ranges.acknowledged == first_missing - 1


@given(SPANS)
def test_spans_in_any_order_join(spans: list[tuple[int, int]]) -> None:
    ranges = SequenceRanges(spans)
    plain = {s for a, b in spans for s in range(a, b)}
    assert [s for a, b in ranges for s in range(a, b)] == sorted(plain)
    assert len(ranges) == len(plain)
    found = list(ranges)
    # Neither empty nor touching: the shortest description of the set.
    assert all(a < b for a, b in found)
    assert all(left[1] < right[0] for left, right in itertools.pairwise(found))
    assert ranges == SequenceRanges(reversed(spans))


@given(SPANS, SEQUENCES)
def test_a_copy_lives_its_own_life(spans: list[tuple[int, int]], sequences: list[int]) -> None:
    ranges = SequenceRanges(spans)
    before = list(ranges)
    copy = ranges.copy()
    for sequence in sequences:
        copy.add(sequence)
    assert list(ranges) == before


def test_missing_can_be_bounded() -> None:
    assert SequenceRanges([(2, 3), (5, 6), (8, 9)]).missing(limit=2) == [(0, 2), (3, 5)]
