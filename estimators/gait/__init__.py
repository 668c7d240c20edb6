"""Feet: when they stand, where they go, and what a walk looks like in numbers.

::

    trajectory = smooth(recording.sensors["foot_left"])     # off-line
    released = FootTracker(2, 0.01).update(chunk)              # live, up to 0.94 s old

Sensors may sit anywhere on the shoe, any way round. Without a magnetometer the heading of the world is that of the
first sample, for each foot its own.
"""

from estimators.gait._foot_live import FootChunk, FootTracker
from estimators.gait._foot_parameters import FootParameters, foot_parameters
from estimators.gait._foot_trajectory import FootFlag, FootTrajectory, smooth
from estimators.gait._stance import Stance, find_stance

__all__ = [
    "FootChunk",
    "FootFlag",
    "FootParameters",
    "FootTracker",
    "FootTrajectory",
    "Stance",
    "find_stance",
    "foot_parameters",
    "smooth",
]
