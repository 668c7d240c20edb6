"""Guidance of a session that streams: its frames packet by packet, over gaps, from rest to rest.

::

    following = Following(ready, tick_s=0.01)
    chunk, is_settled = following.feed(frames)
"""

from estimators.guidance.live._following import Following
from estimators.guidance.live._picking import Picking

__all__ = ["Following", "Picking"]
