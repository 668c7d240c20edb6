"""Field and gradient of circular current loops and dipoles, compiled.

A loop is one row of ten numbers, see the column constants. Exact loops use complete elliptic integrals from the
arithmetic-geometric mean. The mean also yields `s = (1 - m/2 - E/K)/m^2` without a difference of nearly equal
numbers, and with it the radial field over the radius and its slope have closed forms that hold on the axis too:
no series and no switch between branches (Schepers and Veltink 2010, eq. 6-7, erratum E7 of the method page).
"""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, step
from estimators.recording import Float

MU0_TM_PER_A = 4e-7 * math.pi

# Columns of a loop. KIND is 0 for the exact loop, 1 for the dipole of the same moment.
COIL, KIND, TURNS, RADIUS, CENTRE, AXIS = 0, 1, 2, 3, 4, 7
COLUMNS = 10

FieldAndGradient = tuple[float, float, float, float, float, float, float, float, float]
"""Bx, By, Bz and the upper triangle of the symmetric gradient: xx, xy, xz, yy, yz, zz."""

_NINE = "UniTuple(float64, 9)"
_CLOSE = 1e-9
"""Relative gap of the two means at which the next step is exact to the last bit (convergence is quadratic)."""


@step("UniTuple(float64, 2)(float64)")
def elliptic(complementary: float) -> tuple[float, float]:
    """Return K and s = (1 - m/2 - E/K)/m^2 of the complementary parameter 1 - m in (0, 1]."""
    m = 1.0 - complementary
    a, b = 1.0, math.sqrt(complementary)
    mean = 0.5 * (a + b)
    difference = 0.25 / mean
    # Terms of Sum 2^(n-1) (c_n/m)^2, where c_(n+1) = c_n^2 / (4 a_(n+1)) and c_1 = m / (4 a_1).
    total, weight = difference * difference, 1.0
    b = math.sqrt(a * b)
    a = mean
    while a - b > _CLOSE * a:
        mean = 0.5 * (a + b)
        difference = m * difference * difference / (4.0 * mean)
        weight *= 2.0
        total += weight * difference * difference
        b = math.sqrt(a * b)
        a = mean
    return math.pi / (a + b), total


@step(f"{_NINE}(float64, float64, float64, float64, float64, float64, float64, float64)")
def loop_field(
    ampere_turns: float,
    radius: float,
    dx: float,
    dy: float,
    dz: float,
    nx: float,
    ny: float,
    nz: float,
) -> FieldAndGradient:
    """Return field (T) and gradient (T/m) at an offset from the centre of a loop with unit axis n.

    On the wire itself the field diverges: the result is infinite or not a number.
    """
    z = dx * nx + dy * ny + dz * nz
    ex, ey, ez = dx - z * nx, dy - z * ny, dz - z * nz
    p = ex * ex + ey * ey + ez * ez
    rho = math.sqrt(p)
    q, zz = radius * radius, z * z
    near = (radius - rho) * (radius - rho) + zz
    far = (radius + rho) * (radius + rho) + zz
    root = math.sqrt(far)
    k, s = elliptic(near / far)
    m = 4.0 * radius * rho / far
    e = k * (1.0 - 0.5 * m - m * m * s)
    r2 = p + zz
    c = MU0_TM_PER_A * ampere_turns / math.pi
    axial = 0.5 * c / root * (k + (q - r2) / near * e)
    # B_rho over rho: even in rho, finite on the axis
    lateral = (
        2.0 * c * z * k * q / (root * far) * (1.0 / near - 4.0 * s * (1.0 + 2.0 * radius * rho / near) / far)
    )
    d = (p - q) * (p - q)
    sum_pq = p + q
    a = d * sum_pq + 2.0 * zz * (d - 4.0 * p * q) + zz * zz * sum_pq
    # dB_z/drho over rho
    cross = (
        2.0
        * c
        * q
        * k
        / (near * near * root * far * far)
        * (d - 2.0 * zz * sum_pq - 3.0 * zz * zz - 4.0 * a * s / far)
    )
    along = (
        0.5
        * c
        * z
        / (near * near * root * far)
        * ((6.0 * q * (p - zz) - 7.0 * q * q + r2 * r2) * e + near * (q - r2) * k)
    )
    # (dB_rho/drho - B_rho/rho) over rho^2: free of divergence
    stretch = (-along - 2.0 * lateral) / p if p > 1e-14 * q else 0.0
    return (
        axial * nx + lateral * ex,
        axial * ny + lateral * ey,
        axial * nz + lateral * ez,
        lateral * (1.0 - nx * nx) + stretch * ex * ex + 2.0 * cross * ex * nx + along * nx * nx,
        -lateral * nx * ny + stretch * ex * ey + cross * (ex * ny + ey * nx) + along * nx * ny,
        -lateral * nx * nz + stretch * ex * ez + cross * (ex * nz + ez * nx) + along * nx * nz,
        lateral * (1.0 - ny * ny) + stretch * ey * ey + 2.0 * cross * ey * ny + along * ny * ny,
        -lateral * ny * nz + stretch * ey * ez + cross * (ey * nz + ez * ny) + along * ny * nz,
        lateral * (1.0 - nz * nz) + stretch * ez * ez + 2.0 * cross * ez * nz + along * nz * nz,
    )


@step(f"{_NINE}(float64, float64, float64, float64, float64, float64, float64)")
def dipole_field(
    moment: float, dx: float, dy: float, dz: float, nx: float, ny: float, nz: float
) -> FieldAndGradient:
    """Return field and gradient of a dipole of `moment` (A m^2) along the unit vector n."""
    r2 = dx * dx + dy * dy + dz * dz
    r = math.sqrt(r2)
    ux, uy, uz = dx / r, dy / r, dz / r
    t = ux * nx + uy * ny + uz * nz
    b = MU0_TM_PER_A * moment / (4.0 * math.pi * r2 * r)
    j = 3.0 * b / r
    return (
        b * (3.0 * t * ux - nx),
        b * (3.0 * t * uy - ny),
        b * (3.0 * t * uz - nz),
        j * (2.0 * ux * nx + t * (1.0 - 5.0 * ux * ux)),
        j * (ux * ny + uy * nx - 5.0 * t * ux * uy),
        j * (ux * nz + uz * nx - 5.0 * t * ux * uz),
        j * (2.0 * uy * ny + t * (1.0 - 5.0 * uy * uy)),
        j * (uy * nz + uz * ny - 5.0 * t * uy * uz),
        j * (2.0 * uz * nz + t * (1.0 - 5.0 * uz * uz)),
    )


@step(f"{_NINE}(float64[:, ::1], float64, float64, float64, float64, float64)")
def coil_field(
    loops: Float, coil: float, current: float, px: float, py: float, pz: float
) -> FieldAndGradient:
    """Return field and gradient at a point of the source frame of all loops with this coil number."""
    bx = by = bz = xx = xy = xz = yy = yz = zz = 0.0
    for row in range(loops.shape[0]):
        if loops[row, COIL] != coil:
            continue
        dx, dy, dz = px - loops[row, CENTRE], py - loops[row, CENTRE + 1], pz - loops[row, CENTRE + 2]
        nx, ny, nz = loops[row, AXIS], loops[row, AXIS + 1], loops[row, AXIS + 2]
        ampere_turns, radius = loops[row, TURNS] * current, loops[row, RADIUS]
        if loops[row, KIND] == 0.0:
            f = loop_field(ampere_turns, radius, dx, dy, dz, nx, ny, nz)
        else:
            f = dipole_field(ampere_turns * math.pi * radius * radius, dx, dy, dz, nx, ny, nz)
        fx, fy, fz, gxx, gxy, gxz, gyy, gyz, gzz = f
        bx += fx
        by += fy
        bz += fz
        xx += gxx
        xy += gxy
        xz += gxz
        yy += gyy
        yz += gyz
        zz += gzz
    return bx, by, bz, xx, xy, xz, yy, yz, zz


@kernel(
    "void(float64[:, ::1], int64[::1], float64[::1], float64[:, ::1], float64[:, ::1], float64[:, :, ::1])"
)
def coil_fields(
    loops: Float,
    coil: NDArray[np.int64],
    current_a: Float,
    position_m: Float,
    field_t: Float,
    gradient_t_per_m: Float,
) -> None:
    """Fill field, shape (N, 3), and gradient, shape (N, 3, 3), for N points with a coil and a current each."""
    for i in range(position_m.shape[0]):
        x, y, z = position_m[i, 0], position_m[i, 1], position_m[i, 2]
        bx, by, bz, xx, xy, xz, yy, yz, zz = coil_field(loops, float(coil[i]), current_a[i], x, y, z)
        g = gradient_t_per_m[i]
        field_t[i, 0], field_t[i, 1], field_t[i, 2] = bx, by, bz
        g[0, 0], g[0, 1], g[0, 2], g[1, 1], g[1, 2], g[2, 2] = xx, xy, xz, yy, yz, zz
        g[1, 0], g[2, 0], g[2, 1] = xy, xz, yz
