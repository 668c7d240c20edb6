"""Our own online filter: an error-state filter that also learns the errors of its sensor and the field of the room."""

from estimators.orientation.telemotion._estimator import TelemotionEstimator

__all__ = ["TelemotionEstimator"]
