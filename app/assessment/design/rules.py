"""Cue rules and stop rules of a design for the library, and those of the house written out for whoever edits them."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Final

from app.errors import InvalidInput
from app.exercises.design import CueDesign, StopDesign, TemplateDesign
from app.exercises.models import Posture
from estimators.comparison import Template, is_of_stride
from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.guidance import (
    DEFAULT_STOPS,
    SENTENCES,
    CueRule,
    GuidanceTemplate,
    StopRule,
    default_rules,
    fitting_sentence,
    prepare_template,
)
from estimators.sentences import say

ALWAYS: Final = tuple(stop for stop in DEFAULT_STOPS if stop.kind in ("lost", "unsure"))
"""Pauses without which nothing can be judged; a design may change their numbers, not leave them out."""


def said(sentence: str) -> str:
    """Return what a cue says: a sentence with its code, or the therapist's own words as they stand."""
    return SENTENCES.get(sentence, sentence)


def cue_rules(design: TemplateDesign, ready: GuidanceTemplate) -> tuple[CueRule, ...]:
    """Return the cue rules of a design; those of the house where it has none."""
    if design.cues is None:
        return default_rules(ready, design.valid_share)
    return tuple(cue_rule(one) for one in design.cues)


def stop_rules(stops: Sequence[StopDesign] | None) -> tuple[StopRule, ...]:
    """Return the stop rules of a design; those of the house where it has none, and always the pauses that must be."""
    if stops is None:
        return DEFAULT_STOPS
    own = tuple(stop_rule(one) for one in stops)
    return (*own, *(rule for rule in ALWAYS if rule.kind not in {one.kind for one in own}))


def whole_design(design: TemplateDesign, template: Template, posture: Posture = "standing") -> TemplateDesign:
    """Return a design with the rules of the house written out and their words fitting, for whoever edits them."""
    whole = _written_out(design, template)
    cues = [
        one.model_copy(
            update={"sentence": fitting_sentence(one.sentence, posture, template.channels, template.mean)}
        )
        for one in whole.cues or ()
    ]
    return whole.model_copy(update={"cues": cues})


def _written_out(design: TemplateDesign, template: Template) -> TemplateDesign:
    if is_of_stride(template.primary_channel):
        # Nobody follows a stride live: there is nothing to stop and nothing to say.
        return design.model_copy(update={"stops": [], "cues": []})
    stops = [StopDesign(**asdict(rule)) for rule in stop_rules(design.stops)]
    if design.cues is not None:
        return design.model_copy(update={"stops": stops})
    try:
        ready = prepare_template(template, side_of(template.side), template.reach_m)
    except SetupError:
        # It does not move enough to be followed live; nothing is said then.
        return design.model_copy(update={"stops": stops, "cues": []})
    cues = [CueDesign(**asdict(rule)) for rule in default_rules(ready, design.valid_share)]
    return design.model_copy(update={"stops": stops, "cues": cues})


def check_rules(design: TemplateDesign, template: Template) -> None:
    """Raise `InvalidInput` for a rule that looks at nothing or cannot hold."""
    for place, stop in enumerate(design.stops or ()):
        try:
            stop_rule(stop)
            known = stop.kind != "limit" or (stop.channel in template.channels and "." not in stop.channel)
        except SetupError:
            known = False
        if not known:
            raise InvalidInput(say("design.stop", number=place + 1), field=f"design.stops.{place}")
    for place, cue in enumerate(design.cues or ()):
        looked = {
            "deviation": (cue.channel,),
            "at_equal": (cue.channel, cue.against),
        }.get(cue.quantity, ())
        try:
            cue_rule(cue)
            known = all(name in template.channels for name in looked) and cue.sentence in SENTENCES
        except SetupError:
            known = False
        if not known:
            raise InvalidInput(say("design.cue", number=place + 1), field=f"design.cues.{place}")


def cue_rule(one: CueDesign) -> CueRule:
    """Return a stored cue rule for the library; raises `SetupError` for one that cannot hold."""
    values = one.model_dump(exclude={"words"})
    return CueRule(**{**values, "sentence": one.words.strip() or one.sentence})


def stop_rule(one: StopDesign) -> StopRule:
    """Return a stored stop rule for the library; raises `SetupError` for one that cannot hold."""
    return StopRule(**one.model_dump())


def side_of(side: str) -> Side:
    """Return a side of a template by its type."""
    return "left" if side == "left" else "right"
