"""Arrays over ticks as one thing: each field is cut, thinned and joined alike, so that no new one is forgotten."""

from collections.abc import Sequence
from itertools import accumulate
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Samples:
    """Base of a frozen dataclass whose arrays run over the same ticks.

    Arrays, None for one that is absent, other `Samples` and tuples of them are of ticks; `first_tick` counts along;
    whatever else a field holds is of all ticks. Whole numbers without sign are bits, such as flags.
    """

    TICK_AXIS: ClassVar[int] = 0
    """The axis of every array that runs over ticks."""
    UNKNOWN_BITS: ClassVar[int] = 0
    """What stands in bits where `join` finds no part for a tick."""

    @property
    def tick_count(self) -> int:
        """Number of ticks K."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                return int(value.shape[self.TICK_AXIS])
        raise TypeError(f"{type(self).__name__} has no array")

    def ticks(self, start: int, stop: int) -> Self:
        """Return the half-open range of ticks `[start, stop)`, counted within these; what lies outside is left out."""
        count = self.tick_count
        start = min(max(start, 0), count)
        index = (slice(None),) * self.TICK_AXIS + (slice(start, max(start, min(stop, count))),)
        found = self._mapped(lambda array: array[index], lambda part: part.ticks(start, stop))
        if "first_tick" in found:
            found["first_tick"] += start
        return self._twin(found)

    def every(self, step: int) -> Self:
        """Return each n-th tick; the tick interval grows with it.

        They begin at a whole multiple of `step`, so that the new tick number says its time exactly and neighbouring
        pieces continue each other. Bits of ticks left out are joined into the tick before, so a gap stays visible.
        """
        if step <= 1:
            return self
        first_tick: int = getattr(self, "first_tick", 0)
        starts = np.arange(-first_tick % step, self.tick_count, step)

        def thinned(array: Array) -> Array:
            if array.dtype.kind == "u" and len(starts):
                return np.bitwise_or.reduceat(array, starts, axis=self.TICK_AXIS)
            return array.take(starts, axis=self.TICK_AXIS)

        found = self._mapped(
            thinned, lambda part: part.ticks(int(-first_tick % step), part.tick_count).every(step)
        )
        for name, value in (
            ("first_tick", -(-first_tick // step)),
            ("time_step_s", getattr(self, "time_step_s", 0.0) * step),
        ):
            if name in found:
                found[name] = value
        return self._twin(found)

    @classmethod
    def join(cls, parts: Sequence[Self]) -> Self:
        """Return parts, at least one, that follow each other as one, from the first tick of the first.

        Of an array that some lack, numbers are NaN there and bits `UNKNOWN_BITS`.
        """
        if len(parts) == 1:
            return parts[0]
        return parts[0]._joined(parts, [0, *accumulate(part.tick_count for part in parts[:-1])])

    @classmethod
    def merge(cls, parts: Sequence[Self]) -> Self:
        """Return parts, at least one, each at its `first_tick`, as one.

        Where no part has a tick, numbers are NaN and bits `UNKNOWN_BITS`; of two parts with the same tick the one that
        begins later counts.
        """
        numbers: list[int] = [getattr(part, "first_tick") for part in parts]  # noqa: B009
        order = sorted(range(len(parts)), key=numbers.__getitem__)
        first = numbers[order[0]]
        return parts[order[0]]._joined([parts[k] for k in order], [numbers[k] - first for k in order])

    def _joined(self, parts: Sequence[Self], places: Sequence[int]) -> Self:
        found: dict[str, Any] = {}
        count: int | None = None
        for name in vars(self):
            values = [getattr(part, name) for part in parts]
            known = next((value for value in values if value is not None), None)
            if isinstance(known, np.ndarray):
                if count is None:
                    count = max(at + part.tick_count for at, part in zip(places, parts, strict=True))
                found[name] = self._laid(values, known, places, count)
            elif isinstance(known, Samples):
                found[name] = known._joined(values, places)
            elif isinstance(known, tuple) and known and isinstance(known[0], Samples):
                found[name] = tuple(one[0]._joined(one, places) for one in zip(*values, strict=True))
            else:
                found[name] = known
        return self._twin(found)

    def _laid(self, values: Sequence[Any], known: Array, places: Sequence[int], count: int) -> Array:
        before = (slice(None),) * self.TICK_AXIS
        shape = (*known.shape[: self.TICK_AXIS], count, *known.shape[self.TICK_AXIS + 1 :])
        blank = {"f": np.nan, "u": self.UNKNOWN_BITS}.get(known.dtype.kind, 0)
        laid = np.full(shape, blank, dtype=known.dtype)
        for at, value in zip(places, values, strict=True):
            if value is not None:
                laid[(*before, slice(at, at + value.shape[self.TICK_AXIS]))] = value
        return laid

    def _mapped(self, of_array: Any, of_part: Any) -> dict[str, Any]:
        """Return the fields with arrays and nested samples changed."""
        found = {}
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                value = of_array(value)
            elif isinstance(value, Samples):
                value = of_part(value)
            elif isinstance(value, tuple) and value and isinstance(value[0], Samples):
                value = tuple(of_part(one) for one in value)
            found[name] = value
        return found

    def _twin(self, values: dict[str, Any]) -> Self:
        # Of every live packet: `dataclasses.replace` would set each field again, six times as dear.
        twin = object.__new__(type(self))
        twin.__dict__.update(values)
        return twin
