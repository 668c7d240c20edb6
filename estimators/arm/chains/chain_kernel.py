"""The three ways along a chain of links, compiled: affine matrices, dual quaternions, screw axes.

Every step takes sines and cosines, so that `operation_count` can be tested by running the same functions on
numbers that count what is done with them. The plain numpy twins are in `chains.denavit_hartenberg` and
`chains.dual_quaternion`; both are held to 1e-12 of each other.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.compiling import compiled

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

OFFSET, LENGTH, COSINE, SINE = range(4)
"""A link: the way along the joint axis and along the common normal, and of the twist."""
ORIGIN, LAST = 3, 3
"""Column of a pose that holds its origin, and its last row (0, 0, 0, 1)."""
W, X, Y, Z = range(4)
DUAL, DUAL_QUATERNION = 4, 8
"""Where the dual part of a dual quaternion begins, and how long one is."""


@compiled()
def link_matrix(ct: Any, st: Any, ca: Any, sa: Any, length: Any, offset: Any, out: Any) -> None:
    """Fill the 3x4 matrix Rz(joint) Tz(offset) Tx(length) Rx(twist) of one link."""
    out[0, 0] = ct
    out[0, 1] = -(st * ca)
    out[0, 2] = st * sa
    out[0, ORIGIN] = length * ct
    out[1, 0] = st
    out[1, 1] = ct * ca
    out[1, 2] = -(ct * sa)
    out[1, ORIGIN] = length * st
    out[2, 0] = 0.0
    out[2, 1] = sa
    out[2, 2] = ca
    out[2, ORIGIN] = offset


@compiled()
def affine_product(a: Any, b: Any, out: Any) -> None:
    """Multiply two 3x4 affine matrices whose last row (0, 0, 0, 1) is understood."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
        out[i, ORIGIN] = (
            a[i, 0] * b[0, ORIGIN] + a[i, 1] * b[1, ORIGIN] + a[i, 2] * b[2, ORIGIN] + a[i, ORIGIN]
        )


@compiled()
def dual_product(a: Any, b: Any, out: Any) -> None:
    """Multiply two dual quaternions: (A_r B_r, A_r B_d + A_d B_r)."""
    for part in (0, DUAL):
        w, x, y, z = b[part], b[part + 1], b[part + 2], b[part + 3]
        out[part] = a[0] * w - a[1] * x - a[2] * y - a[3] * z
        out[part + 1] = a[0] * x + a[1] * w + a[2] * z - a[3] * y
        out[part + 2] = a[0] * y - a[1] * z + a[2] * w + a[3] * x
        out[part + 3] = a[0] * z + a[1] * y - a[2] * x + a[3] * w
    w, x, y, z = b[0], b[1], b[2], b[3]
    dw, dx, dy, dz = a[DUAL], a[DUAL + X], a[DUAL + Y], a[DUAL + Z]
    out[DUAL] = out[DUAL] + (dw * w - dx * x - dy * y - dz * z)
    out[DUAL + X] = out[DUAL + X] + (dw * x + dx * w + dy * z - dz * y)
    out[DUAL + Y] = out[DUAL + Y] + (dw * y - dx * z + dy * w + dz * x)
    out[DUAL + Z] = out[DUAL + Z] + (dw * z + dx * y - dy * x + dz * w)


@compiled()
def axes_step(ct: Any, st: Any, ca: Any, sa: Any, length: Any, offset: Any, s: Any, a: Any, p: Any) -> None:
    """Go one link on with joint axis `s`, common normal `a` and origin `p` (Marzouk (4.27) to (4.34))."""
    c0 = s[1] * a[2] - s[2] * a[1]
    c1 = s[2] * a[0] - s[0] * a[2]
    c2 = s[0] * a[1] - s[1] * a[0]
    a[0] = a[0] * ct + c0 * st
    a[1] = a[1] * ct + c1 * st
    a[2] = a[2] * ct + c2 * st
    for i in range(3):
        p[i] = p[i] + offset * s[i] + length * a[i]
    c0 = a[1] * s[2] - a[2] * s[1]
    c1 = a[2] * s[0] - a[0] * s[2]
    c2 = a[0] * s[1] - a[1] * s[0]
    s[0] = s[0] * ca + c0 * sa
    s[1] = s[1] * ca + c1 * sa
    s[2] = s[2] * ca + c2 * sa


def _walk_matrices(joints: Float, links: Float, keep: Integer, out: Float) -> None:
    """Fill `out` (N, F, 4, 4) with the ends of the retained links; `links` (n, 4) is offset, length, cos, sin."""
    pose, link, product = np.empty((3, 4)), np.empty((3, 4)), np.empty((3, 4))
    for k in range(joints.shape[0]):
        for n in range(joints.shape[1]):
            ct, st = math.cos(joints[k, n]), math.sin(joints[k, n])
            link_matrix(ct, st, links[n, COSINE], links[n, SINE], links[n, LENGTH], links[n, OFFSET], link)
            if n == 0:
                pose[:] = link
            else:
                affine_product(pose, link, product)
                pose, product = product, pose
            if keep[n] >= 0:
                for i in range(3):
                    for j in range(4):
                        out[k, keep[n], i, j] = pose[i, j]
                    out[k, keep[n], LAST, i] = 0.0
                out[k, keep[n], LAST, LAST] = 1.0


def _walk_dual(joints: Float, links: Float, keep: Integer, out: Float) -> None:
    """Fill `out` (N, F, 8); `links` (n, 4) is offset, length, cos and sin of *half* the twist."""
    pose, between = np.empty(DUAL_QUATERNION), np.empty(DUAL_QUATERNION)
    along, across = np.zeros(DUAL_QUATERNION), np.zeros(DUAL_QUATERNION)
    for k in range(joints.shape[0]):
        pose[:] = 0.0
        pose[W] = 1.0
        for n in range(joints.shape[1]):
            half = 0.5 * joints[k, n]
            c, s = math.cos(half), math.sin(half)
            shift = 0.5 * links[n, OFFSET]
            along[W], along[Z], along[DUAL + W], along[DUAL + Z] = c, s, -shift * s, shift * c
            c, s = links[n, COSINE], links[n, SINE]
            shift = 0.5 * links[n, LENGTH]
            across[W], across[X], across[DUAL + W], across[DUAL + X] = c, s, -shift * s, shift * c
            dual_product(pose, along, between)
            dual_product(between, across, pose)
            if keep[n] >= 0:
                for i in range(DUAL_QUATERNION):
                    out[k, keep[n], i] = pose[i]


def _walk_axes(joints: Float, links: Float, keep: Integer, out: Float) -> None:
    """Fill `out` (N, F, 4, 4) by the vector form; `links` as for the matrices."""
    s, a, p = np.empty(3), np.empty(3), np.empty(3)
    for k in range(joints.shape[0]):
        s[0], s[1], s[2] = 0.0, 0.0, 1.0
        a[0], a[1], a[2] = 1.0, 0.0, 0.0
        p[:] = 0.0
        for n in range(joints.shape[1]):
            ct, st = math.cos(joints[k, n]), math.sin(joints[k, n])
            axes_step(ct, st, links[n, COSINE], links[n, SINE], links[n, LENGTH], links[n, OFFSET], s, a, p)
            f = keep[n]
            if f >= 0:
                for i in range(3):
                    j, m = (i + 1) % 3, (i + 2) % 3
                    out[k, f, i, 0] = a[i]
                    out[k, f, i, 1] = s[j] * a[m] - s[m] * a[j]
                    out[k, f, i, 2] = s[i]
                    out[k, f, i, ORIGIN] = p[i]
                    out[k, f, LAST, i] = 0.0
                out[k, f, LAST, LAST] = 1.0


def _walk_two_links(q1: Float, q2: Float, upper_arm_m: float, forearm_m: float, out: Float) -> None:
    """Fill `out` (N, 2, 4, 4): elbow and wrist pose of the two-module arm from quaternions (A12)."""
    for k in range(q1.shape[0]):
        for link in range(2):
            q = q1[k] if link == 0 else q2[k]
            length = upper_arm_m if link == 0 else forearm_m
            w, x, y, z = q[0], q[1], q[2], q[3]
            pose = out[k, link]
            pose[0, 0] = 1.0 - 2.0 * (y * y + z * z)
            pose[0, 1] = 2.0 * (x * y - w * z)
            pose[0, 2] = 2.0 * (x * z + w * y)
            pose[1, 0] = 2.0 * (x * y + w * z)
            pose[1, 1] = 1.0 - 2.0 * (x * x + z * z)
            pose[1, 2] = 2.0 * (y * z - w * x)
            pose[2, 0] = 2.0 * (x * z - w * y)
            pose[2, 1] = 2.0 * (y * z + w * x)
            pose[2, 2] = 1.0 - 2.0 * (x * x + y * y)
            for i in range(3):
                start = out[k, 0, i, ORIGIN] if link == 1 else 0.0
                pose[i, ORIGIN] = start + length * pose[i, 0]
                pose[LAST, i] = 0.0
            pose[LAST, LAST] = 1.0


_WALK = "void(f8[:,::1],f8[:,::1],i8[::1],"
walk_matrices = compiled(_WALK + "f8[:,:,:,::1])")(_walk_matrices)
walk_dual = compiled(_WALK + "f8[:,:,::1])")(_walk_dual)
walk_axes = compiled(_WALK + "f8[:,:,:,::1])")(_walk_axes)
walk_two_links = compiled("void(f8[:,::1],f8[:,::1],f8,f8,f8[:,:,:,::1])")(_walk_two_links)
