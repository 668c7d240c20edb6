"""The complementary Kalman filter with magnetic disturbance of Roetenberg (2006), chapters 2 and 3."""

from published.roetenberg._estimator import (
    RoetenbergEstimator,
    RoetenbergParameters,
)

__all__ = ["RoetenbergEstimator", "RoetenbergParameters"]
