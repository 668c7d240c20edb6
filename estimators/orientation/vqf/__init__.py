"""VQF of Laidig and Seel (2023), in our own formulation."""

from estimators.orientation.vqf._estimator import VqfEstimator
from estimators.orientation.vqf._parameters import VqfParameters

__all__ = ["VqfEstimator", "VqfParameters"]
