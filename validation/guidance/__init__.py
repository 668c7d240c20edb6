"""Live guidance along a template: phase, counting, cues and cost on simulated sessions with exact truth."""

from validation.guidance.cost import COST
from validation.guidance.count import COUNT
from validation.guidance.cues import CUES
from validation.guidance.phase import PHASE

__all__ = ["COST", "COUNT", "CUES", "PHASE"]
