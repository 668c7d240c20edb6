"""The passes of our own smoother over one sensor."""

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.orientation._contract import OrientationFlag
from estimators.orientation.smoother._kernel import (
    GROUPS,
    RETAINED,
    RETAINED_INNOVATION,
    RETAINED_INVERSE,
    TURN_NORTH,
    TURN_X,
    TURN_Y,
    VARIANCES,
    backward,
    forward,
)
from estimators.orientation.smoother._rest import Rests
from estimators.orientation.smoother._session import SensorSession
from estimators.orientation.smoother._sweep import sweep, turn_on
from estimators.orientation.telemotion import _records as at
from estimators.recording import Float

_DISTURBED = 8.0
_GRADED = ((at.OFFSET, 3, 0.1), (at.START, 3, 1.0))
"""States whose spread is learnt: first, count, and what is usual, which counts as one more of them.

Where more is known of the device, that is what is usual.
"""
_WORST_LEVEL = 10.0
_LARGEST_MISFIT = 100.0
_PLACE_VARIANCE = 0.01
_LEAST_VARIANCE = 1e-12
_LEAST_FIELD = 1e-9
_PARTS = 4
"""Of a session: a residual that differs between them does not average out."""


class SensorPasses:
    """The nominal motion of one sensor, which each pass improves.

    Parameters
    ----------
    settings : np.void
        Of the kernels.
    prior : ndarray, shape (STATES,)
        What is known beforehand: zero, or constants of the device.
    variance : ndarray, shape (STATES,)
        Of the prior; turn, velocity, position and field are set here.
    q_online : ndarray, shape (K, 4)
        Where the online filter had the sensor, over the span of the session.
    nominal : ndarray, shape (STATES,)
        Where the online filter ended: bias, gain, field, delay; field with east zero.
    iron, changes : ndarray, shape (B, 3) and (C,)
        Hard iron in each block as the online filter had it, and in which blocks it changed.
    odds : ndarray, shape (9,)
        Of the online filter's hypotheses in the end, hard iron leading, start place within.
    """

    def __init__(
        self,
        session: SensorSession,
        settings: np.void,
        prior: Float,
        variance: Float,
        q_online: Float,
        nominal: Float,
        iron: Float,
        changes: NDArray[np.intp],
        odds: Float,
    ) -> None:
        self._session, self._settings = session, settings
        self._block_ticks = int(settings["block_ticks"])
        ends = np.minimum((np.arange(len(session.facts)) + 1) * self._block_ticks, len(q_online)) - 1
        self._q_first, self._q_ends = q_online[0].copy(), np.ascontiguousarray(q_online[ends])
        self._prior, self._variance = prior, variance.copy()
        self._variance[at.TURN : at.TURN + 3] = settings["tilt_start"], settings["tilt_start"], 0.0
        self._variance[at.VELOCITY : at.VELOCITY + 3] = settings["speed_start"]
        self._variance[at.POSITION : at.POSITION + 3] = _PLACE_VARIANCE
        self._variance[at.FIELD : at.FIELD + 3] = settings["field_start"]
        self.nominal, self.iron, self._changes = nominal.copy(), iron.copy(), changes
        self.has_field = bool(session.samples["has_field"].any())
        self._usual = [
            min(usual**2, float(variance[first : first + count].mean())) for first, count, usual in _GRADED
        ]
        self._settle(odds)
        self.q: Float = np.empty((len(session.samples), 4))
        self._misfit = self._level = np.zeros(len(session.facts))
        self._share = np.ones(len(session.facts))
        self._wander = 0.0
        self.log_likelihood, self.largest_gain, self.field_blocks = -math.inf, 0.0, 0
        self._rests = Rests(session.facts, settings)
        self._bias_variance = np.full(len(session.facts), np.inf)
        self.bias = np.tile(nominal[at.BIAS : at.BIAS + 3], (len(session.facts), 1))

    def improve(self, last: bool) -> None:
        """Smooth once around the nominal motion and take the result as the next one.

        The last pass also leaves the variances.
        """
        blocks = len(self._session.facts)
        sums, q_open = self._sweep()
        facts = self._session.facts.copy()
        facts["step"] = rotation.log(rotation.multiply(self._q_ends, rotation.conjugate(q_open)))
        facts["field_variance"] = self._field_variance(sums, facts)
        facts["rate_variance"] = self._rests.variance(self.bias, self._bias_variance)
        for change in self._changes:
            facts["iron_variance"][change] = self._settings["iron_wide"]
            facts["iron_step"][change] = self.iron[change - 1] - self.iron[change]
        error = self._prior - self.nominal
        error[: at.BIAS] = 0.0
        error[at.IRON : at.IRON + 3] = self._prior[at.IRON : at.IRON + 3] - self.iron[0]
        start, start_variance = error.copy(), np.diag(self._variance)
        p = start_variance.flatten()
        means, covariances = np.empty((blocks, at.STATES)), np.empty((blocks, at.STATES**2))
        retained = np.empty((blocks, GROUPS, RETAINED))
        nominal = self.nominal
        forward(
            sums,
            facts,
            nominal,
            error,
            p,
            nominal[at.WEIGHT],
            self._settings,
            means,
            covariances,
            retained,
        )
        self._bias_variance = self._rests.known(covariances, p)
        self._found = p.reshape(at.STATES, at.STATES).diagonal().copy()
        seen = facts["field_variance"] > 0.0
        raised = 1.0 + np.maximum(self._misfit, self._level)[seen]
        self._weigh(retained[seen, GROUPS - 1], facts["field_variance"][seen] / raised)
        smooth, adjoint = np.empty_like(means), np.empty(at.STATES)
        variances = np.zeros((blocks, VARIANCES))
        backward(
            sums,
            facts,
            nominal,
            self._settings,
            means,
            covariances,
            retained,
            smooth,
            adjoint,
            variances,
            last,
        )
        first = start - start_variance @ adjoint
        self._move(smooth, first, facts, q_open)
        self._grade()
        if last:
            self._variances = variances
            self.final_variance = np.maximum(p.reshape(at.STATES, at.STATES).diagonal(), _LEAST_VARIANCE)

    def _grade(self) -> None:
        """Learn how large errors of this device are: the spread of its prior, by expectation maximization."""
        for (first, count, _), usual in zip(_GRADED, self._usual, strict=True):
            span = slice(first, first + count)
            squares = (self.nominal[span] - self._prior[span]) ** 2 + self._found[span]
            self._variance[span] = (usual + squares.sum()) / (1.0 + count)

    def _weigh(self, retained: Float, least_variance: Float) -> None:
        """Set how likely the field was, from what `forward` keeps: innovation and one, over variance.

        The variance of a block that does not fit was raised before, which costs by its logarithm. Nothing can
        be likelier than no innovation at all with the least variance.
        """
        over, one = retained[:, RETAINED_INNOVATION:RETAINED_INVERSE], retained[:, RETAINED_INVERSE:]
        self.field_blocks = len(retained)
        self.log_likelihood = 0.5 * float((np.log(one) - over * over / one).sum())
        self.largest_gain = -1.5 * float(np.log(least_variance).sum()) - self.log_likelihood

    def _sweep(self) -> tuple[NDArray[np.void], Float]:
        blocks = len(self._session.facts)
        sums, q_open = np.empty(blocks, at.SUMS), np.empty((blocks, 4))
        sweep(
            self._session.samples,
            self._block_ticks,
            self._q_ends,
            self._q_first,
            self.nominal,
            self.iron,
            self._settings,
            sums,
            q_open,
            self.q,
        )
        sums["gap_turn_variance"] += self._session.turn_variance
        sums["gap_speed_variance"] += self._session.speed_variance
        return sums, q_open

    def _field_variance(self, sums: NDArray[np.void], facts: NDArray[np.void]) -> Float:
        """Weigh each block by its residual from the nominal motion, alone and with its neighbours."""
        count = sums["field_count"]
        seen = (2.0 * count >= sums["count"]) & (count > 0)
        field = sums["sum_field"] / np.maximum(count, 1.0)[:, None]
        start = facts["share"][:, None] * self.nominal[at.START : at.START + 3]
        residual = field - self.nominal[at.FIELD : at.FIELD + 3] - start
        squares = (residual**2).sum(axis=1)
        scale = 3.0 * self._settings["field_scale"]
        self._misfit = np.where(seen, squares / scale, 0.0)
        time_s = sums["count"] * self._settings["step_s"]
        self._level = _level(
            np.minimum(self._misfit, _LARGEST_MISFIT), time_s, self._settings["field_level_s"]
        )
        moving, rest = self._settings["field_noise_moving"], self._settings["field_noise_rest"]
        noise = np.where(facts["is_at_rest"] > 0, rest, moving)
        self._share = self._quiet(field, squares, time_s, facts, seen)
        noise *= self._share
        noise += facts["share"] * (self._settings["field_noise_start"] - noise)
        variance = noise**2 / time_s * (1.0 + np.maximum(self._misfit, self._level))
        left = seen & (facts["share"] < 0.5)
        self._wander = _wander(residual[left], 1.0 / variance[left])
        return np.where(seen, variance, 0.0)

    def _quiet(
        self, field: Float, squares: Float, time_s: Float, facts: NDArray[np.void], seen: NDArray[np.bool_]
    ) -> Float:
        """Return which share of the noise is left where the field has fitted the model, but for a turn, of late."""
        settings = self._settings
        mean = (
            self.nominal[at.FIELD : at.FIELD + 2]
            + facts["share"][:, None] * self.nominal[at.START : at.START + 2]
        )
        across = field[:, 0] * mean[:, 1] - field[:, 1] * mean[:, 0]
        turned = across**2 / ((mean**2).sum(axis=1) + _LEAST_FIELD)
        tells = seen & (facts["is_at_rest"] == 0) & (facts["share"] < 0.5)
        misfit = np.minimum(0.5 * (squares - turned), _LARGEST_MISFIT)
        time_s = np.where(tells, time_s, 0.0)
        level = _level(misfit, time_s, settings["quiet_s"], settings["quiet_level"])
        return np.asarray(np.clip(level / settings["quiet_level"], settings["quiet_least"], 1.0))

    def _settle(self, odds: Float) -> None:
        """Give hard iron the prior of its likeliest hypothesis, the start place the mean of their information."""
        settings = self._settings
        iron, start = slice(at.IRON, at.IRON + 3), slice(at.START, at.START + 3)
        known_variance = max(self._variance[at.IRON] - settings["iron_wide"], 0.0)
        table = odds.reshape(3, 3)
        irons = (settings["iron_narrow"], settings["iron_middle"], settings["iron_wide"])
        starts = (settings["start_narrow"], settings["start_middle"], settings["start_wide"])
        self._variance[iron] = irons[int(table.sum(axis=1).argmax())] + known_variance
        self._variance[start] = 1.0 / float(table.sum(axis=0) @ (1.0 / np.array(starts)))

    def _move(self, smooth: Float, first: Float, facts: NDArray[np.void], q_open: Float) -> None:
        """Take the smoothed errors into the nominal motion and turn it to north."""
        closing = np.ascontiguousarray(smooth[:, at.TURN : at.TURN + 3])
        opening = np.vstack((first[at.TURN : at.TURN + 3], closing[:-1] - facts["step"][:-1]))
        turn_on(self.q, np.ascontiguousarray(opening), closing, self._block_ticks)
        middle = smooth[len(smooth) // 2]
        self.bias = self.nominal[at.BIAS : at.BIAS + 3] + smooth[:, at.BIAS : at.BIAS + 3]
        self.nominal[at.BIAS :] += middle[at.BIAS :]
        edges = [0, *self._changes.tolist(), len(smooth)]
        for begin, end in itertools.pairwise(edges):
            self.iron[begin:end] += smooth[(begin + end - 1) // 2, at.IRON : at.IRON + 3]
        self._q_first = rotation.multiply(rotation.exp(opening[0]), self._q_first)
        self._q_ends = rotation.multiply(rotation.exp(closing), q_open)
        if not self.has_field:
            return
        east, north = self.nominal[at.FIELD], self.nominal[at.FIELD + 1]
        to_north = rotation.about_z(math.atan2(east, north))
        self._q_first, self._q_ends, self.q = (
            rotation.multiply(to_north, q) for q in (self._q_first, self._q_ends, self.q)
        )
        for vector in (at.FIELD, at.START):
            self.nominal[vector : vector + 3] = rotation.rotate(to_north, self.nominal[vector : vector + 3])
        self._q_ends = np.ascontiguousarray(self._q_ends)

    def sigma(self) -> Float:
        """Return one sigma about the axes of the earth at every sample, shape (K, 3), after the last pass.

        The floor of the heading stands for how far the field of a room points from that of its surroundings, of
        which the readings show only how much it varies along the way: where the noise of the field falls with
        that, so does the floor. What is turned everywhere alike shows in no reading, and is in no sigma.
        """
        settings = self._settings
        tilt = (
            settings["tilt_scale"] * np.maximum(self._variances[:, [TURN_X, TURN_Y]], 0.0)
            + settings["tilt_floor"]
            + settings["uneven"]
            * (self.nominal[at.OFFSET : at.OFFSET + 3] ** 2).sum()
            / self.nominal[at.WEIGHT] ** 2
        )
        level = 1.0 + np.minimum(self._level, _WORST_LEVEL)
        own = np.maximum(self._variances[:, TURN_NORTH], 0.0) * (
            settings["heading_scale"] if self.has_field else 1.0
        )
        north = max(self.nominal[at.FIELD] ** 2 + self.nominal[at.FIELD + 1] ** 2, at.LEAST_LEVEL)
        own += settings["wander_share"] * self._wander / north
        heading = np.sqrt(own + settings["heading_floor"] * level * self._share**2)
        blocks = np.column_stack((np.sqrt(tilt), np.minimum(heading, math.pi)))
        ends = (np.arange(len(blocks)) + 1) * self._block_ticks - 1
        ticks = np.arange(len(self.q))
        return np.column_stack([np.interp(ticks, ends, column) for column in blocks.T])

    def per_sample(self, blocks: Float) -> Float:
        """Repeat values of blocks for their samples."""
        return np.repeat(blocks, self._block_ticks, axis=0)[: len(self.q)]

    def flags(self, online: NDArray[np.uint8], heading_sigma_rad: Float) -> NDArray[np.uint8]:
        """Return the online flags with what the whole session knows better."""
        better = OrientationFlag.CONVERGING | OrientationFlag.MAGNETIC_DISTURBANCE
        better |= OrientationFlag.HEADING_NOT_TRUSTED
        retained = online & np.uint8(~int(better) & 0xFF)
        disturbed = self.per_sample(self._misfit) > _DISTURBED
        lost = heading_sigma_rad > self._settings["heading_lost"]
        if not self.has_field:
            lost = np.ones_like(lost)
        retained[~self._session.seen] |= np.uint8(OrientationFlag.INVALID)
        lost |= (retained & int(OrientationFlag.INVALID)) != 0
        retained |= np.where(disturbed, np.uint8(OrientationFlag.MAGNETIC_DISTURBANCE), np.uint8(0))
        retained |= np.where(lost, np.uint8(OrientationFlag.HEADING_NOT_TRUSTED), np.uint8(0))
        return np.asarray(retained, dtype=np.uint8)


def _wander(residual: Float, weight: Float) -> float:
    """Return the mean square, a component, of the means of quarters of the session: what does not average out."""
    squares = total = 0.0
    for part, own in zip(np.array_split(residual, _PARTS), np.array_split(weight, _PARTS), strict=True):
        if len(part) > 0:
            squares += own.sum() * float((np.average(part, axis=0, weights=own) ** 2).mean())
            total += own.sum()
    return squares / total if total > 0.0 else 0.0


def _level(misfit: Float, time_s: Float, time_constant_s: float, begun: float = 0.0) -> Float:
    """Return the mean of the exponential means of the misfit before and after each block."""
    gain = -np.expm1(-time_s / time_constant_s)
    ways = []
    for order in (slice(None), slice(None, None, -1)):
        level, out = begun, np.empty(len(misfit))
        values, gains = misfit[order], gain[order]
        for i in range(len(misfit)):
            level += gains[i] * (values[i] - level)
            out[i] = level
        ways.append(out[order])
    return np.asarray(0.5 * (ways[0] + ways[1]))
