"""The smoother's two passes against a plain Kalman filter and Rauch-Tung-Striebel smoother with dense matrices."""

import numpy as np
import pytest

from estimators.kernels import filled
from estimators.orientation.smoother._estimator import SmootherParameters
from estimators.orientation.smoother._kernel import FACTS, GROUPS, RETAINED, backward, forward
from estimators.orientation.telemotion import _records as at
from estimators.orientation.telemotion._parameters import settings_of

BLOCKS = 12
STEP_S = 0.01
GRAVITY = 9.81


class Case:
    """Random sums of blocks of 20 ticks, as a moving sensor gives them; two blocks at rest, a new iron in one."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        self.settings = filled(at.SETTINGS, settings_of(SmootherParameters(), STEP_S))[0]
        self.sums = np.zeros(BLOCKS, at.SUMS)
        self.facts = np.zeros(BLOCKS, FACTS)
        for sums in self.sums:
            turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            sums["sum_rotation"] = 20.0 * turn.ravel()
            sums["sum_gain"] = 20.0 * np.einsum("ab,c->abc", turn, rng.normal(size=3)).ravel()
            sums["sum_force"] = 0.2 * (np.array([0, 0, GRAVITY]) + rng.normal(size=3))
            sums["sum_field"] = 20.0 * (np.array([0.0, 18.0, -45.0]) + rng.normal(size=3))
            sums["sum_delay"] = 20.0 * 30.0 * rng.normal(size=3)
            sums["sum_rate2"] = rng.uniform(0.0, 40.0)
            sums["gap_turn_variance"] = rng.uniform(0.0, 1e-4, 3)
            sums["gap_speed_variance"] = rng.uniform(0.0, 1e-3, 3)
        facts = self.facts
        self.sums["count"] = self.sums["field_count"] = 20
        facts["is_at_rest"][:2] = 1.0
        facts["field_variance"] = rng.uniform(20.0, 200.0, BLOCKS)
        facts["field_variance"][5] = 0.0  # a block without field
        facts["share"] = np.exp(-0.3 * np.arange(BLOCKS))
        facts["rate"] = 0.01 * rng.normal(size=(BLOCKS, 3))
        facts["rate_variance"] = rng.uniform(1e-5, 1e-4, BLOCKS)
        facts["step"] = 0.01 * rng.normal(size=(BLOCKS, 3))
        facts["iron_variance"][7] = 900.0
        facts["iron_step"][7] = rng.normal(size=3)
        self.nominal = np.zeros(at.STATES)
        self.nominal[at.FIELD : at.FIELD + 3] = 0.0, 18.0, -45.0
        self.nominal[at.START : at.START + 3] = rng.normal(size=3)
        self.nominal[at.BIAS : at.BIAS + 3] = 0.01 * rng.normal(size=3)
        root = rng.normal(size=(at.STATES, at.STATES))
        scale = np.full(at.STATES, 0.05)
        scale[at.FIELD : at.FIELD + 3] = scale[at.IRON : at.IRON + 3] = scale[at.START : at.START + 3] = 3.0
        self.prior = scale[:, None] * (root @ root.T / at.STATES + np.eye(at.STATES)) * scale
        self.start = scale * rng.normal(size=at.STATES)

    def motion(self, block):
        """Return F, the constant part and Q from the end of the block before to the end of this one."""
        settings, facts, sums = self.settings, self.facts[block], self.sums[block]
        time_s = sums["count"] * STEP_S
        force = sums["sum_force"]
        f, constant, q = np.eye(at.STATES), np.zeros(at.STATES), np.zeros((at.STATES, at.STATES))
        turn, velocity, position, bias = (
            slice(i, i + 3) for i in (at.TURN, at.VELOCITY, at.POSITION, at.BIAS)
        )
        f[turn, bias] = -STEP_S * sums["sum_rotation"].reshape(3, 3)
        # The gain error is stored column by column: its entry (b, c) turns the sensor about axis b.
        gain = sums["sum_gain"].reshape(3, 9)
        f[turn, at.GAIN : at.GAIN + 9] = STEP_S * gain
        x, y, z = force
        f[velocity, turn] = -np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        f[velocity, at.OFFSET : at.OFFSET + 3] = f[turn, bias]
        f[at.VELOCITY + 2, at.WEIGHT] = -time_s
        f[position, velocity] = time_s * np.eye(3)
        push = force - [0.0, 0.0, GRAVITY * time_s]
        constant[velocity], constant[position] = push, 0.5 * time_s * push
        constant[at.IRON : at.IRON + 3] = facts["iron_step"]
        turning = settings["rate_noise"] + settings["rate_noise_per_rate"] * sums["sum_rate2"] / 20
        for a in range(3):
            q[at.TURN + a, at.TURN + a] = turning * time_s + sums["gap_turn_variance"][a]
            speed = sums["gap_speed_variance"][a]
            q[at.VELOCITY + a, at.VELOCITY + a] = settings["speed_noise"] * time_s + speed
            q[at.POSITION + a, at.POSITION + a] = settings["position_noise"] * time_s
            q[at.BIAS + a, at.BIAS + a] = settings["bias_drift"] * time_s
            q[at.IRON + a, at.IRON + a] = facts["iron_variance"]
        return f, constant, q

    def measured(self, block):
        """Return H, z and the variances of all scalar measurements of a block."""
        settings, facts, sums = self.settings, self.facts[block], self.sums[block]
        time_s = sums["count"] * STEP_S
        h, z, r = [], [], []
        unit = np.eye(at.STATES)
        for a in range(3):
            h.append(unit[at.POSITION + a]), z.append(0.0), r.append(settings["position_prior"] / time_s)
        if facts["is_at_rest"]:
            for a in range(3):
                h.append(unit[at.VELOCITY + a]), z.append(0.0), r.append(settings["rest_speed"] / time_s)
            for a in range(3):
                h.append(unit[at.BIAS + a]), r.append(facts["rate_variance"])
                z.append(facts["rate"][a] - self.nominal[at.BIAS + a])
        if facts["field_variance"] > 0.0:
            field, start = (self.nominal[i : i + 3] for i in (at.FIELD, at.START))
            rows = np.zeros((3, at.STATES))
            x, y, w = field
            # The estimate lies behind the truth by t, so the field seems to be b - t x b = b + b x t.
            rows[:, at.TURN : at.TURN + 3] = np.array([[0.0, -w, y], [w, 0.0, -x], [-y, x, 0.0]])
            rows[:, at.FIELD : at.FIELD + 3] = np.eye(3)
            rows[:, at.IRON : at.IRON + 3] = sums["sum_rotation"].reshape(3, 3) / 20.0
            rows[:, at.DELAY] = sums["sum_delay"] / 20.0
            rows[:, at.START : at.START + 3] = facts["share"] * np.eye(3)
            h.extend(rows)
            z.extend(sums["sum_field"] / 20.0 - field - facts["share"] * start)
            r.extend([facts["field_variance"]] * 3)
        return np.array(h), np.array(z), np.array(r)

    def kernels(self):
        means, covariances = np.empty((BLOCKS, at.STATES)), np.empty((BLOCKS, at.STATES**2))
        kept = np.empty((BLOCKS, GROUPS, RETAINED))
        error, p = self.start.copy(), self.prior.ravel().copy()
        forward(
            self.sums, self.facts, self.nominal, error, p, GRAVITY, self.settings, means, covariances, kept
        )
        smooth, adjoint, variances = np.empty_like(means), np.empty(at.STATES), np.zeros((BLOCKS, 4))
        backward(
            self.sums,
            self.facts,
            self.nominal,
            self.settings,
            means,
            covariances,
            kept,
            smooth,
            adjoint,
            variances,
            True,
        )
        return smooth, variances, self.start - self.prior @ adjoint

    def dense(self):
        x, p = self.start.copy(), self.prior.copy()
        filtered, predicted = [(x, p)], []
        for block in range(BLOCKS):
            f, constant, q = self.motion(block)
            if block:
                constant = constant + f @ self._step(block - 1)
            x, p = f @ x + constant, f @ p @ f.T + q
            predicted.append((x, p, f))
            h, z, r = self.measured(block)
            s = h @ p @ h.T + np.diag(r)
            k = np.linalg.solve(s, h @ p).T
            x, p = x + k @ (z - h @ x), p - k @ s @ k.T
            filtered.append((x, 0.5 * (p + p.T)))
        xs, ps = filtered[-1]
        smooth, covariances = [xs], [ps]
        for block in range(BLOCKS - 1, -1, -1):
            xf, pf = filtered[block]
            xp, pp, f = predicted[block]
            c = np.linalg.solve(pp, f @ pf).T
            xs, ps = xf + c @ (xs - xp), pf + c @ (ps - pp) @ c.T
            smooth.append(xs), covariances.append(ps)
        return np.array(smooth[::-1]), np.array(covariances[::-1])

    def _step(self, block):
        step = np.zeros(at.STATES)
        step[at.TURN : at.TURN + 3] = -self.facts["step"][block]
        return step


@pytest.mark.parametrize("seed", range(3))
def test_both_ways_are_the_dense_smoother(seed):
    case = Case(seed)
    smooth, variances, first = case.kernels()
    expected, covariances = case.dense()
    # Condition of the predicted covariance inverted by the dense smoother: up to 1e9 times 1e-16 rounding.
    np.testing.assert_allclose(smooth, expected[1:], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(first, expected[0], rtol=1e-6, atol=1e-7)
    east = case.nominal[at.FIELD + 1] / (18.0**2)  # north is where the field points: d heading / d east
    look = np.zeros(at.STATES)
    look[at.TURN + 2], look[at.FIELD] = 1.0, east
    for block, found in enumerate(variances):
        p = covariances[block + 1]
        np.testing.assert_allclose(found, [p[0, 0], p[1, 1], p[0, 1], look @ p @ look], rtol=1e-5, atol=1e-9)
