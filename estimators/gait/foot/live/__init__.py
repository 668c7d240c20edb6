"""The foot filter live: buffers, detector, filter and fixed-lag smoother of the feet of one person."""

from estimators.gait.foot.live.tracker import FootChunk, FootTracker

__all__ = ["FootChunk", "FootTracker"]
