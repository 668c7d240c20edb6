"""Our own off-line smoother: the model of the online filter over the whole session, both ways."""

from estimators.orientation.smoother._estimator import SmoothedOrientation, SmootherParameters, smooth

__all__ = ["SmoothedOrientation", "SmootherParameters", "smooth"]
