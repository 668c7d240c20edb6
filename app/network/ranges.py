"""A set of packet sequence numbers as sorted half-open ranges: the ledger of what is stored."""

from bisect import bisect_right
from collections.abc import Iterable, Iterator


class SequenceRanges:
    """Sequence numbers held as few ranges; adding in any order gives the same set.

    Parameters
    ----------
    ranges : iterable of (start, stop)
        Half-open; may overlap and come in any order.
    """

    __slots__ = ("_count", "_starts", "_stops")

    def __init__(self, ranges: Iterable[tuple[int, int]] = ()) -> None:
        self._starts: list[int] = []
        self._stops: list[int] = []
        self._count = 0
        for start, stop in ranges:
            self.add_range(start, stop)

    def __contains__(self, sequence: int) -> bool:
        index = bisect_right(self._starts, sequence) - 1
        return index >= 0 and sequence < self._stops[index]

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(zip(self._starts, self._stops, strict=True))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SequenceRanges) and list(self) == list(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"SequenceRanges({list(self)})"

    def add(self, sequence: int) -> bool:
        """Add one number; return False when it was there already."""
        if self._stops and sequence == self._stops[-1]:
            # The common case of a stream in order must not cost a search.
            self._stops[-1] += 1
            self._count += 1
            return True
        if sequence in self:
            return False
        self.add_range(sequence, sequence + 1)
        return True

    def add_range(self, start: int, stop: int) -> None:
        """Add the half-open range `[start, stop)`."""
        if stop <= start:
            return
        # Ranges that overlap or touch [start, stop) are [first, last).
        first = bisect_right(self._starts, start) - 1
        if first < 0 or self._stops[first] < start:
            first += 1
        last = bisect_right(self._starts, stop)
        removed = sum(self._stops[i] - self._starts[i] for i in range(first, last))
        if first < last:
            start = min(start, self._starts[first])
            stop = max(stop, self._stops[last - 1])
        self._starts[first:last] = [start]
        self._stops[first:last] = [stop]
        self._count += (stop - start) - removed

    def update(self, other: Iterable[tuple[int, int]]) -> None:
        """Add every range of another set."""
        for start, stop in other:
            self.add_range(start, stop)

    def copy(self) -> "SequenceRanges":
        """Return an independent copy."""
        twin = SequenceRanges()
        twin._starts, twin._stops, twin._count = list(self._starts), list(self._stops), self._count
        return twin

    @property
    def highest(self) -> int:
        """Highest number in the set; -1 when empty."""
        return self._stops[-1] - 1 if self._stops else -1

    @property
    def acknowledged(self) -> int:
        """Highest number below which, from zero on, nothing is missing; -1 when zero is missing."""
        return self._stops[0] - 1 if self._starts and self._starts[0] == 0 else -1

    def missing(self, limit: int | None = None) -> list[tuple[int, int]]:
        """Return the half-open ranges from zero to the highest number that are not in the set.

        `limit` bounds how many are returned, the lowest first.
        """
        gaps: list[tuple[int, int]] = []
        previous = 0
        for start, stop in self:
            if limit is not None and len(gaps) >= limit:
                break
            if start > previous:
                gaps.append((previous, start))
            previous = stop
        return gaps

    @property
    def missing_count(self) -> int:
        """How many numbers from zero to the highest are not in the set."""
        return self.highest + 1 - self._count


def ranges_of(sequences: list[int]) -> list[tuple[int, int]]:
    """Return numbers as few half-open ranges; those of a stream in order, the common case, at once."""
    if not sequences:
        return []
    start, stop = sequences[0], sequences[0] + len(sequences)
    if sequences == list(range(start, stop)):
        return [(start, stop)]
    return list(SequenceRanges((sequence, sequence + 1) for sequence in sequences))
