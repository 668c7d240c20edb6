"""Errors of the numerical library.

::

    EstimationError
    ├── ShapeError          an array has the wrong shape, type or non-finite values
    ├── SetupError          placements, rates or parameters that cannot work together
    ├── CalibrationError    a calibration pose or movement that cannot be used, with what to redo
    └── ComparisonError     a recording without the repetitions that a comparison needs
        └── ContradictionError  two recordings that were not of the same movement, or in other axes or units
"""

from collections.abc import Sequence


class EstimationError(Exception):
    """Base of all expected failures; the message says what was wrong and what to do."""

    @property
    def message(self) -> str:
        """The message as it was given: a `Sentence` where people read it."""
        return self.args[0] if self.args and isinstance(self.args[0], str) else str(self)


class ShapeError(EstimationError, ValueError):
    """An array has the wrong shape, type or values."""


class SetupError(EstimationError, ValueError):
    """Placements, rates or parameters that cannot work together."""


class CalibrationError(EstimationError):
    """A calibration pose or movement that cannot be used; the message says what to redo.

    Attributes
    ----------
    redo : tuple of str
        Names of the parts to repeat, where only some must be: `face_y_down`, `turn_z`. Empty means all.
    """

    def __init__(self, message: str = "", *, redo: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.redo = tuple(redo)


class ComparisonError(EstimationError):
    """A recording that does not hold what a comparison needs."""


class ContradictionError(ComparisonError):
    """Two recordings that were not of the same movement, or in other axes or units; the message says what to do.

    Attributes
    ----------
    scale : float or None
        Lengths of the one over those of the other, where they differ.
    up : str
        Axis that points up: `z` as it should, `y`, `-x`.
    """

    def __init__(
        self, message: str = "", *, scale: float | None = None, up: str = "z", is_mirrored: bool = False
    ) -> None:
        super().__init__(message)
        self.scale, self.up, self.is_mirrored = scale, up, is_mirrored
