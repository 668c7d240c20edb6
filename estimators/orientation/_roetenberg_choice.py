"""What Roetenberg's filter knows of sensors side by side, and the choice between two such states lane by lane."""

from numba import types

from estimators._lanes import MASK_TYPE, chosen, in_lanes
from estimators.orientation._marzouk_covariance import Row, Upper
from estimators.orientation._roetenberg_covariance import DISTURBED, ROW, UPPER, Disturbed

STATE = types.Tuple((UPPER, DISTURBED, ROW))
State = tuple[Upper, Disturbed, Row]
"""Covariance of orientation and offset; that of the disturbance; the errors found so far."""


@in_lanes(UPPER(MASK_TYPE, UPPER, UPPER))
def either(mask: bool, yes: Upper, no: Upper) -> Upper:
    """Return one covariance where the mask is true and the other elsewhere."""
    return (
        chosen(mask, yes[0], no[0]),
        chosen(mask, yes[1], no[1]),
        chosen(mask, yes[2], no[2]),
        chosen(mask, yes[3], no[3]),
        chosen(mask, yes[4], no[4]),
        chosen(mask, yes[5], no[5]),
        chosen(mask, yes[6], no[6]),
        chosen(mask, yes[7], no[7]),
        chosen(mask, yes[8], no[8]),
        chosen(mask, yes[9], no[9]),
        chosen(mask, yes[10], no[10]),
        chosen(mask, yes[11], no[11]),
        chosen(mask, yes[12], no[12]),
        chosen(mask, yes[13], no[13]),
        chosen(mask, yes[14], no[14]),
        chosen(mask, yes[15], no[15]),
        chosen(mask, yes[16], no[16]),
        chosen(mask, yes[17], no[17]),
        chosen(mask, yes[18], no[18]),
        chosen(mask, yes[19], no[19]),
        chosen(mask, yes[20], no[20]),
    )


@in_lanes(DISTURBED(MASK_TYPE, DISTURBED, DISTURBED))
def either_disturbance(mask: bool, yes: Disturbed, no: Disturbed) -> Disturbed:
    """Return the blocks of one disturbance where the mask is true and those of the other elsewhere."""
    return (
        chosen(mask, yes[0], no[0]),
        chosen(mask, yes[1], no[1]),
        chosen(mask, yes[2], no[2]),
        chosen(mask, yes[3], no[3]),
        chosen(mask, yes[4], no[4]),
        chosen(mask, yes[5], no[5]),
        chosen(mask, yes[6], no[6]),
        chosen(mask, yes[7], no[7]),
        chosen(mask, yes[8], no[8]),
        chosen(mask, yes[9], no[9]),
        chosen(mask, yes[10], no[10]),
        chosen(mask, yes[11], no[11]),
        chosen(mask, yes[12], no[12]),
        chosen(mask, yes[13], no[13]),
        chosen(mask, yes[14], no[14]),
        chosen(mask, yes[15], no[15]),
        chosen(mask, yes[16], no[16]),
        chosen(mask, yes[17], no[17]),
        chosen(mask, yes[18], no[18]),
        chosen(mask, yes[19], no[19]),
        chosen(mask, yes[20], no[20]),
        chosen(mask, yes[21], no[21]),
        chosen(mask, yes[22], no[22]),
        chosen(mask, yes[23], no[23]),
    )


@in_lanes(STATE(MASK_TYPE, STATE, STATE), inlined=False)
def either_state(mask: bool, yes: State, no: State) -> State:
    """Return one state where the mask is true and the other elsewhere."""
    a, b = yes[2], no[2]
    return (
        either(mask, yes[0], no[0]),
        either_disturbance(mask, yes[1], no[1]),
        (
            chosen(mask, a[0], b[0]),
            chosen(mask, a[1], b[1]),
            chosen(mask, a[2], b[2]),
            chosen(mask, a[3], b[3]),
            chosen(mask, a[4], b[4]),
            chosen(mask, a[5], b[5]),
            chosen(mask, a[6], b[6]),
            chosen(mask, a[7], b[7]),
            chosen(mask, a[8], b[8]),
        ),
    )


__all__ = ["STATE", "State", "either", "either_disturbance", "either_state"]
