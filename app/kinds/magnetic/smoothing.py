"""Stored sessions with a magnetic source, smoothed as a whole."""

from collections.abc import Iterable, Iterator

from estimators import pipelines
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk


class SmoothedModules:
    """A whole session with a magnetic source, with the pose of every sensor from all of it.

    Parameters
    ----------
    pieces : iterable of ImuChunk
        Consecutive ticks as measured from tick 0, sensors in the order of the setup.
    setup : SessionSetup
        Of the pipeline `relative_pose`.
    """

    def __init__(self, pieces: Iterable[ImuChunk], setup: SessionSetup) -> None:
        self._pieces = list(pieces)
        self._modules = pipelines.smooth_modules(self._pieces, setup) if self._pieces else ()

    def __iter__(self) -> Iterator[ImuChunk]:
        """Yield the pieces as they came, with the poses."""
        start = 0
        for piece in self._pieces:
            yield pipelines.with_modules(piece, self._modules, start)
            start += piece.tick_count
