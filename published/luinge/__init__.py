"""The inclination and gyroscope-offset Kalman filter of Luinge and Veltink (2005)."""

from published.luinge._estimator import PUBLISHED, LuingeEstimator, LuingeParameters

__all__ = ["PUBLISHED", "LuingeEstimator", "LuingeParameters"]
