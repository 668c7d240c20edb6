"""Live guidance along a template: phase, counting and cues on simulated sessions with exact truth.

Not yet among the experiments of the accuracy page, which shows nothing that was not measured with its fifty seeds.
"""

from validation.guidance.count import COUNT
from validation.guidance.cues import CUES
from validation.guidance.phase import PHASE

PROTOCOLS = (PHASE, COUNT, CUES)

__all__ = ["COUNT", "CUES", "PHASE", "PROTOCOLS"]
