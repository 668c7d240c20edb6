"""Guidance of a session that streams: its frames packet by packet, over gaps, from rest to rest.

::

    following = GuidanceRunner(ready, tick_s=0.01)
    chunk, is_settled = following.feed(frames)
"""

from estimators.guidance.live._following import GuidanceRunner
from estimators.guidance.live._picking import ChannelSelector

__all__ = ["ChannelSelector", "GuidanceRunner"]
