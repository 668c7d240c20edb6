"""One sensor over a whole session, made ready for our own smoother: gaps filled, rest found, blocks cut."""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._contract import OrientationFlag, OrientationResult
from estimators.orientation.smoother._kernel import FACTS
from estimators.orientation.telemotion import _records as at
from estimators.orientation.telemotion._samples import CLIP_SHARE
from estimators.recording import Float, ImuChunk, SampleQuality

_MICROTESLA = 1e6
_RATE, _FORCE = slice(0, 3), slice(3, 6)
_LOST_RATE = 1.0
"""Rate error, rad/s, over a gap that is too long to be filled."""
_LARGEST_TURN = 1.0
_UNSEEN_S, _MEAN_SHARE = 0.1, 0.15
_FALLS = 0.5 * GRAVITY_MPS2
"""Mean specific force below which a sensor falls: it does not stay near one place."""
_REST_MEAN_RATE = np.deg2rad(3.0)


@dataclass(frozen=True)
class SensorSession:
    """What the passes of the smoother share.

    Attributes
    ----------
    first, stop : int
        Ticks of the chunk from the first to after the last measured sample.
    samples : ndarray of SAMPLE, shape (K,)
        Without gaps; field in microtesla.
    seen : ndarray of bool, shape (K,)
        False inside gaps too long to fill.
    facts : ndarray of FACTS, shape (B,)
        Rest, share of the start place and mean raw rate are filled in.
    turn_variance, speed_variance : ndarray, shape (B, 3)
        What gaps add.
    """

    first: int
    stop: int
    samples: NDArray[np.void]
    seen: NDArray[np.bool_]
    facts: NDArray[np.void]
    turn_variance: Float
    speed_variance: Float


def prepare(
    chunk: ImuChunk, usable: NDArray[np.bool_], q_online: Float, settings: np.void
) -> SensorSession | None:
    """Make a chunk of one sensor ready; None if it has fewer samples than a block.

    Parameters
    ----------
    usable : ndarray of bool, shape (K,)
    q_online : ndarray, shape (K, 4)
        Where the online filter had it: it tells the turn through gaps too long to be filled. There it is
        replaced, in place, by that turn at a constant rate.
    """
    block_ticks = int(settings["block_ticks"])
    measured = usable & ((chunk.quality[0] & int(SampleQuality.BRIDGED)) == 0)
    places = np.flatnonzero(measured)
    if places.size < 2 or places[-1] + 1 - places[0] < block_ticks:
        return None
    first, stop = int(places[0]), int(places[-1]) + 1
    span = slice(first, stop)
    samples = np.zeros(stop - first, at.SAMPLE)
    samples["rate"] = chunk.gyroscope_radps[0, span]
    samples["force"] = chunk.accelerometer_mps2[0, span]
    if chunk.magnetometer_t is not None:
        field = _MICROTESLA * chunk.magnetometer_t[0, span]
        found = np.isfinite(field).all(axis=1) & (field != 0.0).any(axis=1)
        samples["field"] = np.where(found[:, None], field, 0.0)
        samples["has_field"] = found
    samples["saturated"] = (chunk.quality[0, span] & int(SampleQuality.SATURATED)) != 0
    blocks = -(-(stop - first) // block_ticks)
    turn_variance, speed_variance = np.zeros((blocks, 3)), np.zeros((blocks, 3))
    spread = _rate_spread(samples["rate"], places - first, settings)
    seen = np.ones(len(samples), dtype=bool)
    for before, after in zip(places[:-1] - first, places[1:] - first, strict=True):
        if after - before > 1:
            if after - before - 1 > settings["coast_ticks"]:
                turn, speed = _bridge(samples, int(before), int(after), q_online[span], settings)
                seen[before + 1 : after + 1] = False
                # All along the gap, lest the force made up there tell the filter how it lay.
                blocks_in = slice(before // block_ticks, after // block_ticks + 1)
                turn_variance[blocks_in] += turn
                speed_variance[blocks_in] += speed
                continue
            turn, speed = _fill(samples, int(before), int(after), measured[span], spread, settings)
            turn_variance[after // block_ticks] += turn
            speed_variance[after // block_ticks] += speed
    edges = np.arange(blocks) * block_ticks
    lengths = np.diff(np.append(edges, stop - first))
    cut_off = _growth(samples["saturated"] > 0, settings)
    largest = np.abs(samples["rate"]).max(axis=1)
    unseen = np.maximum(settings["clip_rate"], (CLIP_SHARE * largest) ** 2)
    turn_variance += np.add.reduceat(unseen * cut_off, edges)[:, None]
    speed_variance += settings["clip_force"] * np.add.reduceat(cut_off, edges)[:, None]
    falls = np.linalg.norm(np.add.reduceat(samples["force"], edges), axis=1) < _FALLS * lengths
    speed_variance[falls] += (GRAVITY_MPS2 * lengths[falls, None] * settings["step_s"]) ** 2
    facts = np.zeros(blocks, FACTS)
    rest = _rest(samples, settings) & seen
    facts["is_at_rest"] = np.add.reduceat(rest, edges) == lengths
    speed_variance[np.flatnonzero(np.diff(facts["is_at_rest"]) < 0.0) + 1] += settings["leaving_speed"]
    facts["rate"] = np.add.reduceat(samples["rate"], edges) / lengths[:, None]
    leaving = np.where(
        facts["is_at_rest"] > 0, 0.0, lengths * settings["step_s"] / settings["start_leaving_s"]
    )
    share = np.exp(-np.cumsum(leaving))
    facts["share"] = np.where(share > 1e-6, share, 0.0)
    return SensorSession(first, stop, samples, seen, facts, turn_variance, speed_variance)


def turn_back(live: OrientationResult, chunk: ImuChunk, usable: NDArray[np.bool_], gain: Float) -> None:
    """Turn back to each start, by the gyroscope, from where the online filter had converged; in place.

    Parameters
    ----------
    live : OrientationResult
        Of one sensor, from the online filter; `q_earth_sensor` is changed where it was CONVERGING.
    usable : ndarray of bool, shape (K,)
    gain : ndarray, shape (3, 3)
        Errors of scale and axes of the gyroscope, as the filter had them in the end.
    """
    q = live.q_earth_sensor[0]
    starting = ((live.flags[0] & int(OrientationFlag.CONVERGING)) != 0) & (
        (live.flags[0] & int(OrientationFlag.INVALID)) == 0
    )
    edges = np.flatnonzero(np.diff(np.concatenate(([False], starting, [False])).astype(np.int8)))
    for begin, settled in edges.reshape(-1, 2):
        if settled >= len(q) or live.flags[0, settled] & int(OrientationFlag.INVALID):
            continue  # it never converged
        # A sample is the turn of the interval before it; where there is none, the sensor is taken to stay.
        span = slice(begin + 1, settled + 1)
        raw = np.where(usable[span, None], chunk.gyroscope_radps[0, span], 0.0)
        rate = raw @ (np.eye(3) + gain).T - live.gyroscope_bias_radps[0, settled]
        back = rotation.exp(-chunk.time_step_s * rate)
        for k in range(settled - 1, begin - 1, -1):
            q[k] = rotation.multiply(q[k + 1], back[k - begin])


def _rate_spread(rate: Float, places: NDArray[np.intp], settings: np.void) -> Float:
    """Return the standard deviation of the measured rate, root of the sum over axes, around each sample."""
    window = max(3, round(0.5 / settings["step_s"]))
    known = rate[places]
    mean = scipy.ndimage.uniform_filter1d(known, window, axis=0, mode="nearest")
    square = scipy.ndimage.uniform_filter1d(known * known, window, axis=0, mode="nearest")
    spread = np.zeros(len(rate))
    spread[places] = np.sqrt(np.maximum(square - mean * mean, 0.0).sum(axis=1))
    return spread


def _bridge(
    samples: NDArray[np.void], before: int, after: int, q_online: Float, settings: np.void
) -> tuple[Float, Float]:
    """Cross a gap too long to fill, in place: by the turn between where the online filter was and restarted.

    That turn is a guess and gets the variance of one; but from it on errors are small again, which the
    linear model of the passes needs.
    """
    length = after - before
    step_s = settings["step_s"]
    t = (np.arange(1, length) / length)[:, None]
    turn = rotation.log(rotation.multiply(rotation.conjugate(q_online[before]), q_online[after]))
    # A sample is the turn of the interval before it, so the one after the gap is part of it.
    samples["rate"][before + 1 : after + 1] = turn / (length * step_s)
    between = rotation.multiply(q_online[before], rotation.exp(t * turn))
    q_online[before + 1 : after] = between
    up = np.array([0.0, 0.0, GRAVITY_MPS2])
    samples["force"][before + 1 : after] = rotation.rotate(rotation.conjugate(between), up)
    samples["has_field"][before + 1 : after] = 0
    lost = min((_LOST_RATE * length * step_s) ** 2, _LARGEST_TURN)
    return np.full(3, lost), np.full(3, settings["speed_start"])


def _fill(
    samples: NDArray[np.void],
    before: int,
    after: int,
    measured: NDArray[np.bool_],
    spread: Float,
    settings: np.void,
) -> tuple[Float, Float]:
    """Fill one gap in place as the online filter does, and return the variances that it adds."""
    length = after - before
    time_s = length * settings["step_s"]
    t = (np.arange(1, length) / length)[:, None]
    # The last two samples before the gap and the first two after it.
    outside = _motion(samples[[max(before - 1, 0), before, after, min(after + 1, len(samples) - 1)]])
    low, high = outside[1], outside[2]
    chord = (high - low) / length
    rise = low - outside[0] if before > 0 and measured[before - 1] else chord
    fall = outside[3] - high if after + 1 < len(samples) and measured[after + 1] else chord
    late = t * t * (3.0 - 2.0 * t)
    curve = length * (t * (1.0 - t) ** 2 * rise - t * t * (1.0 - t) * fall)
    motion = low + late * (high - low) + curve
    inside = slice(before + 1, after)
    samples["rate"][inside], samples["force"][inside] = motion[:, _RATE], motion[:, _FORCE]
    if samples["has_field"][before] and samples["has_field"][after]:
        field = samples["field"]
        field[before + 1 : after] = field[before] + t * (field[after] - field[before])
        samples["has_field"][before + 1 : after] = 1
    else:
        samples["has_field"][before + 1 : after] = 0
    share = settings["gap_share"]
    unseen = 0.25 * max(spread[before], spread[after]) ** 2 / 3.0 * min(time_s / _UNSEEN_S, 1.0) ** 2
    bulge = length / 8.0 * (rise - fall)[_RATE]
    rate = (
        share * ((high - low)[_RATE] ** 2 + (_MEAN_SHARE * (high + low)[_RATE]) ** 2)
        + unseen
        + 0.25 * bulge**2
    )
    return rate * time_s**2, share * ((high - low)[_FORCE] * time_s) ** 2


def _growth(is_clipped: NDArray[np.bool_], settings: np.void) -> Float:
    """Return by how much the squared time at the limit grows with each sample: as the online filter counts it."""
    count = np.arange(1, len(is_clipped) + 1)
    since = count - np.maximum.accumulate(np.where(is_clipped, 0, count))
    return np.where(is_clipped, (2.0 * since - 1.0) * settings["step_s"] ** 2, 0.0)


def _motion(samples: NDArray[np.void]) -> Float:
    """Return rate (`_RATE`) and specific force (`_FORCE`) side by side, shape (K, 6)."""
    return np.concatenate((samples["rate"], samples["force"]), axis=1)


def _rest(samples: NDArray[np.void], settings: np.void) -> NDArray[np.bool_]:
    """Say which samples lie in the middle of rest, from windows around them."""
    window = max(3, round(settings["rest_minimum_s"] / settings["step_s"]))
    motion = _motion(samples)
    mean = scipy.ndimage.uniform_filter1d(motion, window, axis=0, mode="nearest")
    square = scipy.ndimage.uniform_filter1d(motion**2, window, axis=0, mode="nearest")
    variance = np.maximum(square - mean * mean, 0.0)
    return np.asarray(
        (variance[:, _RATE].sum(axis=1) < settings["rest_rate"])
        & (variance[:, _FORCE].sum(axis=1) < settings["rest_force"])
        & ((mean[:, _RATE] ** 2).sum(axis=1) < _REST_MEAN_RATE**2)
        & (samples["saturated"] == 0)
    )
