"""The backward step that the magnetic and the optical smoothers share, beside least squares over all ticks."""

import numpy as np

from estimators.kernels.backward import step_back

STATES, TICKS = 4, 7


def linear_model(seed):
    """Return transitions, noise of the steps, and a measurement of half of the states at each tick."""
    rng = np.random.default_rng(seed)
    transition = np.eye(STATES) + np.triu(rng.normal(0.0, 0.4, (TICKS - 1, STATES, STATES)), 1)
    spread = rng.normal(0.0, 0.3, (TICKS - 1, STATES, STATES))
    noise = spread @ spread.swapaxes(1, 2) + 0.05 * np.eye(STATES)
    row = rng.normal(0.0, 1.0, (TICKS, STATES // 2, STATES))
    return transition, noise, row, rng.normal(0.0, 1.0, (TICKS, STATES // 2))


def filtered(transition, noise, row, measured):
    """Return states and covariances of the Kalman filter with measurements of unit variance, begun at 0 with I."""
    x, p = np.zeros(STATES), np.eye(STATES)
    states, covariances = [], []
    for k in range(TICKS):
        if k:
            x, p = transition[k - 1] @ x, transition[k - 1] @ p @ transition[k - 1].T + noise[k - 1]
        gain = p @ row[k].T @ np.linalg.inv(row[k] @ p @ row[k].T + np.eye(STATES // 2))
        x, p = x + gain @ (measured[k] - row[k] @ x), p - gain @ row[k] @ p
        p = 0.5 * (p + p.T)
        states.append(x)
        covariances.append(p)
    return np.array(states), np.array(covariances)


def over_all_ticks(transition, noise, row, measured):
    """Return mean and covariance of all states at once, from the normal equations."""
    information, score = np.zeros((TICKS * STATES, TICKS * STATES)), np.zeros(TICKS * STATES)
    information[:STATES, :STATES] = np.eye(STATES)
    for k in range(TICKS):
        here = slice(STATES * k, STATES * (k + 1))
        information[here, here] += row[k].T @ row[k]
        score[here] += row[k].T @ measured[k]
        if k:
            both = slice(STATES * (k - 1), STATES * (k + 1))
            residual = np.concatenate([-transition[k - 1], np.eye(STATES)], axis=1)
            information[both, both] += residual.T @ np.linalg.inv(noise[k - 1]) @ residual
    covariance = np.linalg.inv(information)
    return (covariance @ score).reshape(TICKS, STATES), covariance


def test_going_back_gives_what_all_measurements_say_of_every_tick():
    for seed in range(5):
        transition, noise, row, measured = linear_model(seed)
        states, covariances = filtered(transition, noise, row, measured)
        moved, work = np.empty(STATES), np.empty((3, STATES, STATES))
        for k in range(TICKS - 2, -1, -1):
            phi = transition[k]
            prior = phi @ covariances[k] @ phi.T + noise[k]
            error = states[k + 1] - phi @ states[k]
            assert step_back(covariances[k], phi, prior, covariances[k + 1], error, moved, work)
            states[k] += moved
        mean, covariance = over_all_ticks(transition, noise, row, measured)
        # Condition numbers are below 1e4: rounding stays below 1e-11.
        np.testing.assert_allclose(states, mean, atol=1e-10)
        for k in range(TICKS):
            here = slice(STATES * k, STATES * (k + 1))
            np.testing.assert_allclose(covariances[k], covariance[here, here], atol=1e-10)
            np.testing.assert_array_equal(covariances[k], covariances[k].T)


def test_a_prediction_that_is_not_positive_leaves_the_tick_alone():
    p, moved, work = 2.0 * np.eye(STATES), np.full(STATES, 7.0), np.empty((3, STATES, STATES))
    prior = np.diag([1.0, 1.0, -1.0, 1.0])
    assert not step_back(p, np.eye(STATES), prior, np.eye(STATES), np.ones(STATES), moved, work)
    np.testing.assert_array_equal(p, 2.0 * np.eye(STATES))
    np.testing.assert_array_equal(moved, 7.0)
