"""Wire types of what a therapist draws on a template: phases, tolerances, what counts, what stops, what is said.

Stored as it is sent, in SI units, beside the recorded curves, which it never changes. `app.assessment.design` makes
the library's rules and bands of it.
"""

from typing import Annotated, Literal

from pydantic import Field

from app.schemas import Flag, Schema

PhaseShare = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]
"""Place in the movement, 0 to 1."""
Channel = Annotated[str, Field(max_length=80)]
Number = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Factor = Annotated[float, Field(gt=0.0, le=20.0, allow_inf_nan=False)]
Seconds = Annotated[float, Field(ge=0.0, le=60.0, allow_inf_nan=False)]


class PhaseDesign(Schema):
    """A named stretch of the movement."""

    name: str = Field(min_length=1, max_length=40)
    start: PhaseShare
    end: PhaseShare


class KnotDesign(Schema):
    """How many times its recorded width the band has at one phase; straight lines between knots."""

    phase: PhaseShare
    below: Factor | None = 1.0
    """None: free, no limit."""
    above: Factor | None = 1.0


class ToleranceDesign(Schema):
    """The band of one channel; channels without one keep the recorded band."""

    channel: Channel
    knots: list[KnotDesign] = Field(min_length=1, max_length=64)


class StopDesign(Schema):
    """What stops or pauses the exercise. The pain button always does and needs no rule."""

    kind: Literal["limit", "valid_count", "attempt_count", "time", "lost", "unsure", "wrong_in_a_row"]
    limit: Number = 0.0
    """rad or m of a channel, a number of repetitions, s, or rad of uncertainty."""
    channel: Channel = ""
    """Of `limit`: an angle or a scalar."""
    side: Literal["below", "above"] = "above"
    hold_s: Seconds = 0.05


class CueDesign(Schema):
    """When something is said, and what; `estimators.guidance.CueRule` says what each quantity means."""

    quantity: Literal["deviation", "at_equal", "range", "fast", "slow"]
    sentence: str = Field(max_length=60, pattern=r"^guidance\.[a-z_]+$")
    """Code of what is said."""
    words: str = Field(default="", max_length=120)
    """The therapist's own words instead; empty for the sentence."""
    channel: Channel = ""
    against: Channel = ""
    least: Number = 0.0
    side: Literal["below", "both", "above"] = "both"
    phases: tuple[PhaseShare, PhaseShare] = (0.0, 1.0)
    tolerance: Annotated[float, Field(gt=0.0, le=100.0, allow_inf_nan=False)] | None = None
    """rad, m or a ratio; None is the band as drawn, of `deviation` only."""
    hold_s: Annotated[float, Field(ge=0.0, le=10.0, allow_inf_nan=False)] = 0.25
    priority: int = Field(default=1, ge=1, le=99)
    is_on: Flag = True


class PaceDesign(Schema):
    """How often something is said."""

    silence_s: Seconds = 1.5
    praise_every: int = Field(default=3, ge=0, le=100)
    cue_every: int = Field(default=1, ge=1, le=100)


class WeightDesign(Schema):
    """One part of the therapist's weighted sum of measures."""

    measure: str = Field(min_length=1, max_length=120)
    """Name of a measure of repetitions beside the template, `TemplateContent.measures`."""
    weight: Annotated[float, Field(ge=-1e3, le=1e3, allow_inf_nan=False)]
    """Times the measure in the unit that people read, degrees for angles; not zero."""


class TemplateDesign(Schema):
    """Everything that a therapist draws on a template, named for the template's side."""

    phases: list[PhaseDesign] = Field(default_factory=list, max_length=12)
    """In order, none over another."""
    tolerances: list[ToleranceDesign] = Field(default_factory=list, max_length=64)
    watched: list[Channel] = Field(default_factory=list, max_length=64)
    """Channels that are shown and not judged; all others count."""
    stops: list[StopDesign] | None = Field(default=None, max_length=40)
    """None: those of the house."""
    cues: list[CueDesign] | None = Field(default=None, max_length=40)
    """None: those of the house."""
    valid_share: float = Field(default=0.8, gt=0.0, le=1.2)
    """Share of each target of the movement from which a repetition is valid."""
    pace: PaceDesign = Field(default_factory=PaceDesign)
    weights: list[WeightDesign] = Field(default_factory=list, max_length=12)
    """Parts of a sum of measures; none, no sum: nothing is weighed that the therapist did not weigh."""
