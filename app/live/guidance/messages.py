"""Messages of a guided session, and the requests that its patient may make."""

from typing import Literal

from app.schemas import Schema, Spoken

GuidanceStatus = Literal["off", "waiting", "ready", "moving", "paused", "stopped", "failed"]
GuidanceCause = Literal[
    "",
    "person",
    "pain",
    "limit",
    "valid_count",
    "set",
    "attempt_count",
    "time",
    "lost",
    "unsure",
    "wrong_in_a_row",
]
GuidanceCommand = Literal["pause", "resume", "pain", "stop"]


class GuidanceCommandIn(Schema):
    """What a patient asks of the guidance."""

    command: GuidanceCommand


class GuidanceCounts(Schema):
    """Finished repetitions of a session, each counted once."""

    valid: int = 0
    partial: int = 0
    """Along the template, but not as far as the therapist asks."""
    wrong: int = 0


class GuidanceMessage(Spoken):
    """Live socket: how the patient follows the template; on connecting, on every change, and while something moves."""

    type: Literal["guidance"] = "guidance"
    status: GuidanceStatus
    """`off`: there is no template to follow; the buttons work all the same. `waiting`: for a second of rest in the
    start posture. `ready`: at rest, the next repetition may begin. `failed`: the session goes on without guidance."""
    cause: GuidanceCause = ""
    """Why it is paused or stopped: a person, pain, the prescribed number (`valid_count`), a set of it, or the kind of
    the stop rule."""
    time_s: float
    """Session time that is spoken of."""
    phase: float | None = None
    """0 to 1, along the template; null at rest and while it is not known."""
    sigma: float | None = None
    """Standard deviation of the phase."""
    ghost_phase: float | None = None
    """Where the example stands: with the patient, waiting for it; null lets it show the whole movement."""
    counts: GuidanceCounts
    goal: int | None = None
    """Valid repetitions that are prescribed, of all sets."""
    before: int = 0
    """Valid ones of this goal that earlier sessions of the day have brought; `counts` are those of this session."""
    last: Literal["valid", "partial", "wrong"] | None = None
    """Of the repetition that was finished last."""
    cue: str = ""
    """The one thing to say now; empty while there is nothing, or nothing certain enough."""
    cue_number: int = 0
    """Grows with each cue, so that the same words said again are known as new."""
