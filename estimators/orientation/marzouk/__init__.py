"""The filters of the arm-monitoring thesis: quaternion and Euler EKF, and the error-state EKF that replaces them."""

from estimators.orientation.marzouk._error_state import MarzoukErrorStateEstimator
from estimators.orientation.marzouk._euler import MarzoukEulerEstimator
from estimators.orientation.marzouk._quaternion import MarzoukQuaternionEstimator

__all__ = ["MarzoukErrorStateEstimator", "MarzoukEulerEstimator", "MarzoukQuaternionEstimator"]
