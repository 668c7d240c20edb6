"""How the module is turned before markers tell: strapdown alone, and level, heading and lever arm of a recording."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from estimators import orientation, rotation
from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ComparisonError
from estimators.optical._alignment_signals import HALF_WIDTH_S, linear, repetition, triangle
from estimators.optical._contract import OpticalStart
from estimators.recording import Float, ImuChunk

_LONGEST_S = 60.0
_LEAST_S = 2.0
_LEAST_EXPLAINED = 0.5


@kernel("void(float64[:, ::1], float64, float64[:, ::1])")
def integrate(gyroscope_radps: Float, time_step_s: float, q: Float) -> None:
    """Turn on from `q[0]` with the mean rate of neighbouring samples; a missing one counts as rest."""
    for k in range(1, len(q)):
        w = np.empty(3)
        for i in range(3):
            value = 0.5 * time_step_s * (gyroscope_radps[k - 1, i] + gyroscope_radps[k, i])
            w[i] = value if np.isfinite(value) else 0.0
        turn = exponential(w[0], w[1], w[2])
        c = multiply(q[k - 1, 0], q[k - 1, 1], q[k - 1, 2], q[k - 1, 3], turn[0], turn[1], turn[2], turn[3])
        c = normalized(c[0], c[1], c[2], c[3])
        q[k, 0], q[k, 1], q[k, 2], q[k, 3] = c


def strapdown(gyroscope_radps: Float, time_step_s: float) -> Float:
    """Return the attitude of a sensor relative to its first sample, shape (K, 4); it drifts."""
    q = np.empty((len(gyroscope_radps), 4))
    q[:1] = rotation.identity()
    integrate(np.ascontiguousarray(gyroscope_radps, dtype=np.float64), time_step_s, q)
    return q


@dataclass(frozen=True)
class Mounting:
    """How a module is turned in the laboratory, and where its marker is.

    Attributes
    ----------
    q_room_sensor : ndarray, shape (K, 4)
        Level by gravity, heading by the markers; good to a few degrees, to begin a filter with.
    rate_bias_radps : ndarray, shape (K, 3)
    heading_sigma_rad : float
    lever_arm_m, lever_arm_sigma_m : ndarray, shape (3,)
        From the accelerometer to the marker, sensor axes.
    explained : float
        Part of the variance of the marker's acceleration that the module explains.
    """

    q_room_sensor: Float
    rate_bias_radps: Float
    heading_sigma_rad: float
    lever_arm_m: Float
    lever_arm_sigma_m: Float
    explained: float


def level_attitude(
    gyroscope_radps: Float, accelerometer_mps2: Float, time_step_s: float
) -> tuple[Float, Float]:
    """Return attitude level by gravity, any heading, and gyroscope bias; shapes (K, 4) and (K, 3)."""
    chunk = ImuChunk(
        0,
        time_step_s,
        np.ascontiguousarray(gyroscope_radps[None]),
        np.ascontiguousarray(accelerometer_mps2[None]),
        None,
        np.zeros((1, len(gyroscope_radps)), np.uint8),
    )
    # Both ways: a filter alone is tilted for seconds when it begins amid movement.
    found = orientation.smooth("telemotion_smoother", chunk).orientation
    return found.q_earth_sensor[0], found.gyroscope_bias_radps[0]


def find_mounting(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    time_step_s: float,
    camera_time_s: Float,
    marker_m: Float,
    lever_arm_m: Float | None = None,
    attitude: tuple[Float, Float] | None = None,
) -> Mounting:
    """Find heading and lever arm from movement.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (K, 3)
        Without holes; the first tick is at time zero.
    camera_time_s : ndarray, shape (N,)
        On the clock of the ticks.
    marker_m : ndarray, shape (N, 3)
        Laboratory, z up; NaN in gaps.
    lever_arm_m : ndarray, shape (3,), optional
        When it was measured; otherwise it is found.
    attitude : tuple of ndarray, optional
        What `level_attitude` gave for these samples, when it is known already.

    Raises
    ------
    ComparisonError
        Too little of the marker was seen, or it moved too little for a heading (page: R 4.5).

    Notes
    -----
    `D2 m = Rz(heading) (tri * (R f + g) + D2(R) r)` with the second difference D2 over +-h and tri its triangle:
    for a given heading linear in r. The heading is found on a circle of trials and refined by the same least squares.
    """
    count = len(gyroscope_radps)
    q, bias = attitude or level_attitude(gyroscope_radps, accelerometer_mps2, time_step_s)
    spacing = float(np.median(np.diff(camera_time_s)))
    reach = max(1, round(max(HALF_WIDTH_S, spacing) / time_step_s))
    if count <= 2 * reach + 1:
        raise ComparisonError("the inertial recording is too short for its markers")
    ticks = np.arange(count, dtype=np.float64) * time_step_s
    present = np.isfinite(marker_m).all(axis=1)
    if present.sum() < 10:
        raise ComparisonError("the marker was seen in fewer than ten frames beside the inertial module")
    held = linear(camera_time_s, np.where(present, 0.0, np.nan), ticks, 1.6 * spacing)
    path = CubicSpline(camera_time_s[present], marker_m[present])(ticks) + held[:, None]
    span = (reach * time_step_s) ** 2
    seen = (path[2 * reach :] - 2.0 * path[reach:-reach] + path[: -2 * reach]) / span
    level = rotation.rotate(q, accelerometer_mps2) - np.array([0.0, 0.0, GRAVITY_MPS2])
    felt = triangle(level, reach)[reach:-reach]
    matrix = rotation.to_matrix(q)
    arm = (matrix[2 * reach :] - 2.0 * matrix[reach:-reach] + matrix[: -2 * reach]) / span
    # The start of the filter's own settling is left out; a heading drifts, so that only a minute is used.
    good = np.flatnonzero(np.isfinite(seen).all(axis=1))[: round(_LONGEST_S / time_step_s)]
    if len(good) < _LEAST_S / time_step_s:
        raise ComparisonError(
            f"the marker was seen for less than {_LEAST_S:.0f} s beside the inertial module"
        )
    return _solved(q, bias, seen[good], felt[good], arm[good], lever_arm_m)


def _solved(q: Float, bias: Float, seen: Float, felt: Float, arm: Float, given: Float | None) -> Mounting:
    lever = np.zeros(3) if given is None else np.asarray(given, dtype=np.float64)

    def residuals(psi: float, r: Float) -> tuple[Float, Float]:
        c, s = np.cos(psi), np.sin(psi)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        inner = felt + arm @ r
        # Derivatives: by heading z x (turned), by lever arm the turned second difference of the attitude.
        turned = inner @ turn.T
        by_psi = np.column_stack([-turned[:, 1], turned[:, 0], np.zeros(len(turned))])
        jacobian = np.concatenate([by_psi[:, :, None], turn @ arm], axis=2)
        return seen - turned, jacobian

    costs = []
    for psi in np.linspace(-np.pi, np.pi, 24, endpoint=False):
        r = lever
        if given is None:
            rest, jacobian = residuals(psi, np.zeros(3))
            r = np.asarray(
                np.linalg.lstsq(jacobian[:, :, 1:].reshape(-1, 3), rest.ravel(), rcond=None)[0], np.float64
            )
            # A far marker is rather a wrong heading.
            r = np.asarray(r * min(1.0, 0.3 / max(float(np.linalg.norm(r)), 1e-9)), np.float64)
        costs.append((float(np.median(np.abs(residuals(psi, r)[0]))), psi, r))
    _, psi, lever = min(costs, key=lambda cost: cost[0])
    covariance = np.eye(4)
    for _ in range(10):
        rest, jacobian = residuals(psi, lever)
        size = np.linalg.norm(rest, axis=1)
        weight = 1.0 / np.maximum(1.0, size / (2.0 * np.median(size) + 1e-12))
        columns = jacobian if given is None else jacobian[:, :, :1]
        normal = np.einsum("kia,k,kib->ab", columns, weight, columns)
        noise = float(np.average(rest**2, weights=np.repeat(weight[:, None], 3, 1)))
        noise *= max(repetition(rest[:, axis]) for axis in range(3))
        # Ten centimetres of doubt: a module that does not turn tells no lever arm.
        prior = np.diag(noise / np.array([np.pi, 0.1, 0.1, 0.1])[: len(normal)] ** 2)
        inverse = np.linalg.inv(normal + prior)
        step = inverse @ np.einsum("kia,k,ki->a", columns, weight, rest)
        covariance = noise * inverse
        psi += float(step[0])
        if given is None:
            lever = lever + step[1:]
        if abs(float(step[0])) < 1e-6:
            break
    sigma = np.sqrt(np.diag(covariance))
    if not sigma[0] < np.radians(15.0):
        raise ComparisonError(
            "the marker moved too little to tell the heading of the module; move it briskly to and fro for some seconds"
        )
    rest, _ = residuals(psi, lever)
    explained = 1.0 - float(np.median(rest**2) / max(float(np.median((seen - seen.mean(0)) ** 2)), 1e-12))
    if explained < _LEAST_EXPLAINED:
        raise ComparisonError(
            f"the markers do not fit this sensor: it explains {100 * max(explained, 0.0):.0f} % of their acceleration."
            " Choose the sensor that wore the marker"
        )
    return Mounting(
        rotation.multiply(rotation.about_z(psi), q),
        bias,
        float(sigma[0]),
        lever,
        sigma[1:] if given is None else np.zeros(3),
        explained,
    )


def start_at(
    tick: int,
    time_step_s: float,
    mounting: Mounting,
    gyroscope_radps: Float,
    camera_time_s: Float,
    marker_m: Float,
    marker_sigma_m: float,
) -> OpticalStart | None:
    """Return the state at a tick from the markers around it; None where fewer than six frames are near.

    The marker's place and velocity are a parabola through its frames; the module is a lever arm away.
    """
    time = tick * time_step_s
    window = max(0.15, 3.6 * float(np.median(np.diff(camera_time_s))))
    near = np.flatnonzero(np.abs(camera_time_s - time) <= window)
    near = near[np.isfinite(marker_m[near]).all(axis=1)]
    if len(near) < 6:
        return None
    t = camera_time_s[near] - time
    design = np.column_stack([np.ones_like(t), t, t * t])
    fit, *_ = np.linalg.lstsq(design, marker_m[near], rcond=None)
    spread = np.sqrt(np.diag(np.linalg.inv(design.T @ design))) * marker_sigma_m
    q, bias = mounting.q_room_sensor[tick], mounting.rate_bias_radps[tick]
    turning = np.cross(gyroscope_radps[tick] - bias, mounting.lever_arm_m)
    unsure = float(np.linalg.norm(mounting.lever_arm_sigma_m))
    rate = float(np.linalg.norm(gyroscope_radps[tick]))
    return OpticalStart(
        fit[0] - rotation.rotate(q, mounting.lever_arm_m),
        fit[1] - rotation.rotate(q, turning),
        q,
        bias,
        # Beside the fit's own: what a parabola misses of a jerk of 100 m/s^3, and the lever arm.
        float(np.hypot(np.hypot(3.0 * spread[0], 6.0 * window**3), unsure)),
        float(np.hypot(np.hypot(3.0 * spread[1], 17.0 * window**2), rate * unsure)),
        0.05,
        float(max(np.hypot(3.0 * mounting.heading_sigma_rad, 0.05), 0.05)),
    )


__all__ = ["Mounting", "find_mounting", "integrate", "level_attitude", "start_at", "strapdown"]
