"""Linear algebra of small matrices inside compiled loops."""

from estimators._kernels import step
from estimators.recording import Float


@step()
def mirror(p: Float) -> None:
    """Copy the upper triangle of a square matrix to the lower."""
    for i in range(p.shape[0]):
        for j in range(i):
            p[i, j] = p[j, i]


@step()
def skew(x: float, y: float, z: float, out: Float) -> None:
    """Write the cross-product matrix of a vector, shape (3, 3)."""
    out[0, 0] = out[1, 1] = out[2, 2] = 0.0
    out[0, 1], out[0, 2], out[1, 2] = -z, y, -x
    out[1, 0], out[2, 0], out[2, 1] = z, -y, x


@step()
def invert_symmetric(m: Float, out: Float) -> None:
    """Write the inverse of a symmetric matrix, shape (3, 3)."""
    a, b, c, d, e, f = m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2]
    c00, c01, c02 = d * f - e * e, c * e - b * f, b * e - c * d
    scale = 1.0 / (a * c00 + b * c01 + c * c02)
    out[0, 0], out[0, 1], out[0, 2] = scale * c00, scale * c01, scale * c02
    out[1, 1], out[1, 2] = scale * (a * f - c * c), scale * (b * c - a * e)
    out[2, 2] = scale * (a * d - b * b)
    out[1, 0], out[2, 0], out[2, 1] = out[0, 1], out[0, 2], out[1, 2]
