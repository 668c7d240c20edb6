"""The two quaternion filters of the thesis in dense matrices, straight from the method page: the oracle.

Thesis convention throughout (north-east-down, gravity-positive accelerometer in g). One sensor, no gaps.
"""

import numpy as np

DEG = np.pi / 180.0
SIGMA_E = np.array([0.5737, 0.9096, 6.5572]) * DEG**2
SIGMA_B = np.array([0.2460, 0.3601, 0.2684]) * DEG**2


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def product(p, q):
    return np.concatenate(
        ([p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))
    )


def exponential(r):
    angle = np.linalg.norm(r)
    return np.concatenate(([np.cos(angle / 2)], 0.5 * np.sinc(angle / (2 * np.pi)) * r))


def omega(u):
    p, q, r = u
    return np.array([[0, -p, -q, -r], [p, 0, r, -q], [q, -r, 0, p], [r, q, -p, 0]])


def xi(q):
    return np.array([[-q[1], -q[2], -q[3]], [q[0], -q[3], q[2]], [q[3], q[0], -q[1]], [-q[2], q[1], q[0]]])


def passive(q):
    """C of A7.2: v_sensor = C v_U."""
    w, v = q[0], q[1:]
    return ((w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * skew(v)).T


def euler(q):
    c = passive(q)
    return np.array(
        [np.arctan2(c[1, 2], c[2, 2]), -np.arcsin(np.clip(c[0, 2], -1, 1)), np.arctan2(c[0, 1], c[0, 0])]
    )


def from_euler(angles):
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles / 2), np.sin(angles / 2)
    return np.array(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )


def measured_angles(s, m):
    """A4, and A5 with s at unit norm: as printed on the page it holds for no other."""
    s = s / np.linalg.norm(s)
    roll = np.arctan2(s[1], s[2])
    pitch = np.arctan2(-s[0], s[1] * np.sin(roll) + s[2] * np.cos(roll))
    cross = np.cross(m, s)
    return np.array([roll, pitch, np.arctan2(-cross[0], s[1] * cross[2] - s[2] * cross[1])])


def wrap(angle):
    return np.mod(angle + np.pi, 2 * np.pi) - np.pi


def start(gravity, field, samples):
    return from_euler(measured_angles(gravity[:samples].mean(axis=0), field[:samples].mean(axis=0)))


def angle_rows(q):
    """The rows of A9.4, shape (3, 4)."""
    c = passive(q)
    guard = 1e-6
    roll = (
        2
        / max(c[1, 2] ** 2 + c[2, 2] ** 2, guard)
        * np.array(
            [
                q[1] * c[2, 2],
                q[0] * c[2, 2] + 2 * q[1] * c[1, 2],
                q[3] * c[2, 2] + 2 * q[2] * c[1, 2],
                q[2] * c[2, 2],
            ]
        )
    )
    pitch = 2 / max(np.sqrt(max(1 - c[0, 2] ** 2, 0)), guard) * np.array([q[2], -q[3], q[0], -q[1]])
    yaw = (
        2
        / max(c[0, 0] ** 2 + c[0, 1] ** 2, guard)
        * np.array(
            [
                q[3] * c[0, 0],
                q[2] * c[0, 0],
                q[1] * c[0, 0] + 2 * q[2] * c[0, 1],
                q[0] * c[0, 0] + 2 * q[3] * c[0, 1],
            ]
        )
    )
    return np.stack([roll, pitch, yaw])


def transition(q, u, step_s):
    """Phi of A9.3."""
    a = np.zeros((7, 7))
    a[:4, :4], a[:4, 4:] = 0.5 * omega(u), -0.5 * xi(q)
    return np.eye(7) + step_s * a + 0.5 * step_s**2 * a @ a


def quaternion_filter(
    rate,
    gravity,
    field,
    step_s,
    *,
    published=False,
    bias_sigma=0.05 * DEG,
    midpoint=True,
    samples=10,
    attitude_sigma=DEG,
):
    """A9 over one record; returns q (K, 4), bias (K, 3), covariance (K, 7, 7)."""
    q, b = start(gravity, field, samples), np.zeros(3)
    p = np.diag(np.concatenate((np.full(4, attitude_sigma**2), np.full(3, bias_sigma**2))))
    r = np.ones(3) if published else SIGMA_E
    out_q, out_b, out_p = [], [], []
    for k in range(len(rate)):
        if k >= samples:
            u = (0.5 * (rate[k - 1] + rate[k]) if midpoint else rate[k]) - b
            noise = np.zeros((7, 7))
            if published:
                noise[4:, 4:] = np.diag(SIGMA_B)
            else:
                noise[:4, :4] = 0.25 * xi(q) @ (step_s * np.diag(SIGMA_B)) @ xi(q).T
                noise[4:, 4:] = (1e-3 * DEG) ** 2 * np.eye(3)
            phi = transition(q, u, step_s)
            p = phi @ p @ phi.T + step_s * noise
            q = product(q, exponential(u * step_s))
            z = measured_angles(gravity[k], field[k])
            for i in range(3):
                row = angle_rows(q)[i]
                h = np.concatenate((row - (row @ q) * q, np.zeros(3)))  # along the unit sphere only
                gain = p @ h / (h @ p @ h + r[i])
                step = gain * wrap(z[i] - euler(q)[i])
                q, b = q + step[:4], b + step[4:]
                q = q / np.linalg.norm(q)
                p = p - np.outer(gain, h @ p)
                p = 0.5 * (p + p.T)
        out_q.append(q), out_b.append(b), out_p.append(p)
    return np.array(out_q), np.array(out_b), np.array(out_p)


def error_state_filter(
    rate,
    gravity,
    field,
    step_s,
    *,
    bias_sigma=0.05 * DEG,
    midpoint=True,
    samples=10,
    attitude_sigma=2 * DEG,
    gate=True,
):
    """A9m over one record; returns q (K, 4), bias (K, 3), covariance (K, 6, 6) of the error in the sensor frame.

    A correction turns the frame of that error. The page leaves the covariance as it is; here it is kept to U, as in
    the kernel. Truth lies half-way: the error after a correction d is (I - d x / 2) times the one before.
    """
    sigma_g, sigma_b, sigma_a, sigma_h = 0.54 * DEG, 1e-3 * DEG, 0.034, 2.56 * DEG
    q, b = start(gravity, field, samples), np.zeros(3)
    p = np.diag(np.concatenate((np.full(3, attitude_sigma**2), np.full(3, bias_sigma**2))))
    out_q, out_b, out_p = [], [], []
    for k in range(len(rate)):
        if k >= samples:
            u = (0.5 * (rate[k - 1] + rate[k]) if midpoint else rate[k]) - b
            turn = exponential(u * step_s)
            f = np.eye(6)
            f[:3, :3], f[:3, 3:] = passive(turn), -step_s * np.eye(3)
            p = f @ p @ f.T + np.diag([(sigma_g * step_s) ** 2] * 3 + [sigma_b**2 * step_s] * 3)
            q = product(q, turn)
            for vector in ("gravity", "heading"):
                down = passive(q)[:, 2]
                if vector == "gravity":
                    norm = np.linalg.norm(gravity[k])
                    y = gravity[k] / norm - down
                    h = np.hstack((skew(down), np.zeros((3, 3))))
                    r = sigma_a**2 * (1 + 3 * ((norm - 1) / sigma_a) ** 2) * np.eye(3)
                else:
                    horizontal = passive(q).T @ field[k]
                    y = np.array([-np.arctan2(horizontal[1], horizontal[0])])
                    h = np.concatenate((down, np.zeros(3)))[None]
                    off = gate and abs(np.linalg.norm(field[k]) - 1) > 0.15
                    r = np.array([[sigma_h**2 * (25 if off else 1)]])
                gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
                step = gain @ y
                q, b = product(q, exponential(step[:3])), b + step[3:]
                keep = np.eye(6) - gain @ h
                p = keep @ p @ keep.T + gain @ r @ gain.T
                corrected = np.eye(6)
                corrected[:3, :3] = passive(exponential(step[:3]))
                p = corrected @ p @ corrected.T
        out_q.append(q), out_b.append(b), out_p.append(p)
    return np.array(out_q), np.array(out_b), np.array(out_p)


def euler_rates(e):
    """W of A8.1: rates of roll, pitch, yaw = W u."""
    (sr, sp), (cr, cp) = np.sin(e[:2]), np.cos(e[:2])
    return np.array([[1, sr * sp / cp, cr * sp / cp], [0, cr, -sr], [0, sr / cp, cr / cp]])


def euler_jacobian(e, u):
    """A of A8.3, shape (6, 6)."""
    (sr, sp), (cr, cp) = np.sin(e[:2]), np.cos(e[:2])
    across, along, a = u[1] * sr + u[2] * cr, u[1] * cr - u[2] * sr, np.zeros((6, 6))
    a[0, 0], a[0, 1] = sp / cp * along, across / cp**2
    a[1, 0] = -across
    a[2, 0], a[2, 1] = along / cp, across * sp / cp**2
    a[:3, 3:] = -euler_rates(e)
    return a


def euler_filter(
    rate,
    gravity,
    field,
    step_s,
    *,
    published=False,
    bias_sigma=0.05 * DEG,
    samples=10,
    attitude_sigma=2 * DEG,
):
    """A8 over one record; returns angles (K, 3), bias (K, 3), covariance (K, 6, 6) and NIS (K,)."""
    e, b = measured_angles(gravity[:samples].mean(axis=0), field[:samples].mean(axis=0)), np.zeros(3)
    p = np.diag(np.concatenate((np.full(3, attitude_sigma**2), np.full(3, bias_sigma**2))))
    continuous = np.diag(np.concatenate((SIGMA_E, SIGMA_B)))
    if not published:
        continuous = np.diag(np.concatenate((step_s * SIGMA_B, np.full(3, (1e-3 * DEG) ** 2))))
    h, r = np.eye(3, 6), np.diag(SIGMA_E)
    out = []
    for k in range(len(rate)):
        nis = np.nan
        if k >= samples:
            u = (rate[k] if published else 0.5 * (rate[k - 1] + rate[k])) - b
            f = np.eye(6) + step_s * euler_jacobian(e, u)
            p = f @ p @ f.T + step_s * continuous
            e = e + step_s * euler_rates(e) @ u
            innovation = wrap(measured_angles(gravity[k], field[k]) - e)
            gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
            nis = innovation @ np.linalg.solve(h @ p @ h.T + r, innovation)
            e, b = e + gain[:3] @ innovation, b + gain[3:] @ innovation
            keep = np.eye(6) - gain @ h
            p = keep @ p @ keep.T + gain @ r @ gain.T
        out.append((e, b, p, nis))
    return tuple(np.array(values) for values in zip(*out, strict=True))
