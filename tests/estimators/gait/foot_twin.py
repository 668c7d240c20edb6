"""The foot filter and its smoother in plain numpy, as the method page writes them: dense matrices, inverses."""

import numpy as np
from scipy.spatial.transform import Rotation

G = np.array([0.0, 0.0, 9.80665])


def cross_matrix(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def moved(x, d):
    p, v, r, bg, ba, pivot = x
    return (
        p + d[0:3],
        v + d[3:6],
        Rotation.from_rotvec(d[6:9]) * r,
        bg + d[9:12],
        ba + d[12:15],
        pivot + d[15:18],
    )


def apart(one, two):
    turned = (one[2] * two[2].inv()).as_rotvec()
    return np.concatenate(
        [one[0] - two[0], one[1] - two[1], turned, one[3] - two[3], one[4] - two[4], one[5] - two[5]]
    )


def there(x, p, step_s, gyroscope, force, sigma, stance, still, height, force_variance, rate_variance, c):
    """Return priors, posteriors and transitions of every sample; `c` are FootParameters."""
    floor = None
    log = []
    for k in range(len(step_s)):
        transition = np.eye(18)
        if k:
            h = step_s[k]
            w = 0.5 * (gyroscope[k - 1] + gyroscope[k]) - x[3]
            f = 0.5 * (force[k - 1] + force[k]) - x[4]
            middle = (x[2] * Rotation.from_rotvec(0.5 * h * w)).as_matrix()
            a = middle @ f - G
            transition[0:3, 3:6] = h * np.eye(3)
            transition[3:6, 6:9] = -cross_matrix(middle @ f) * h
            transition[0:3, 6:9] = 0.5 * h * transition[3:6, 6:9]
            transition[3:6, 12:15] = -middle * h
            transition[0:3, 12:15] = 0.5 * h * transition[3:6, 12:15]
            transition[6:9, 9:12] = -middle * h
            q = np.zeros((18, 18))
            q[0:3, 0:3] = (force_variance[k] * h**3 / 3 + 1e-10 * h) * np.eye(3)
            q[3:6, 3:6] = force_variance[k] * h * np.eye(3)
            q[6:9, 6:9] = middle @ np.diag(rate_variance[k]) @ middle.T * h
            q[9:12, 9:12] = c.gyroscope_bias_density**2 * h * np.eye(3)
            q[12:15, 12:15] = c.accelerometer_bias_density**2 * h * np.eye(3)
            q[15:18, 15:18] = c.pivot_density**2 * h * np.eye(3)
            x = (x[0] + x[1] * h + 0.5 * a * h * h, x[1] + a * h, x[2] * Rotation.from_rotvec(h * w), *x[3:])
            p = transition @ p @ transition.T + q
        prior, prior_p = x, p
        rows, residual, variance = [], [], []
        w = gyroscope[k] - x[3]
        if stance[k]:
            u = x[2].apply(np.cross(w, x[5]))
            row = np.zeros((3, 18))
            row[:, 3:6] = np.eye(3)
            row[:, 6:9] = cross_matrix(u)
            row[:, 15:18] = -x[2].as_matrix() @ cross_matrix(w)
            rows.append(row), residual.append(u - x[1]), variance.append(np.full(3, sigma[k] ** 2))
        if still[k]:
            row = np.zeros((3, 18))
            row[:, 9:12] = np.eye(3)
            rows.append(row), residual.append(w), variance.append(np.full(3, c.standstill_sigma_radps**2))
        d = None if floor is None else floor - x[0][2]
        if height[k] and d is not None and abs(d) < c.height_gate_m:
            row = np.zeros((1, 18))
            row[0, 2] = 1.0
            rows.append(row), residual.append([d])
            variance.append([(c.height_sigma_m * (1 + (d / c.height_scale_m) ** 2)) ** 2])
        if rows:
            hh, y, r = np.vstack(rows), np.concatenate(residual), np.diag(np.concatenate(variance))
            gain = p @ hh.T @ np.linalg.inv(hh @ p @ hh.T + r)
            x = moved(x, gain @ y)
            keep = np.eye(18) - gain @ hh
            p = keep @ p @ keep.T + gain @ r @ gain.T
        if height[k]:
            if floor is None:
                floor = x[0][2]
            else:
                weight = (1 + (d / c.height_scale_m) ** 2) ** -2 if abs(d) < c.height_gate_m else 0.0
                floor = weight * floor + (1 - weight) * x[0][2]
        log.append((prior, prior_p, x, p, transition))
    return log


def back(log):
    """The smoother of Rauch, Tung and Striebel, eq. (16)."""
    smooth = [log[-1][2]]
    for (_, _, x, p, _), (prior, prior_p, _, _, transition) in zip(log[-2::-1], log[:0:-1], strict=True):
        correction = p @ transition.T @ np.linalg.solve(prior_p, apart(smooth[-1], prior))
        smooth.append(moved(x, correction))
    return smooth[::-1]
