"""Cue rules and stop rules of one side for the other."""

from dataclasses import replace
from typing import Final, Literal

from estimators.comparison.channels.mirror import changes_sign, mirrored_name
from estimators.guidance._rules import CueRule, CueSide, StopRule

_CUE_ACROSS: Final[dict[CueSide, CueSide]] = {"below": "above", "both": "both", "above": "below"}
_STOP_ACROSS: Final[dict[Literal["below", "above"], Literal["below", "above"]]] = {
    "below": "above",
    "above": "below",
}


def mirror_cue_rule(rule: CueRule) -> CueRule:
    """Return a cue rule for the other arm: what changes its sign has above where it had below."""
    return replace(
        rule,
        channel=mirrored_name(rule.channel),
        against=mirrored_name(rule.against),
        side=_CUE_ACROSS[rule.side] if changes_sign(rule.channel) else rule.side,
    )


def mirror_stop_rule(rule: StopRule) -> StopRule:
    """Return a stop rule for the other arm: what changes its sign has its limit on the other side of zero."""
    turns = rule.kind == "limit" and changes_sign(rule.channel)
    return replace(
        rule,
        channel=mirrored_name(rule.channel),
        limit=-rule.limit if turns else rule.limit,
        side=_STOP_ACROSS[rule.side] if turns else rule.side,
    )
