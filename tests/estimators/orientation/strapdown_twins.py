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


class RoetenbergTwin:
    """Method page 2.3 to 2.5 in the sensor frame; state order (theta, b_e, d_e), all seen from the sensor.

    Two rows of gravity are kept, those across the vertical (E10). After a correction the covariance is turned
    into the new sensor frame, which the page leaves out as of second order.
    """

    def __init__(self, start, bias, p, reference_norm, reference_field, step_s=0.01, **options):
        self.r, self.b, self.p, self.step_s = start, np.array(bias), p, step_s
        self.norm, self.h = reference_norm, np.asarray(reference_field)
        self.dip = np.arctan2(-self.h[2], np.hypot(self.h[0], self.h[1]))
        self.a, self.d = np.zeros(3), np.zeros(3)
        defaults = {
            "sigma_g": 0.01,
            "sigma_a": 0.1,
            "sigma_m": 0.01,
            "c_a": 0.6,
            "sigma_w": 1.0,
            "sigma_b": 0.3e-3 * DEG,
            "c_d": 1.0,
            "floor": 1e-5,
            "gain": 10.0,
            "raw": False,
            "block": False,
            "held": False,
            "compensate": True,
        }
        self.o = defaults | options
        self.q_a = self.o["sigma_w"] ** 2 * I3
        self.smooth = self.last = None
        self.nominal = 0

    def change(self, m, dip):
        """Variance of the disturbance's step, and whether the field is nominal (2.4, 2.5)."""
        now = np.array([m, dip])
        if self.smooth is None:
            self.smooth, self.last = now, now
        step = 0.1 * (now - self.smooth)
        self.smooth = self.smooth + step
        band = 4e-4
        if self.o["raw"]:
            step, band = now - self.last, 0.0
        self.last = now
        off = np.abs(self.smooth - [1.0, self.dip])
        self.nominal = self.nominal + 1 if off[0] < 0.02 and off[1] < 1.2 * DEG else 0
        change = self.o["gain"] * np.sum(np.maximum(np.abs(step) - band, 0.0))
        return self.o["floor"] ** 2 + change**2, self.nominal >= 30 or not self.o["compensate"]

    def step(self, y_g, y_a, y_m):
        o, t = self.o, self.step_s
        before = self.r
        self.r = before * turned((y_g - self.b) * t)
        back = self.r.inv()
        y_m = y_m / self.norm
        m = np.linalg.norm(y_m)
        sigma_d2, nominal = self.change(m, np.arcsin(-self.r.apply(y_m)[2] / m))
        if o["block"]:
            self.p = self.p * np.kron(np.eye(3), np.ones((3, 3)))
        turn = (before.inv() * self.r).as_matrix()
        zero = np.zeros((3, 3))
        f = blocks((turn.T, -t * I3, zero), (zero, I3, zero), (zero, zero, o["c_d"] * turn.T))
        q = np.diag([t**2 * o["sigma_g"] ** 2] * 3 + [o["sigma_b"] ** 2] * 3 + [sigma_d2] * 3)
        p = f @ self.p @ f.T + q
        d = o["c_d"] * self.d
        if nominal:
            d = np.zeros(3)
            p[6:], p[:, 6:] = 0.0, 0.0
            p[6:, 6:] = (o["floor"] ** 2 if o["compensate"] else 0.0) * I3
        a_s, d_s = back.apply(o["c_a"] * self.a), back.apply(d)
        z_g, h_g = back.apply(UP), back.apply(self.h)
        z_a = (y_a - a_s) / np.linalg.norm(y_a - a_s)
        level = self.r.as_matrix()[:2]
        row = -skew(z_g + a_s / G) if o["held"] else -(1 - o["c_a"]) * skew(z_g)
        c = blocks((level @ row, np.zeros((2, 6))), (-skew(h_g + d_s), zero, -I3))
        if o["held"]:
            r_v = (o["c_a"] ** 2 * self.q_a + (o["sigma_w"] ** 2 + o["sigma_a"] ** 2) * I3) / G**2
        else:
            r_v = (o["sigma_w"] ** 2 + (1 + o["c_a"] ** 2) * o["sigma_a"] ** 2) / G**2 * I3
        # Q_a is that of the acceleration in the earth frame: it was turned there with the last estimate.
        noise = np.zeros((5, 5))
        noise[:2, :2] = r_v[:2, :2]
        noise[2:, 2:] = o["sigma_m"] ** 2 * I3
        z = np.concatenate((level @ (z_a - z_g), y_m - d_s - h_g))
        s = c @ p @ c.T + noise
        gain = p @ c.T @ np.linalg.inv(s)
        x = gain @ z
        keep = np.eye(9) - gain @ c
        p = keep @ p @ keep.T + gain @ noise @ gain.T
        after = self.r * turned(-x[:3])
        reset = np.eye(9)
        reset[:3, :3] = reset[6:, 6:] = (after.inv() * self.r).as_matrix()
        self.p = reset @ p @ reset.T
        self.d = d - self.r.apply(x[6:])
        self.r, self.b = after, self.b - x[3:6]
        self.a = after.apply(y_a) - G * UP
        p_up = after.as_matrix() @ self.p[:3, :3] @ after.as_matrix().T
        self.q_a = G**2 * skew(UP) @ p_up @ skew(UP).T + o["sigma_a"] ** 2 * I3
        return z @ np.linalg.solve(s, z)
