"""Covariance of orientation, offset and magnetic disturbance held in scalars, for Roetenberg's filter.

Of the 9 x 9 matrix the upper triangle travels as two tuples: `Upper` of orientation and offset (21 numbers, see
`_marzouk_covariance`), and `Disturbed` of what has to do with the disturbance (24): orientation by disturbance (9, by
rows), offset by disturbance (9, by rows), disturbance (6). Arrays may overlap as far as the compiler knows, and every
store to one would make it read the others again.
"""

from estimators._kernels import kernel
from estimators.orientation._marzouk_covariance import ROW, UPPER, Row, Upper
from estimators.recording import Float

Disturbed = tuple[float, ...]
"""The 24 numbers."""
DISTURBED = "UniTuple(float64, 24)"


@kernel(f"{DISTURBED}(float64[:, ::1])", inlined=True)
def loaded_disturbance(p: Float) -> Disturbed:
    """Read the columns of the disturbance from the upper triangle of a 9 x 9 matrix."""
    return (
        p[0, 6],
        p[0, 7],
        p[0, 8],
        p[1, 6],
        p[1, 7],
        p[1, 8],
        p[2, 6],
        p[2, 7],
        p[2, 8],
        p[3, 6],
        p[3, 7],
        p[3, 8],
        p[4, 6],
        p[4, 7],
        p[4, 8],
        p[5, 6],
        p[5, 7],
        p[5, 8],
        p[6, 6],
        p[6, 7],
        p[6, 8],
        p[7, 7],
        p[7, 8],
        p[8, 8],
    )


@kernel(f"void(float64[:, ::1], {DISTURBED})", inlined=True)
def keep_disturbance(p: Float, d: Disturbed) -> None:
    """Write the columns of the disturbance to the upper triangle of a 9 x 9 matrix."""
    p[0, 6], p[0, 7], p[0, 8], p[1, 6], p[1, 7], p[1, 8], p[2, 6], p[2, 7], p[2, 8] = d[:9]
    p[3, 6], p[3, 7], p[3, 8], p[4, 6], p[4, 7], p[4, 8], p[5, 6], p[5, 7], p[5, 8] = d[9:18]
    p[6, 6], p[6, 7], p[6, 8], p[7, 7], p[7, 8], p[8, 8] = d[18:]


@kernel(f"{DISTURBED}(float64)", inlined=True)
def no_disturbance(floor: float) -> Disturbed:
    """Return the blocks of a disturbance that is known to be none, to a variance of `floor` (page 2.5)."""
    none = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return none + none + none + (floor, 0.0, 0.0, floor, 0.0, floor)


@kernel(f"{DISTURBED}({DISTURBED}, {ROW}, float64)", inlined=True)
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


@kernel(f"{DISTURBED}({DISTURBED}, float64)", inlined=True)
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


@kernel(f"{DISTURBED}({DISTURBED}, float64, {ROW})", inlined=True)
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


@kernel(f"{ROW}({UPPER}, {DISTURBED})", inlined=True)
def first_column(p: Upper, d: Disturbed) -> Row:
    """Return the column of the orientation error about x."""
    return p[0], p[1], p[2], p[6], p[7], p[8], d[0], d[1], d[2]


@kernel(f"{ROW}({UPPER}, {DISTURBED})", inlined=True)
def second_column(p: Upper, d: Disturbed) -> Row:
    """Return the column of the orientation error about y."""
    return p[1], p[3], p[4], p[9], p[10], p[11], d[3], d[4], d[5]


@kernel(f"{ROW}({UPPER}, {DISTURBED})", inlined=True)
def third_column(p: Upper, d: Disturbed) -> Row:
    """Return the column of the orientation error about z."""
    return p[2], p[4], p[5], p[12], p[13], p[14], d[6], d[7], d[8]


@kernel(f"{ROW}(float64, {ROW}, float64, {ROW})", inlined=True)
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


@kernel(
    f"{ROW}({ROW}, float64, float64, float64, float64, float64, float64, float64, float64, float64)",
    inlined=True,
)
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
    "Disturbed",
    "faded",
    "first_column",
    "keep_disturbance",
    "less",
    "lessened_disturbance",
    "loaded_disturbance",
    "mixed",
    "no_disturbance",
    "predicted_disturbance",
    "second_column",
    "third_column",
]
