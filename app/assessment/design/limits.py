"""Limits, stop rules and bands that cannot hold: the template's own recording, or a patient at rest, breaks them.

Such a rule stops an exercise before it begins, again after each "Go on". It is refused where it is set, with the
value; one that was stored before is said where it is shown.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.assessment.design.rules import stop_rule
from app.assessment.models import Comparison
from app.errors import InvalidInput
from app.exercises.design import StopDesign
from app.recordings.models import MotionSession
from estimators.comparison import Template, channel_name, channel_unit, comparison_from_bytes, leaves_band
from estimators.guidance import farthest, is_broken, nearest_limit
from estimators.recording import Float
from estimators.sentences import Sentence, say

_MOST: Final = 0.5
"""Share of a template's own repetitions that may leave a band."""


@dataclass(frozen=True)
class Reached:
    """What a movement must be allowed to do.

    Attributes
    ----------
    template : Template
        As drawn, on the side for which the rules are named.
    own : sequence of ndarray, shape (101, C)
        Repetitions of its recording that count; empty where nobody may read them.
    rest : mapping of str to float
        The patient's resting pose, by channel, rad and m.
    """

    template: Template
    own: Sequence[Float] = ()
    rest: Mapping[str, float] = field(default_factory=dict)

    def values(self, channel: str) -> Float:
        """Return every value of a channel in the recording."""
        column = self.template.channels.index(channel)
        return np.concatenate([one[:, column] for one in (self.template.mean, *self.own)])


def check_stops(stops: Sequence[StopDesign], reached: Reached, at: str) -> None:
    """Raise `InvalidInput` for the first stop rule that would stop the recording itself or a patient at rest.

    Parameters
    ----------
    at : str
        Field of the request, for instance `design.stops`.
    """
    for place, trouble in troubles_of(stops, reached):
        raise InvalidInput(trouble, field=f"{at}.{place}")


def troubles_of(stops: Sequence[StopDesign], reached: Reached) -> Iterator[tuple[int, Sentence]]:
    """Yield place and reason of each stop rule that cannot hold; see `check_stops`."""
    template = reached.template
    for place, stop in enumerate(stops):
        number = place + 1
        if stop.kind == "time" and stop.limit < template.duration_s:
            yield place, say("design.time_short", number=number, lasts_s=template.duration_s)
        if stop.kind != "limit" or stop.channel not in template.channels:
            continue
        rule, channel = stop_rule(stop), stop.channel
        name = channel_name(channel)
        value = farthest(stop.side, reached.values(channel))
        rests = reached.rest.get(channel, float("nan"))
        if is_broken(rule, value):
            least = _amount(channel, nearest_limit(channel, stop.side, value))
            amount = _amount(channel, value)
            yield (
                place,
                say("design.limit_above", number=number, channel=name, value=amount, least=least)
                if stop.side == "above"
                else say("design.limit_below", number=number, channel=name, value=amount, least=least),
            )
        elif is_broken(rule, rests):
            least = _amount(channel, nearest_limit(channel, stop.side, rests))
            amount = _amount(channel, rests)
            yield (
                place,
                say("design.rest_above", number=number, channel=name, value=amount, least=least)
                if stop.side == "above"
                else say("design.rest_below", number=number, channel=name, value=amount, least=least),
            )


def check_band(reached: Reached, recorded: Template, at: str) -> None:
    """Raise `InvalidInput` for a band that most of the template's own repetitions leave, though not the recorded one.

    Parameters
    ----------
    reached : Reached
        With the band as it shall be.
    recorded : Template
        With the band as it was recorded.
    at : str
        Field of the request.
    """
    if trouble := narrow_band(reached, recorded):
        raise InvalidInput(trouble, field=at)


def narrow_band(reached: Reached, recorded: Template) -> Sentence | None:
    """Return why a band is too narrow, None where it is not; see `check_band`."""
    count = len(reached.own)
    if not count or (
        np.array_equal(reached.template.below, recorded.below, equal_nan=True)
        and np.array_equal(reached.template.above, recorded.above, equal_nan=True)
    ):
        return None
    now, before = leaves_band(reached.template, reached.own), leaves_band(recorded, reached.own)
    for column, channel in enumerate(reached.template.channels):
        left, excess = now[column]
        if reached.template.counts[column] and left > _MOST * count >= before[column][0]:
            return say(
                "design.band_narrow",
                channel=channel_name(channel),
                left=left,
                of=count,
                excess=_amount(channel, excess),
            )
    return None


def resting_pose(session: Session, patient_id: str, exercise_id: str) -> dict[str, float]:
    """Return how a patient rests before a repetition, by channel: of the newest compared session of an exercise.

    For the service's own work: access to the patient was checked.

    Returns
    -------
    dict of str to float
        Median over the counted repetitions, rad and m; empty where nothing was compared.
    """
    content = session.scalar(
        select(Comparison.content)
        .join(MotionSession, MotionSession.id == Comparison.session_id)
        .where(MotionSession.patient_id == patient_id, MotionSession.exercise_id == exercise_id)
        .order_by(MotionSession.created_at.desc(), Comparison.created_at.desc())
        .limit(1)
    )
    if content is None:
        return {}
    compared = comparison_from_bytes(content)
    begun = [one.curves[0] for one in compared.repetitions if one.repetition.is_kept]
    if not begun:
        return {}
    rest = np.median(np.stack(begun), axis=0)
    return {name: float(value) for name, value in zip(compared.channels, rest, strict=True)}


def _amount(channel: str, value: float) -> Sentence:
    return (
        say("size.length", value_m=value)
        if channel_unit(channel) == "m"
        else say("size.angle", value_rad=value)
    )
