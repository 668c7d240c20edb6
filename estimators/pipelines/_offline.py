"""Orientation of a whole session by an off-line smoother, before a pipeline runs over it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimators import calibration, orientation
from estimators.conventions import Placement
from estimators.orientation import DeviceConstants, OrientationResult, SmoothedChunk
from estimators.pipelines._contract import SessionSetup
from estimators.recording import Float, ImuChunk


def is_offline(setup: SessionSetup) -> bool:
    """Say whether the setup names a method that needs the whole session."""
    return setup.orientation in orientation.smoothers()


def smooth_network(
    pieces: Sequence[ImuChunk], setup: SessionSetup
) -> tuple[OrientationResult, tuple[DeviceConstants, ...]]:
    """Smooth every sensor of a session, one after the other.

    Parameters
    ----------
    pieces : sequence of ImuChunk
        Consecutive ticks of the whole session as measured, in the order of `setup.placements`; one at least.
    setup : SessionSetup
        Names the smoother and its parameters. What was calibrated in the hand is applied first, accelerometer
        biases that its calibration holds are taken off, and each sensor starts with its device's constants.

    Returns
    -------
    orientation : OrientationResult
        Of all ticks.
    constants : tuple of DeviceConstants
        One a sensor.

    Raises
    ------
    SetupError
        For an unknown smoother or parameter.
    ShapeError
        If the session holds no ticks.
    """
    ticks = sum(piece.tick_count for piece in pieces)
    shape = (len(setup.placements), ticks)
    found = OrientationResult(
        np.empty((*shape, 4)), np.empty((*shape, 3)), np.empty((*shape, 3)), np.empty(shape, dtype=np.uint8)
    )
    learnt = []
    for s, name in enumerate(setup.placements):
        known, bias = setup.device_constants.get(name), _force_bias(setup, name)
        one = orientation.smooth(
            setup.orientation,
            _sensor(pieces, s, setup, bias),
            setup.orientation_parameters,
            [known and known.less_offset(bias)],
        )
        for field in ("q_earth_sensor", "gyroscope_bias_radps", "sigma_rad", "flags"):
            getattr(found, field)[s] = getattr(one.orientation, field)[0]
        learnt.append(one.constants[0].less_offset(-bias))
    return found, tuple(learnt)


def smoothed_chunk(chunk: ImuChunk, setup: SessionSetup) -> ImuChunk:
    """Return a whole session with its orientation if the setup names a smoother; else the chunk as it is."""
    if not is_offline(setup) or isinstance(chunk, SmoothedChunk):
        return chunk
    return orientation.with_orientation(chunk, *smooth_network([chunk], setup))


def _force_bias(setup: SessionSetup, name: Placement) -> Float:
    """Return what the session's calibration takes off the specific force of a sensor, shape (3,)."""
    biases = {} if setup.calibration is None else setup.calibration.accelerometer_bias_mps2
    return np.array(biases.get(name, (0.0, 0.0, 0.0)))


def _sensor(pieces: Sequence[ImuChunk], s: int, setup: SessionSetup, force_bias_mps2: Float) -> ImuChunk:
    """Put the ticks of one sensor together, corrected by what is known of it."""
    name = setup.placements[s]
    chunk = ImuChunk.join([piece.sensors([s]) for piece in pieces])
    if name in setup.devices:
        chunk = calibration.correct(chunk, [setup.devices[name]])
    if force_bias_mps2.any():
        chunk = replace(chunk, accelerometer_mps2=chunk.accelerometer_mps2 - force_bias_mps2)
    return chunk
