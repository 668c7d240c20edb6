"""The covariance of a state that turns by a matrix of its own, with an offset behind it, for the filters of the thesis.

The first n states y follow y' = F y + W b, the offset b keeps its value. Of the covariance `p` (n + 3, n + 3) only the
upper triangle holds inside a loop over ticks.
"""

from estimators._kernels import Scalars3
from estimators.kernels import mirror, step
from estimators.recording import Float


@step(inlined=True)
def dot(a: Float, b: Float) -> float:
    """Return the sum of products, first to last."""
    total = a[0] * b[0]
    for i in range(1, len(a)):
        total += a[i] * b[i]
    return float(total)


@step(inlined=True)
def predict_cross(p: Float, f: Float, w: Float, g: Float, k: Float, drift: Scalars3) -> None:
    """Carry offset and cross terms: with C the old cross terms N = G + W B, where G = F C; write G and K = F A.

    The block A of the first n states stays, so that its P' = K F' + N W' + W G' can be formed of what is then in `p`.
    """
    n = len(f)
    mirror(p[:n, :n])
    mirror(p[n:, n:])
    for i in range(n):
        for j in range(n):
            k[i, j] = dot(f[i], p[j, :n])
        for j in range(3):
            g[i, j] = dot(f[i], p[:n, n + j])
    for i in range(n):
        for j in range(3):
            p[i, n + j] = g[i, j] + dot(w[i], p[n + j, n:])
    for j in range(3):
        p[n + j, n + j] += drift[j]


@step(inlined=True)
def twice_cross(p: Float, w: Float, g: Float, i: int) -> float:
    """Return the diagonal of N W' + W G', which saves a product each."""
    n = len(g)
    a, b, c = p[i, n] + g[i, 0], p[i, n + 1] + g[i, 1], p[i, n + 2] + g[i, 2]
    return float(w[i, 0] * a + w[i, 1] * b + w[i, 2] * c)


@step(inlined=True)
def downdate(p: Float, h: Float, inverse: float) -> None:
    """Take h h' times `inverse` from the covariance: a scalar measurement with h = P H' and S = 1 / inverse."""
    for i in range(len(h)):
        gain = inverse * h[i]
        for j in range(i, len(h)):
            p[i, j] -= gain * h[j]


__all__ = ["dot", "downdate", "predict_cross", "twice_cross"]
