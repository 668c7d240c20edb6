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


@compiled()
def link_matrix(ct: Any, st: Any, ca: Any, sa: Any, length: Any, offset: Any, out: Any) -> None:
    """Fill the 3x4 matrix Rz(joint) Tz(offset) Tx(length) Rx(twist) of one link."""
    out[0, 0] = ct
    out[0, 1] = -(st * ca)
    out[0, 2] = st * sa
    out[0, 3] = length * ct
    out[1, 0] = st
    out[1, 1] = ct * ca
    out[1, 2] = -(ct * sa)
    out[1, 3] = length * st
    out[2, 0] = 0.0
    out[2, 1] = sa
    out[2, 2] = ca
    out[2, 3] = offset


@compiled()
def affine_product(a: Any, b: Any, out: Any) -> None:
    """Multiply two 3x4 affine matrices whose last row (0, 0, 0, 1) is understood."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
        out[i, 3] = a[i, 0] * b[0, 3] + a[i, 1] * b[1, 3] + a[i, 2] * b[2, 3] + a[i, 3]


@compiled()
def dual_product(a: Any, b: Any, out: Any) -> None:
    """Multiply two dual quaternions: (A_r B_r, A_r B_d + A_d B_r)."""
    for part in range(0, 8, 4):
        w, x, y, z = b[part], b[part + 1], b[part + 2], b[part + 3]
        out[part] = a[0] * w - a[1] * x - a[2] * y - a[3] * z
        out[part + 1] = a[0] * x + a[1] * w + a[2] * z - a[3] * y
        out[part + 2] = a[0] * y - a[1] * z + a[2] * w + a[3] * x
        out[part + 3] = a[0] * z + a[1] * y - a[2] * x + a[3] * w
    w, x, y, z = b[0], b[1], b[2], b[3]
    out[4] = out[4] + (a[4] * w - a[5] * x - a[6] * y - a[7] * z)
    out[5] = out[5] + (a[4] * x + a[5] * w + a[6] * z - a[7] * y)
    out[6] = out[6] + (a[4] * y - a[5] * z + a[6] * w + a[7] * x)
    out[7] = out[7] + (a[4] * z + a[5] * y - a[6] * x + a[7] * w)


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
            link_matrix(ct, st, links[n, 2], links[n, 3], links[n, 1], links[n, 0], link)
            if n == 0:
                pose[:] = link
            else:
                affine_product(pose, link, product)
                pose, product = product, pose
            if keep[n] >= 0:
                for i in range(3):
                    for j in range(4):
                        out[k, keep[n], i, j] = pose[i, j]
                    out[k, keep[n], 3, i] = 0.0
                out[k, keep[n], 3, 3] = 1.0


def _walk_dual(joints: Float, links: Float, keep: Integer, out: Float) -> None:
    """Fill `out` (N, F, 8); `links` (n, 4) is offset, length, cos and sin of *half* the twist."""
    pose, between = np.empty(8), np.empty(8)
    along, across = np.zeros(8), np.zeros(8)
    for k in range(joints.shape[0]):
        pose[:] = 0.0
        pose[0] = 1.0
        for n in range(joints.shape[1]):
            half = 0.5 * joints[k, n]
            c, s = math.cos(half), math.sin(half)
            shift = 0.5 * links[n, 0]
            along[0], along[3], along[4], along[7] = c, s, -shift * s, shift * c
            c, s = links[n, 2], links[n, 3]
            shift = 0.5 * links[n, 1]
            across[0], across[1], across[4], across[5] = c, s, -shift * s, shift * c
            dual_product(pose, along, between)
            dual_product(between, across, pose)
            if keep[n] >= 0:
                for i in range(8):
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
            axes_step(ct, st, links[n, 2], links[n, 3], links[n, 1], links[n, 0], s, a, p)
            f = keep[n]
            if f >= 0:
                for i in range(3):
                    j, m = (i + 1) % 3, (i + 2) % 3
                    out[k, f, i, 0] = a[i]
                    out[k, f, i, 1] = s[j] * a[m] - s[m] * a[j]
                    out[k, f, i, 2] = s[i]
                    out[k, f, i, 3] = p[i]
                    out[k, f, 3, i] = 0.0
                out[k, f, 3, 3] = 1.0


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
                start = out[k, 0, i, 3] if link == 1 else 0.0
                pose[i, 3] = start + length * pose[i, 0]
                pose[3, i] = 0.0
            pose[3, 3] = 1.0


_WALK = "void(f8[:,::1],f8[:,::1],i8[::1],"
walk_matrices = compiled(_WALK + "f8[:,:,:,::1])")(_walk_matrices)
walk_dual = compiled(_WALK + "f8[:,:,::1])")(_walk_dual)
walk_axes = compiled(_WALK + "f8[:,:,:,::1])")(_walk_axes)
walk_two_links = compiled("void(f8[:,::1],f8[:,::1],f8,f8,f8[:,:,:,::1])")(_walk_two_links)
