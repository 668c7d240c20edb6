"""From a stored version of a template to the one band and the one set of rules that everybody uses.

`effective_template` is for whoever compares, draws or prints: a `Template` with its phases, band and what counts.
`guidance_of` is for whoever guides live: the same template made ready for a patient, with cue rules and stop rules.
Nobody else reads `TemplateVersion.design`.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

from sqlalchemy.orm import Session

from app.assessment.design.rules import cue_rule, cue_rules, stop_rule, stop_rules
from app.errors import InvalidInput
from app.exercises.design import (
    CueDesign,
    KnotDesign,
    StopDesign,
    TemplateDesign,
    ToleranceDesign,
    WeightDesign,
)
from app.exercises.models import Posture, Prescription, TemplateVersion
from app.recordings.models import MotionSession
from estimators.comparison import (
    FREE,
    Knot,
    NamedPhase,
    Template,
    ToleranceCurve,
    channel_label,
    mirror_template,
    mirrored_name,
    template_from_bytes,
)
from estimators.conventions import Side
from estimators.errors import SetupError
from estimators.guidance import (
    CuePace,
    CueRule,
    GuidanceTemplate,
    StopRule,
    fitting_sentence,
    mirror_cue_rule,
    mirror_stop_rule,
    prepare_template,
)
from estimators.sentences import say


@dataclass(frozen=True)
class Guidance:
    """A template version made ready to guide one patient.

    Attributes
    ----------
    template : Template
        On the patient's side, with phases, band and what counts; in the metres of the person recorded.
    ready : GuidanceTemplate
        The same for `Guide`, in the patient's metres.
    rules : tuple of CueRule
        `sentence` is a code of `SENTENCES` or the therapist's own words; `rules.said` tells them apart.
    """

    template: Template
    ready: GuidanceTemplate
    rules: tuple[CueRule, ...]
    stops: tuple[StopRule, ...]
    pace: CuePace
    valid_share: float


def design_of(version: TemplateVersion) -> TemplateDesign:
    """Return what was drawn; nothing for versions from before anything could be."""
    return TemplateDesign.model_validate(version.design or {})


def effective_template(version: TemplateVersion, side: str | None = None, scale: float = 1.0) -> Template:
    """Return a version's template with the band that everybody judges by.

    Parameters
    ----------
    side : {"left", "right"}, optional
        Mirrored for it where the template is of the other.
    scale : float
        Of the prescription: factor on the whole band, `tolerance_scale_of`.

    Returns
    -------
    Template
        `below`, `above`, `counts` and `phases` as drawn.
    """
    drawn = apply_design(template_from_bytes(version.content), design_of(version), scale)
    return mirror_template(drawn) if side is not None and side != drawn.side else drawn


def guidance_of(
    version: TemplateVersion,
    side: Side,
    reach_m: float,
    *,
    scale: float = 1.0,
    more_stops: Sequence[StopDesign] = (),
    posture: Posture = "standing",
) -> Guidance:
    """Return everything that live guidance needs of a version.

    Parameters
    ----------
    side : {"left", "right"}
        The patient's acting side.
    reach_m : float
        The patient's upper arm plus forearm.
    scale : float
        Of the prescription, as for `effective_template`.
    more_stops : sequence of StopDesign
        Of the prescription, named for the patient's side; they come before those of the template.
    posture : {"standing", "seated"}
        Of the exercise: what is said fits it, whatever was stored.

    Raises
    ------
    SetupError
        If the template does not move enough to be followed.
    """
    design, template = design_of(version), effective_template(version, side, scale)
    ready = prepare_template(template, side, reach_m)
    mirrored = template_from_bytes(version.content).side != side
    rules, stops = cue_rules(design, ready), stop_rules(design.stops)
    if mirrored and design.cues is not None:
        rules = tuple(mirror_cue_rule(rule) for rule in rules)
    if mirrored:
        stops = tuple(mirror_stop_rule(rule) for rule in stops)
    return Guidance(
        template=template,
        ready=ready,
        rules=tuple(
            replace(
                rule,
                is_on=rule.is_on and rule.channel not in template.watched,
                sentence=fitting_sentence(rule.sentence, posture, template.channels, template.mean),
            )
            for rule in rules
        ),
        stops=(*(stop_rule(one) for one in more_stops), *stops),
        pace=CuePace(**design.pace.model_dump()),
        valid_share=design.valid_share,
    )


def tolerance_scale_of(session: Session, found: MotionSession, template_id: str) -> float:
    """Return the factor on the band that the session was prescribed with; 1 without, and for another template."""
    if found.prescription_id is None:
        return 1.0
    prescription = session.get(Prescription, found.prescription_id)
    if prescription is None or prescription.template_id != template_id:
        return 1.0
    return prescription.tolerance_scale


def apply_design(template: Template, design: TemplateDesign, scale: float = 1.0) -> Template:
    """Draw on a recorded template; raises `InvalidInput` for what does not fit it."""
    channels = template.channels
    for name in (*(one.channel for one in design.tolerances), *design.watched):
        if name not in channels:
            raise InvalidInput(say("design.no_channel", name=name), field="design")
    if template.primary_channel in design.watched:
        raise InvalidInput(
            say("design.main_counts", name=channel_label(template.primary_channel)), field="design.watched"
        )
    try:
        phases = tuple(NamedPhase(one.name.strip(), one.start, one.end) for one in design.phases)
        drawn = replace(template, phases=phases)
    except SetupError:
        raise InvalidInput(say("design.phases"), field="design.phases") from None
    try:
        return replace(drawn, tolerances=_curves(channels, design, scale), watched=tuple(design.watched))
    except SetupError:
        raise InvalidInput(say("design.knots"), field="design.tolerances") from None


def mirrored_design(design: TemplateDesign, template: Template) -> TemplateDesign:
    """Return a design for the other side; `template` is as it was recorded."""
    mirrored = mirror_template(apply_design(template, design))
    words = [one.words for one in design.cues or ()]
    cues = (
        None
        if design.cues is None
        else [
            CueDesign(**asdict(mirror_cue_rule(cue_rule(one.model_copy(update={"words": ""})))), words=own)
            for one, own in zip(design.cues, words, strict=True)
        ]
    )
    stops = (
        None
        if design.stops is None
        else [StopDesign(**asdict(mirror_stop_rule(stop_rule(one)))) for one in design.stops]
    )
    return design.model_copy(
        update={
            "tolerances": [
                ToleranceDesign(
                    channel=curve.channel,
                    knots=[
                        KnotDesign(phase=k.phase, below=_or_free(k.below), above=_or_free(k.above))
                        for k in curve.knots
                    ],
                )
                for curve in mirrored.tolerances
            ],
            "watched": list(mirrored.watched),
            "cues": cues,
            "stops": stops,
            "weights": mirrored_weights(design.weights),
        }
    )


def mirrored_weights(weights: Sequence[WeightDesign]) -> list[WeightDesign]:
    """Return the parts of a weighted sum for the other side."""
    return [one.model_copy(update={"measure": mirrored_name(one.measure)}) for one in weights]


def _curves(channels: Sequence[str], design: TemplateDesign, scale: float) -> tuple[ToleranceCurve, ...]:
    drawn = [(one.channel, one.knots) for one in design.tolerances]
    if scale != 1.0:
        named = {name for name, _ in drawn}
        drawn += [(name, [KnotDesign(phase=0.0)]) for name in channels if name not in named]
    return tuple(
        ToleranceCurve(
            name, tuple(Knot(k.phase, _factor(k.below, scale), _factor(k.above, scale)) for k in knots)
        )
        for name, knots in drawn
    )


def _factor(stored: float | None, scale: float) -> float:
    return FREE if stored is None else stored * scale


def _or_free(factor: float) -> float | None:
    return None if factor == FREE else factor
