"""The backward step of a fixed-interval smoother (Rauch, Tung and Striebel 1965) on the errors of a filter; compiled.

A model goes through its ticks from the last to the first. At each it predicts state and covariance of the next tick
again, writes by which error the smoothed state there differs from the predicted one, and calls `step_back`; what that
returns in `moved` it injects into its state. So differences are taken where states are no vectors (method page C4,
2.4), and the covariance is the a priori one, which needs no measurement.
"""

from estimators._kernels import step
from estimators.kernels.matrices import cholesky, matrix_multiply, multiply_turned, solve_rows, symmetrise
from estimators.recording import Float

_LEAST_VARIANCE = 1e-16
"""Added to the predicted covariance: states without noise of their own leave it only just positive."""


@step(
    "boolean(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64[::1],"
    "float64[:, :, ::1])"
)
def step_back(
    p: Float, transition: Float, prior: Float, later: Float, error: Float, moved: Float, work: Float
) -> bool:
    """Smooth one tick: K = P Phi^T prior^-1, moved = K error, P += K (later - prior) K^T.

    Parameters
    ----------
    p : ndarray, shape (n, n)
        Covariance of the filter at the tick, symmetric; becomes the smoothed one.
    transition, prior : ndarray, shape (n, n)
        Phi to the next tick, and the covariance predicted there.
    later : ndarray, shape (n, n)
        Smoothed covariance of the next tick.
    error : ndarray, shape (n,)
        Of the smoothed against the predicted state there.
    moved : ndarray, shape (n,)
        Filled: the error to inject at this tick.
    work : ndarray, shape (3, n, n)
        Overwritten.

    Returns
    -------
    bool
        False, with nothing changed, when `prior` is not positive: the tick stays as the filter left it.
    """
    n = p.shape[0]
    gain, factor, product = work[0], work[1], work[2]
    # P Phi^T = (Phi P)^T, for transitions are mostly zero and the product passes zeros over.
    matrix_multiply(transition, p, product)
    for i in range(n):
        for j in range(n):
            gain[i, j] = product[j, i]
            factor[i, j] = prior[i, j]
        factor[i, i] += _LEAST_VARIANCE
    if not cholesky(factor):
        return False
    solve_rows(factor, gain)
    change = factor
    for i in range(n):
        moved[i] = 0.0
        for j in range(n):
            moved[i] += gain[i, j] * error[j]
            change[i, j] = later[i, j] - prior[i, j]
    matrix_multiply(gain, change, product)
    multiply_turned(product, gain, change)
    for i in range(n):
        for j in range(n):
            p[i, j] += change[i, j]
    symmetrise(p)
    return True
