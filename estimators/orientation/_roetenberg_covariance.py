"""Covariance of orientation, offset and magnetic disturbance held in registers, for Roetenberg's filter.

All numbers are `Lanes` of some sensors side by side.

Of the 9 x 9 matrix the upper triangle travels as two tuples: `Upper` of orientation and offset (21 numbers, see
`_marzouk_covariance`), and `Disturbed` of what has to do with the disturbance (24): orientation by disturbance (9, by
rows), offset by disturbance (9, by rows), disturbance (6). Arrays may overlap as far as the compiler knows, and every
store to one would make it read the others again.
"""

from numba import types

from estimators._lanes import LANES_TYPE, column, in_lanes, of_one, put_column, spread
from estimators.orientation import _marzouk_covariance as scalar
from estimators.orientation._marzouk_covariance import Row, Upper
from estimators.recording import Float

Disturbed = tuple[float, ...]
"""The 24 numbers."""
UPPER, ROW, DISTURBED = (
    types.UniTuple(LANES_TYPE, 21),
    types.UniTuple(LANES_TYPE, 9),
    types.UniTuple(LANES_TYPE, 24),
)
_L, _I, _F, _FLAT = LANES_TYPE, types.intp, types.float64, types.float64[:, ::1]
_ERRORS, _ALIKE = types.UniTuple(LANES_TYPE, 6), types.UniTuple(types.float64, 3)

predicted = in_lanes(UPPER(UPPER, ROW, _ERRORS, _ALIKE))(of_one(scalar.predicted))
lessened = in_lanes(UPPER(UPPER, _L, _ERRORS))(of_one(scalar.lessened))


@in_lanes(UPPER(_FLAT, _I, _I))
def loaded(p: Float, row: int, last: int) -> Upper:
    """Read orientation and offset of sensors side by side from covariances by rows, (S, 81)."""
    return (
        column(p, (row, last, 0)),
        column(p, (row, last, 1)),
        column(p, (row, last, 2)),
        column(p, (row, last, 10)),
        column(p, (row, last, 11)),
        column(p, (row, last, 20)),
        column(p, (row, last, 3)),
        column(p, (row, last, 4)),
        column(p, (row, last, 5)),
        column(p, (row, last, 12)),
        column(p, (row, last, 13)),
        column(p, (row, last, 14)),
        column(p, (row, last, 21)),
        column(p, (row, last, 22)),
        column(p, (row, last, 23)),
        column(p, (row, last, 30)),
        column(p, (row, last, 31)),
        column(p, (row, last, 32)),
        column(p, (row, last, 40)),
        column(p, (row, last, 41)),
        column(p, (row, last, 50)),
    )


@in_lanes(DISTURBED(_FLAT, _I, _I))
def loaded_disturbance(p: Float, row: int, last: int) -> Disturbed:
    """Read the columns of the disturbance from the upper triangles."""
    return (
        column(p, (row, last, 6)),
        column(p, (row, last, 7)),
        column(p, (row, last, 8)),
        column(p, (row, last, 15)),
        column(p, (row, last, 16)),
        column(p, (row, last, 17)),
        column(p, (row, last, 24)),
        column(p, (row, last, 25)),
        column(p, (row, last, 26)),
        column(p, (row, last, 33)),
        column(p, (row, last, 34)),
        column(p, (row, last, 35)),
        column(p, (row, last, 42)),
        column(p, (row, last, 43)),
        column(p, (row, last, 44)),
        column(p, (row, last, 51)),
        column(p, (row, last, 52)),
        column(p, (row, last, 53)),
        column(p, (row, last, 60)),
        column(p, (row, last, 61)),
        column(p, (row, last, 62)),
        column(p, (row, last, 70)),
        column(p, (row, last, 71)),
        column(p, (row, last, 80)),
    )


@in_lanes(types.void(_FLAT, _I, _I, UPPER, DISTURBED))
def keep(p: Float, row: int, last: int, upper: Upper, d: Disturbed) -> None:
    """Write the upper triangles."""
    put_column(p, (row, last, 0), upper[0])
    put_column(p, (row, last, 1), upper[1])
    put_column(p, (row, last, 2), upper[2])
    put_column(p, (row, last, 10), upper[3])
    put_column(p, (row, last, 11), upper[4])
    put_column(p, (row, last, 20), upper[5])
    put_column(p, (row, last, 3), upper[6])
    put_column(p, (row, last, 4), upper[7])
    put_column(p, (row, last, 5), upper[8])
    put_column(p, (row, last, 12), upper[9])
    put_column(p, (row, last, 13), upper[10])
    put_column(p, (row, last, 14), upper[11])
    put_column(p, (row, last, 21), upper[12])
    put_column(p, (row, last, 22), upper[13])
    put_column(p, (row, last, 23), upper[14])
    put_column(p, (row, last, 30), upper[15])
    put_column(p, (row, last, 31), upper[16])
    put_column(p, (row, last, 32), upper[17])
    put_column(p, (row, last, 40), upper[18])
    put_column(p, (row, last, 41), upper[19])
    put_column(p, (row, last, 50), upper[20])
    put_column(p, (row, last, 6), d[0])
    put_column(p, (row, last, 7), d[1])
    put_column(p, (row, last, 8), d[2])
    put_column(p, (row, last, 15), d[3])
    put_column(p, (row, last, 16), d[4])
    put_column(p, (row, last, 17), d[5])
    put_column(p, (row, last, 24), d[6])
    put_column(p, (row, last, 25), d[7])
    put_column(p, (row, last, 26), d[8])
    put_column(p, (row, last, 33), d[9])
    put_column(p, (row, last, 34), d[10])
    put_column(p, (row, last, 35), d[11])
    put_column(p, (row, last, 42), d[12])
    put_column(p, (row, last, 43), d[13])
    put_column(p, (row, last, 44), d[14])
    put_column(p, (row, last, 51), d[15])
    put_column(p, (row, last, 52), d[16])
    put_column(p, (row, last, 53), d[17])
    put_column(p, (row, last, 60), d[18])
    put_column(p, (row, last, 61), d[19])
    put_column(p, (row, last, 62), d[20])
    put_column(p, (row, last, 70), d[21])
    put_column(p, (row, last, 71), d[22])
    put_column(p, (row, last, 80), d[23])


@in_lanes(UPPER(UPPER))
def block(p: Upper) -> Upper:
    """Forget what orientation and offset have to do with each other, as the published filter does (E5)."""
    none = spread(0.0)
    cross = (none, none, none, none, none, none, none, none, none)
    return p[:6] + cross + p[15:]


@in_lanes(DISTURBED(DISTURBED))
def disturbance_block(d: Disturbed) -> Disturbed:
    """Forget what the disturbance has to do with orientation and offset (E5)."""
    none = spread(0.0)
    cross = (none, none, none, none, none, none, none, none, none)
    return cross + cross + d[18:]


@in_lanes(DISTURBED(_F))
def no_disturbance(floor: float) -> Disturbed:
    """Return the blocks of a disturbance that is known to be none, to a variance of `floor` (page 2.5)."""
    none, least = spread(0.0), spread(floor)
    cross = (none, none, none, none, none, none, none, none, none)
    return cross + cross + (least, none, none, least, none, least)


@in_lanes(DISTURBED(DISTURBED, ROW, _L))
def predicted_disturbance(d: Disturbed, turned: Row, change: float) -> Disturbed:
    """Carry the blocks of the disturbance: delta' = c_d delta + w_d, and xi' = xi - T R b against it."""
    x00, x01, x02, x10, x11, x12, x20, x21, x22 = d[:9]
    b00, b01, b02, b10, b11, b12, b20, b21, b22 = d[9:18]
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turned
    return (
        x00 - (r00 * b00 + r01 * b10 + r02 * b20),
        x01 - (r00 * b01 + r01 * b11 + r02 * b21),
        x02 - (r00 * b02 + r01 * b12 + r02 * b22),
        x10 - (r10 * b00 + r11 * b10 + r12 * b20),
        x11 - (r10 * b01 + r11 * b11 + r12 * b21),
        x12 - (r10 * b02 + r11 * b12 + r12 * b22),
        x20 - (r20 * b00 + r21 * b10 + r22 * b20),
        x21 - (r20 * b01 + r21 * b11 + r22 * b21),
        x22 - (r20 * b02 + r21 * b12 + r22 * b22),
        b00,
        b01,
        b02,
        b10,
        b11,
        b12,
        b20,
        b21,
        b22,
        d[18] + change,
        d[19],
        d[20],
        d[21] + change,
        d[22],
        d[23] + change,
    )


@in_lanes(DISTURBED(DISTURBED, _F))
def faded(d: Disturbed, gain: float) -> Disturbed:
    """Return the blocks of a disturbance of which the share `gain` is left."""
    square = gain * gain
    return (
        gain * d[0],
        gain * d[1],
        gain * d[2],
        gain * d[3],
        gain * d[4],
        gain * d[5],
        gain * d[6],
        gain * d[7],
        gain * d[8],
        gain * d[9],
        gain * d[10],
        gain * d[11],
        gain * d[12],
        gain * d[13],
        gain * d[14],
        gain * d[15],
        gain * d[16],
        gain * d[17],
        square * d[18],
        square * d[19],
        square * d[20],
        square * d[21],
        square * d[22],
        square * d[23],
    )


@in_lanes(DISTURBED(DISTURBED, _L, ROW))
def lessened_disturbance(d: Disturbed, inverse: float, h: Row) -> Disturbed:
    """Take h h' times `inverse` from the columns of the disturbance: a scalar measurement with h = P H'."""
    h0, h1, h2, h3, h4, h5, h6, h7, h8 = h
    g6, g7, g8 = inverse * h6, inverse * h7, inverse * h8
    return (
        d[0] - h0 * g6,
        d[1] - h0 * g7,
        d[2] - h0 * g8,
        d[3] - h1 * g6,
        d[4] - h1 * g7,
        d[5] - h1 * g8,
        d[6] - h2 * g6,
        d[7] - h2 * g7,
        d[8] - h2 * g8,
        d[9] - h3 * g6,
        d[10] - h3 * g7,
        d[11] - h3 * g8,
        d[12] - h4 * g6,
        d[13] - h4 * g7,
        d[14] - h4 * g8,
        d[15] - h5 * g6,
        d[16] - h5 * g7,
        d[17] - h5 * g8,
        d[18] - g6 * h6,
        d[19] - g6 * h7,
        d[20] - g6 * h8,
        d[21] - g7 * h7,
        d[22] - g7 * h8,
        d[23] - g8 * h8,
    )


@in_lanes(ROW(UPPER, DISTURBED))
def first_column(p: Upper, d: Disturbed) -> Row:
    """Return the column of the orientation error about x."""
    return p[0], p[1], p[2], p[6], p[7], p[8], d[0], d[1], d[2]


@in_lanes(ROW(UPPER, DISTURBED))
def second_column(p: Upper, d: Disturbed) -> Row:
    """Return the column of the orientation error about y."""
    return p[1], p[3], p[4], p[9], p[10], p[11], d[3], d[4], d[5]


@in_lanes(ROW(UPPER, DISTURBED))
def third_column(p: Upper, d: Disturbed) -> Row:
    """Return the column of the orientation error about z."""
    return p[2], p[4], p[5], p[12], p[13], p[14], d[6], d[7], d[8]


@in_lanes(ROW(_L, ROW, _L, ROW))
def mixed(a: float, first: Row, b: float, second: Row) -> Row:
    """Return a * first + b * second."""
    return (
        a * first[0] + b * second[0],
        a * first[1] + b * second[1],
        a * first[2] + b * second[2],
        a * first[3] + b * second[3],
        a * first[4] + b * second[4],
        a * first[5] + b * second[5],
        a * first[6] + b * second[6],
        a * first[7] + b * second[7],
        a * first[8] + b * second[8],
    )


@in_lanes(ROW(ROW, _L, _L, _L, _L, _L, _L, _L, _L, _L))
def less(
    row: Row,
    a: float,
    b: float,
    c: float,
    d: float,
    e: float,
    f: float,
    g: float,
    h: float,
    i: float,
) -> Row:
    """Return a row less nine numbers."""
    return (
        row[0] - a,
        row[1] - b,
        row[2] - c,
        row[3] - d,
        row[4] - e,
        row[5] - f,
        row[6] - g,
        row[7] - h,
        row[8] - i,
    )


__all__ = [
    "DISTURBED",
    "ROW",
    "UPPER",
    "Disturbed",
    "block",
    "disturbance_block",
    "faded",
    "first_column",
    "keep",
    "less",
    "lessened",
    "lessened_disturbance",
    "loaded",
    "loaded_disturbance",
    "mixed",
    "no_disturbance",
    "predicted",
    "predicted_disturbance",
    "second_column",
    "third_column",
]
