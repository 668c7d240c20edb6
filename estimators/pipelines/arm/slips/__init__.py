"""Sensors that turn in their strap while they are worn: found from the whole movement, and flagged from there on."""

from estimators.pipelines.arm.slips.flagged import with_slips
from estimators.pipelines.arm.slips.search import Slip, SlipSearch, find_slips, in_doubt

__all__ = ["Slip", "SlipSearch", "find_slips", "in_doubt", "with_slips"]
