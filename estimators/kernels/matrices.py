"""Factor, solve and multiply small matrices inside compiled loops."""

import math

from estimators._kernels import step
from estimators.recording import Float


@step("boolean(float64[:, ::1])")
def cholesky(a: Float) -> bool:
    """Replace the lower triangle of a symmetric matrix by its Cholesky factor; false if it is not positive."""
    n = a.shape[0]
    for j in range(n):
        total = a[j, j]
        for k in range(j):
            total -= a[j, k] * a[j, k]
        if not total > 0.0:
            return False
        root = math.sqrt(total)
        a[j, j] = root
        for i in range(j + 1, n):
            total = a[i, j]
            for k in range(j):
                total -= a[i, k] * a[j, k]
            a[i, j] = total / root
    return True


@step("void(float64[:, ::1], float64[::1])")
def solve(factor: Float, b: Float) -> None:
    """Solve with a Cholesky factor, in place."""
    n = factor.shape[0]
    for i in range(n):
        total = b[i]
        for k in range(i):
            total -= factor[i, k] * b[k]
        b[i] = total / factor[i, i]
    for i in range(n - 1, -1, -1):
        total = b[i]
        for k in range(i + 1, n):
            total -= factor[k, i] * b[k]
        b[i] = total / factor[i, i]


@step("void(float64[:, ::1], float64[:, ::1])")
def solve_rows(factor: Float, rows: Float) -> None:
    """Solve for every row of a matrix, in place: `rows` becomes rows times the inverse."""
    for i in range(rows.shape[0]):
        solve(factor, rows[i])


@step("void(float64[:, ::1], float64[:, ::1], float64[:, ::1])")
def matrix_multiply(a: Float, b: Float, out: Float) -> None:
    """Write a times b; zeros of a are passed over, for transitions are mostly zero."""
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            out[i, j] = 0.0
        for k in range(a.shape[1]):
            value = a[i, k]
            if value != 0.0:
                for j in range(b.shape[1]):
                    out[i, j] += value * b[k, j]


@step("void(float64[:, ::1], float64[:, ::1], float64[:, ::1])")
def multiply_turned(a: Float, b: Float, out: Float) -> None:
    """Write a times the transpose of b."""
    for i in range(a.shape[0]):
        for j in range(b.shape[0]):
            total = 0.0
            for k in range(a.shape[1]):
                total += a[i, k] * b[j, k]
            out[i, j] = total


@step("void(float64[:, ::1])")
def symmetrise(a: Float) -> None:
    """Take the mean of a matrix and its transpose."""
    for i in range(a.shape[0]):
        for j in range(i):
            mean = 0.5 * (a[i, j] + a[j, i])
            a[i, j] = mean
            a[j, i] = mean


@step("void(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1])")
def joseph(p: Float, h: Float, r: Float, gain: Float, work: Float) -> None:
    """Replace P by (I - K H) P (I - K H)^T + K R K^T and symmetrise.

    Parameters
    ----------
    p : ndarray, shape (n, n)
    h : ndarray, shape (m, n)
    r : ndarray, shape (m, m)
    gain : ndarray, shape (n, m)
    work : ndarray, shape (n, n)
        Overwritten.
    """
    n, m = gain.shape
    # work = (I - K H) P, through H P, of which only the columns of H that are not zero count
    for i in range(n):
        for j in range(n):
            work[i, j] = p[i, j]
    for a in range(m):
        for j in range(n):
            total = 0.0
            for k in range(n):
                if h[a, k] != 0.0:
                    total += h[a, k] * p[k, j]
            for i in range(n):
                work[i, j] -= gain[i, a] * total
    for i in range(n):
        for j in range(n):
            p[i, j] = work[i, j]
    for a in range(m):
        for i in range(n):
            total = 0.0
            for k in range(n):
                if h[a, k] != 0.0:
                    total += work[i, k] * h[a, k]
            noise = 0.0
            for b in range(m):
                noise += gain[i, b] * r[b, a]
            total -= noise
            for j in range(n):
                p[i, j] -= total * gain[j, a]
    symmetrise(p)
