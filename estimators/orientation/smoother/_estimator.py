"""Our own off-line smoother: the online filter first, then the same model over the whole session, both ways."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators._clipping import mark_clipped
from estimators.errors import SetupError, ShapeError
from estimators.kernels import filled
from estimators.orientation._contract import OrientationFlag, OrientationResult
from estimators.orientation._device_constants import DeviceConstants
from estimators.orientation._parameters import changed, parameter, read_parameters
from estimators.orientation._streaming import ChunkGuard, usable_samples
from estimators.orientation.smoother._passes import SensorPasses
from estimators.orientation.smoother._session import SensorSession, prepare, turn_back
from estimators.orientation.telemotion import _records as at
from estimators.orientation.telemotion._constants import constants_of
from estimators.orientation.telemotion._estimator import TelemotionEstimator
from estimators.orientation.telemotion._parameters import TelemotionParameters, settings_of
from estimators.recording import Float, ImuChunk, SampleQuality

_TRIAL_PASSES = 2
_CONVINCING, _CONVINCING_A_BLOCK = 40.0, 0.4
"""Gain of the log likelihood, in all and for each block with field, that overrules the online filter. Errors of the
field last for seconds, so only a tenth of a gain is new; and the shape of a room's field looks like hard iron
worth a quarter a block where the sensor turns little."""
_UNSEEN = np.uint8(OrientationFlag.INVALID | OrientationFlag.HEADING_NOT_TRUSTED)


@dataclass(frozen=True)
class SmootherParameters(TelemotionParameters):
    """The filter's parameters where the smoother uses others, and the number of its passes.

    The tilt of the start is only where the online filter had it. Rests are worth more than in the filter: both
    ends of a session are often at the same place, and from there the gyroscope, whose gain a whole session shows
    well, reaches over all of it.
    """

    passes: float = parameter(4.0, "", "over the session")
    tilt_start_sigma_deg: float = changed(TelemotionParameters, "tilt_start_sigma_deg", 5.0)
    start_narrow_ut: float = changed(TelemotionParameters, "start_narrow_ut", 0.7)
    field_noise_moving_ut_sqrt_s: float = changed(TelemotionParameters, "field_noise_moving_ut_sqrt_s", 6.5)
    field_noise_rest_ut_sqrt_s: float = changed(TelemotionParameters, "field_noise_rest_ut_sqrt_s", 4.5)
    field_scale_ut: float = changed(TelemotionParameters, "field_scale_ut", 1.0)
    field_level_s: float = changed(TelemotionParameters, "field_level_s", 10.0)
    rate_noise_per_rate_sqrt_s: float = changed(TelemotionParameters, "rate_noise_per_rate_sqrt_s", 0.0015)
    wander_share: float = changed(TelemotionParameters, "wander_share", 1.0)
    tilt_sigma_per_offset: float = changed(TelemotionParameters, "tilt_sigma_per_offset", 0.07)


@dataclass(frozen=True)
class SmoothedOrientation:
    """Result of the smoother.

    Attributes
    ----------
    orientation : OrientationResult
        Of every tick of the session, INVALID where a sensor was silent for longer than can be filled.
    constants : tuple of DeviceConstants
        One a sensor, with its standard deviations, for the filter of the next session with the same devices.
    """

    orientation: OrientationResult
    constants: tuple[DeviceConstants, ...]


def smooth(
    chunk: ImuChunk,
    parameters: Mapping[str, Any] | None = None,
    constants: Sequence[DeviceConstants | None] | None = None,
) -> SmoothedOrientation:
    """Estimate the orientation of every sensor from the whole session.

    Parameters
    ----------
    chunk : ImuChunk
        The whole session. Gaps up to `coast_s` are filled; through longer ones only constants of the device
        and the magnetic field are carried.
    parameters : mapping, optional
        What differs from `SmootherParameters`.
    constants : sequence of DeviceConstants or None, optional
        From an earlier session, one a sensor.

    Raises
    ------
    ShapeError
        If the chunk holds no ticks, or arrays do not fit together.
    SetupError
        For an unknown parameter or one out of range.

    Notes
    -----
    A method of our own; the model is that of `TelemotionEstimator`, the way back the adjoint of modified
    Bryson-Frazier. Sensors are worked on one after the other, so beside chunk and result there is only
    memory for the blocks of one, about 10 kB a block of 0.2 s.
    """
    guard = ChunkGuard(chunk.sensor_count, chunk.time_step_s, is_whole=True)
    chunk = mark_clipped(guard.accept(chunk))
    if chunk.tick_count == 0:
        raise ShapeError("the session holds no ticks; there is nothing to smooth")
    if constants is not None and len(constants) != chunk.sensor_count:
        raise ShapeError(f"constants of {len(constants)} sensors for {chunk.sensor_count}")
    p = read_parameters(SmootherParameters, parameters)
    if p.passes < 1:
        raise SetupError(f"passes must be at least 1, not {p.passes:g}")
    shape = (chunk.sensor_count, chunk.tick_count)
    result = OrientationResult(
        np.empty((*shape, 4)), np.empty((*shape, 3)), np.empty((*shape, 3)), np.empty(shape, np.uint8)
    )
    learnt = []
    for s in range(chunk.sensor_count):
        known = None if constants is None else constants[s]
        found = _smooth_sensor(_sensor(chunk, s), parameters or {}, p, known)
        learnt.append(found.constants[0])
        for name in ("q_earth_sensor", "gyroscope_bias_radps", "sigma_rad", "flags"):
            getattr(result, name)[s] = getattr(found.orientation, name)[0]
    guard.flag_lost_field(result.flags)
    return SmoothedOrientation(result, tuple(learnt))


def _sensor(chunk: ImuChunk, s: int) -> ImuChunk:
    one = slice(s, s + 1)
    return replace(
        chunk,
        gyroscope_radps=chunk.gyroscope_radps[one],
        accelerometer_mps2=chunk.accelerometer_mps2[one],
        magnetometer_t=None if chunk.magnetometer_t is None else chunk.magnetometer_t[one],
        quality=chunk.quality[one],
    )


def _smooth_sensor(
    chunk: ImuChunk, given: Mapping[str, Any], p: SmootherParameters, known: DeviceConstants | None
) -> SmoothedOrientation:
    """Smooth a chunk of one sensor."""
    filter_names = set(asdict(TelemotionParameters()))
    # The filter's covariance before the first sample is the prior of the smoother too.
    own = {name: given[name] for name in given if name in filter_names}
    own["output_lead_s"] = 0.0
    estimator = TelemotionEstimator(1, chunk.time_step_s, own)
    estimator.set_device_constants([known])
    settings = filled(at.SETTINGS, settings_of(p, chunk.time_step_s))[0]
    prior, variance = estimator.nominal[0], estimator.covariance[0].diagonal().copy()
    live, opened, irons = _run_online(estimator, chunk)
    flags, usable = live.flags[0], usable_samples(chunk)[0]
    clipped = (
        live.flags & int(OrientationFlag.SATURATED)
    ) != 0  # the filter may have met a level that hardly piles up
    chunk = replace(chunk, quality=chunk.quality | clipped * np.uint8(SampleQuality.SATURATED))
    gain = estimator.nominal[0, at.GAIN : at.GAIN + 9].reshape(3, 3).T
    turn_back(live, chunk, usable, gain)
    session = prepare(chunk, usable, live.q_earth_sensor[0], settings)
    if session is None:
        return SmoothedOrientation(live, estimator.device_constants)
    span = slice(session.first, session.stop)
    iron, changes = _iron_of_blocks(session, opened, irons, prior, settings, chunk)
    online = live.q_earth_sensor[0, span]
    passes = _passed(session, settings, prior, variance, online, estimator, int(p.passes), iron, changes)
    sigma = np.full((chunk.tick_count, 3), math.pi)
    sigma[span] = passes.sigma()
    bias = np.empty((chunk.tick_count, 3))
    bias[span] = passes.per_sample(passes.bias)
    q = np.empty((chunk.tick_count, 4))
    q[span] = passes.q
    if p.output_lead_s:
        rate = session.samples["rate"] - bias[span]
        q[span] = rotation.multiply(passes.q, rotation.exp(p.output_lead_s * rate))
    flags[span] = passes.flags(flags[span], sigma[span, 2])
    for unseen, nearest in (
        (slice(0, session.first), session.first),
        (slice(session.stop, None), session.stop - 1),
    ):
        q[unseen], bias[unseen] = q[nearest], bias[nearest]
        flags[unseen] |= _UNSEEN
    return SmoothedOrientation(
        OrientationResult(q[None], bias[None], sigma[None], flags[None]),
        (_learnt(passes, estimator.device_constants[0], p),),
    )


def _passed(
    session: SensorSession,
    settings: np.void,
    prior: Float,
    variance: Float,
    q_online: Float,
    estimator: TelemotionEstimator,
    count: int,
    iron: Float,
    changes: NDArray[np.intp],
) -> SensorPasses:
    """Smooth from what the online filter believed of hard iron, and from other beliefs while these may be better.

    The online filter has to believe as it goes. Looking back, three others are tried: that the iron was one
    all along, small, middle or large. One of them is taken if it makes the measured field far likelier.
    """
    odds = estimator.hypothesis_odds[0].reshape(3, 3)

    def begun(iron: Float, changes: NDArray[np.intp], odds: Float, passes: int) -> SensorPasses:
        made = SensorPasses(
            session, settings, prior, variance, q_online, _ended(estimator), iron, changes, odds.ravel()
        )
        for _ in range(passes):
            made.improve(last=False)
        return made

    trial_passes = min(_TRIAL_PASSES, count - 1)
    chosen = begun(iron, changes, odds, trial_passes)
    needed = max(_CONVINCING, _CONVINCING_A_BLOCK * chosen.field_blocks)
    if trial_passes > 0 and chosen.largest_gain > needed:
        constant = np.tile(prior[at.IRON : at.IRON + 3], (len(iron), 1))
        believed = int(odds.sum(axis=1).argmax()) if len(changes) == 0 else None
        best = chosen.log_likelihood + needed
        for size in range(len(odds)):
            if size == believed:
                continue
            only = np.zeros((3, 3))
            only[size] = odds.sum(axis=0)
            other = begun(constant, changes[:0], only, trial_passes)
            if other.log_likelihood > best:
                chosen, best = other, other.log_likelihood
    for _ in range(count - 1 - trial_passes):
        chosen.improve(last=False)
    chosen.improve(last=True)
    return chosen


def _learnt(passes: SensorPasses, online: DeviceConstants, p: SmootherParameters) -> DeviceConstants:
    """Return the constants as smoothed; the clip levels are those that the online filter met."""
    sigma, clips = (
        np.sqrt(passes.final_variance),
        (online.gyroscope_clip_radps, online.accelerometer_clip_mps2),
    )
    return constants_of(passes.nominal, sigma, passes.iron[-1], sigma[at.IRON : at.IRON + 3], clips, p)


def _run_online(
    estimator: TelemotionEstimator, chunk: ImuChunk
) -> tuple[OrientationResult, NDArray[np.int64], Float]:
    """Run the online filter; note, a second at a time, how often the hard iron has changed, and what it is."""
    step = max(1, round(1.0 / chunk.time_step_s))
    parts, opened, irons = [], [], []
    for start in range(0, chunk.tick_count, step):
        parts.append(estimator.update(chunk.ticks(start, min(start + step, chunk.tick_count))))
        opened.append(estimator.hard_iron_changes[0])
        irons.append(estimator.nominal[0, at.IRON : at.IRON + 3])
    q, bias, sigma, flags = (
        np.concatenate([getattr(part, name) for part in parts], axis=1)
        for name in ("q_earth_sensor", "gyroscope_bias_radps", "sigma_rad", "flags")
    )
    return OrientationResult(q, bias, sigma, flags), np.array(opened), np.array(irons)


def _iron_of_blocks(
    session: SensorSession,
    opened: NDArray[np.int64],
    irons: Float,
    prior: Float,
    settings: np.void,
    chunk: ImuChunk,
) -> tuple[Float, NDArray[np.intp]]:
    """Return the hard iron that the online filter had for each block, (B, 3), and the blocks where it changed."""
    blocks = len(session.facts)
    step = max(1, round(1.0 / chunk.time_step_s))
    seconds = np.flatnonzero(np.diff(opened, prepend=0))
    changes = np.clip((seconds * step - session.first) // int(settings["block_ticks"]), 1, blocks - 1)
    changes, last = np.unique(changes, return_index=True)
    iron = np.tile(prior[at.IRON : at.IRON + 3], (blocks, 1))
    # Between two changes, what was found by the second.
    found_by = np.append(seconds[last][1:] - 1, len(irons) - 1)
    edges = np.append(changes, blocks)
    for number, second in enumerate(found_by[: len(changes)]):
        iron[edges[number] : edges[number + 1]] = irons[second]
    return iron, changes


def _ended(estimator: TelemotionEstimator) -> Float:
    """Return where the online filter ended, turned so that its field points north; start place zero."""
    nominal: Float = estimator.nominal[0].copy()
    nominal[: at.BIAS] = 0.0
    nominal[at.START : at.START + 3] = 0.0
    east, north = nominal[at.FIELD], nominal[at.FIELD + 1]
    nominal[at.FIELD], nominal[at.FIELD + 1] = 0.0, np.hypot(east, north)
    return nominal
