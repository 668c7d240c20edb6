"""Decorators of compiled loops and of their steps, and scalar quaternion helpers that they take in.

A kernel is compiled when it is first called, for one explicit signature over C-contiguous float64, and stored in
numba's cache beside the source (`NUMBA_CACHE_DIR` in a read-only installation) until anything changes that goes into
its machine code. A step becomes part of each kernel that calls it.

Helpers take and give scalars in tuples, so that no array is made inside a loop. Quaternions are wxyz.
"""

import math
from collections.abc import Callable
from typing import Any, TypeVar

from estimators.compiling import compiled

F = TypeVar("F", bound=Callable[..., Any])


def kernel(signature: Any) -> Callable[[F], F]:
    """Compile a loop that Python calls: no GIL, cached, IEEE arithmetic (so chunking cannot change bits).

    Parameters
    ----------
    signature : str, numba signature or list of them
        For instance `"void(float64[:, ::1], float64)"`.

    Returns
    -------
    callable
        Decorator; the plain Python function stays reachable as `.py_func` for tests.
    """
    return compiled(signature)


def step(signature: Any = None, *, inlined: bool = False) -> Callable[[F], F]:
    """Lower a function into the kernels that call it; otherwise as `kernel`.

    Parameters
    ----------
    signature : str or numba signature, optional
        Without, the types are those that its callers hand over.
    inlined : bool
        Always put the code into its caller, where the compiler finds it too large for that.

    Returns
    -------
    callable
        Decorator; the plain Python function stays reachable as `.py_func`.
    """
    return compiled(signature, is_entry=False, forceinline=inlined)


Scalars3 = tuple[float, float, float]
Scalars4 = tuple[float, float, float, float]

_QUATERNION = "UniTuple(float64, 4)"
_VECTOR = "UniTuple(float64, 3)"
_F = "float64"

SMALL_ANGLE_RAD = 1e-4
"""Below this a two-term series is exact to the last bit: the next term is under angle^4 / 120 = 1e-18."""


@step(f"{_QUATERNION}({', '.join([_F] * 8)})", inlined=True)
def multiply(
    pw: float, px: float, py: float, pz: float, qw: float, qx: float, qy: float, qz: float
) -> Scalars4:
    """Return the Hamilton product p * q."""
    return (
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


@step(f"{_VECTOR}({', '.join([_F] * 7)})")
def rotate(w: float, x: float, y: float, z: float, vx: float, vy: float, vz: float) -> Scalars3:
    """Rotate the vector v by the unit quaternion."""
    tx = 2.0 * (y * vz - z * vy)
    ty = 2.0 * (z * vx - x * vz)
    tz = 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


@step(f"{_VECTOR}({', '.join([_F] * 7)})")
def rotate_back(w: float, x: float, y: float, z: float, vx: float, vy: float, vz: float) -> Scalars3:
    """Rotate the vector v by the conjugate of the unit quaternion."""
    return rotate(w, -x, -y, -z, vx, vy, vz)


@step(f"{_QUATERNION}(float64, float64, float64)")
def exponential(rx: float, ry: float, rz: float) -> Scalars4:
    """Return the unit quaternion of a rotation vector in radians."""
    angle = math.sqrt(rx * rx + ry * ry + rz * rz)
    # sin(a/2)/a and its series 1/2 - a^2/48 around zero
    scale = 0.5 - angle * angle / 48.0 if angle < SMALL_ANGLE_RAD else math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), rx * scale, ry * scale, rz * scale


@step(f"{_QUATERNION}(float64, float64, float64, float64)")
def normalized(w: float, x: float, y: float, z: float) -> Scalars4:
    """Return the quaternion at unit norm; the zero quaternion becomes the identity."""
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    if norm == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    return w / norm, x / norm, y / norm, z / norm


@step("float64(float64)")
def wrapped(angle: float) -> float:
    """Bring an angle to the interval [-pi, pi)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))
