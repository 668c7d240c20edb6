"""The filters of Luinge and of Roetenberg in dense matrices, straight from the method pages: the oracles.

One sensor, no gaps, specific force in m/s^2, global frame with z up. `Rotation` objects hold R_GS.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from estimators.conventions import GRAVITY_MPS2 as G

DEG = np.pi / 180.0
UP = np.array([0.0, 0.0, 1.0])
I3 = np.eye(3)


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turned(vector):
    return Rotation.from_rotvec(vector)


def blocks(*rows):
    return np.block([list(row) for row in rows])


def luinge_consistent(
    gyroscope,
    force,
    step_s,
    start,
    p,
    *,
    sigma_g=0.01,
    sigma_a=0.1,
    c_a=0.6,
    sigma_w=0.4,
    sigma_b=0.3e-3 * DEG,
    bias=(0.0, 0.0, 0.0),
):
    """A5 without rest update from `start` on; lists of rotation, bias, covariance, innovation, its covariance."""
    r, b, a = start, np.array(bias, dtype=float), np.zeros(3)
    out = []
    for y_g, y_a in zip(gyroscope, force, strict=True):
        r = r * turned((y_g - b) * step_s)
        f = blocks((I3, -step_s * r.as_matrix()), (np.zeros((3, 3)), I3))
        p = f @ p @ f.T + np.diag([step_s**2 * sigma_g**2] * 3 + [sigma_b**2] * 3)
        vertical = y_a - r.inv().apply(c_a * a)
        z = (r.apply(vertical / np.linalg.norm(vertical)) - UP)[:2]
        c = np.hstack((-(1 - c_a) * skew(UP), np.zeros((3, 3))))[:2]
        s = c @ p @ c.T + (sigma_w**2 + (1 + c_a**2) * sigma_a**2) / G**2 * np.eye(2)
        gain = p @ c.T @ np.linalg.inv(s)
        x = gain @ z
        r, b = turned(-x[:3]) * r, b - x[3:]
        p = (np.eye(6) - gain @ c) @ p
        p = 0.5 * (p + p.T)
        a = r.apply(y_a) - G * UP
        out.append((r, b, p, z, s))
    return out


def luinge_published(
    gyroscope,
    force,
    step_s,
    start,
    p,
    *,
    sigma_g=0.01,
    sigma_a=0.1,
    c_a=0.6,
    sigma_w=0.4,
    sigma_b=0.3e-3 * DEG,
    bias=(0.0, 0.0, 0.0),
    sign=-1.0,
):
    """A4 from `start` on; `sign` +1 and -a/g is the printed measurement matrix (E-1)."""
    r, b, a = start, np.array(bias, dtype=float), np.zeros(3)
    q_a = sigma_a**2 * I3
    out = []
    for y_g, y_a in zip(gyroscope, force, strict=True):
        r = r * turned((y_g - b) * step_s)
        z_g = r.inv().apply(UP)
        predicted = r.inv().apply(c_a * a)
        z_a = (y_a - predicted) / np.linalg.norm(y_a - predicted)
        q_theta, q_b = p[:3, :3], p[3:, 3:]
        p = blocks(
            (q_theta + step_s**2 * q_b + step_s**2 * sigma_g**2 * I3, -step_s * q_b),
            (-step_s * q_b, q_b + sigma_b**2 * I3),
        )
        c = np.hstack((sign * skew(z_g - sign * predicted / G), np.zeros((3, 3))))
        r_v = (c_a**2 * q_a + sigma_w**2 * I3 + sigma_a**2 * I3) / G**2
        s = c @ p @ c.T + r_v
        gain = p @ c.T @ np.linalg.inv(s)
        z = z_a - z_g
        x = gain @ z
        r, b = r * turned(-x[:3]), b - x[3:]
        p = (np.eye(6) - gain @ c) @ p
        p = 0.5 * (p + p.T)
        z_up = r.inv().apply(UP)
        a = r.apply(y_a - G * z_up)
        q_a = G**2 * skew(z_up) @ p[:3, :3] @ skew(z_up).T + sigma_a**2 * I3
        out.append((r, b, p, z, s))
    return out
