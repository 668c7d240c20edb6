"""The filters of the arm-monitoring thesis: quaternion and Euler EKF, and the error-state EKF that replaces them."""

from published.marzouk._error_state import MarzoukErrorStateEstimator
from published.marzouk._euler import MarzoukEulerEstimator
from published.marzouk._quaternion import MarzoukQuaternionEstimator

__all__ = ["MarzoukErrorStateEstimator", "MarzoukEulerEstimator", "MarzoukQuaternionEstimator"]
