"""Live guidance along a template: phase, counting and cues on simulated sessions with exact truth."""

from validation.guidance.count import COUNT
from validation.guidance.cues import CUES
from validation.guidance.phase import PHASE

__all__ = ["COUNT", "CUES", "PHASE"]
