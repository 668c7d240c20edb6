"""The inclination and gyroscope-offset Kalman filter of Luinge and Veltink (2005)."""

from estimators.orientation.luinge._estimator import PUBLISHED, LuingeEstimator, LuingeParameters

__all__ = ["PUBLISHED", "LuingeEstimator", "LuingeParameters"]
