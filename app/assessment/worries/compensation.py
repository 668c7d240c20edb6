"""The largest compensation of a comparison, stored with it so that lists need not read whole summaries."""

import math
from typing import Any, Final

from estimators.comparison import channel_name
from estimators.sentences import say

LEAST_MORE: Final = {"deg": 5.0, "m": 0.025}
"""A trunk that leans less than this more than in the template, or a shoulder that rises less, is no reason to look."""
_SIGMAS: Final = 2.0


def largest_compensation(summary: dict[str, Any]) -> dict[str, Any] | None:
    """Return the largest excess over the template that is neither small nor within its own uncertainty.

    Parameters
    ----------
    summary : dict
        Of a stored comparison.

    Returns
    -------
    dict or None
        `channel`, `more` and `unit` (`deg` or `m`); None where nothing helped the arm.
    """
    largest, found = 1.0, None
    for one in summary.get("measures", []):
        if one["group"] != "compensation" or one["value"] is None or one["template_value"] is None:
            continue
        more, count = one["value"] - one["template_value"], max(one["count"], 1)
        chance = _SIGMAS * (one["uncertainty"] or 0.0) / math.sqrt(count)
        share = more / LEAST_MORE.get(one["unit"], math.inf)
        if more > chance and share > largest:
            largest = share
            found = {"channel": one["measure"].partition(":")[2], "more": more, "unit": one["unit"]}
    return found


def compensation_text(found: dict[str, Any]) -> str:
    """Say what helped the arm, and by how much.

    Parameters
    ----------
    found : dict
        From `largest_compensation`.
    """
    channel, more = channel_name(found["channel"]), found["more"]
    if found["unit"] == "m":
        return say("caseload.compensation_length", channel=channel, more_m=more)
    return say("caseload.compensation_angle", channel=channel, more_rad=math.radians(more))
