"""The channels of a sensor, a line each: packets, hello, declaration, unpacking and alignment read it here.

Another channel is a bit and a line of `CHANNELS`, its field in `estimators.recording` and its words in
`app.network.messages`.
"""

import math
from dataclasses import dataclass
from enum import IntFlag
from typing import Final, Literal

from estimators.conventions import GRAVITY_MPS2

GapRule = Literal["curve", "chord", "nearest", "never"]


class Channel(IntFlag):
    """Bits of a packet's channel mask, in payload order."""

    GYROSCOPE = 1
    ACCELEROMETER = 2
    MAGNETOMETER = 4
    FORCE = 8
    MOMENT = 16
    ORIENTATION = 32
    COIL_STATE = 64
    TEMPERATURE = 128


@dataclass(frozen=True)
class ChannelSpec:
    """How one channel is sent and placed on common ticks.

    Attributes
    ----------
    name : str
        In JSON packets; with `_scale` in the hello.
    field : str
        Of `ImuChunk` and `SensorSignals`; empty where no estimator reads the channel.
    width : int
        Values a tick and sensor; one value is a row of K, more are (K, width).
    unit : str
        SI, as people write it.
    gap : GapRule
        What stands between samples that are far apart: a curve with the slopes outside, the chord, the value of the
        nearest sample, or never anything but NaN. A curve is drawn for the inertial channels alone; a state is the
        nearest only off the common ticks, in ticks that nobody sent it is NaN.
    scale_limit : float, optional
        Largest value of one count; above it 16 bits would span more than any sensor measures, so the unit is wrong.
        None for a channel that is sent as float32 only.
    full_scale : float, optional
        What 16 bits of a common sensor reach, as the simulated device sends it.
    clip_limit : float, optional
        Largest full scale that a hello may declare; None where it declares none.
    resting : float
        What a sensor sent before its first sample of this channel, NaN when nobody can say.
    cell : str
        Channels of one cell come together and are judged together: where all their values repeat, it does not measure.
    """

    bit: Channel
    name: str
    field: str
    width: int
    unit: str
    gap: GapRule
    scale_limit: float | None = None
    full_scale: float | None = None
    clip_limit: float | None = None
    resting: float = float("nan")
    cell: str = ""


CHANNELS: Final = (
    ChannelSpec(
        Channel.GYROSCOPE,
        "gyroscope",
        "gyroscope_radps",
        3,
        "rad/s",
        "curve",
        scale_limit=0.1,
        full_scale=math.radians(2000.0),
        clip_limit=1e3,
    ),
    ChannelSpec(
        Channel.ACCELEROMETER,
        "accelerometer",
        "accelerometer_mps2",
        3,
        "m/s²",
        "curve",
        scale_limit=1.0,
        full_scale=16.0 * GRAVITY_MPS2,
        clip_limit=1e4,
    ),
    ChannelSpec(
        Channel.MAGNETOMETER,
        "magnetometer",
        "magnetometer_t",
        3,
        "T",
        "chord",
        scale_limit=1e-4,
        full_scale=4.9e-3,
        clip_limit=1.0,
    ),
    # A foot may have landed in a gap: forces are never bridged.
    ChannelSpec(
        Channel.FORCE, "force", "force_n", 3, "N", "never", scale_limit=10.0, full_scale=3000.0, cell="load"
    ),
    ChannelSpec(
        Channel.MOMENT,
        "moment",
        "moment_nm",
        3,
        "N m",
        "never",
        scale_limit=1.0,
        full_scale=150.0,
        cell="load",
    ),
    ChannelSpec(Channel.ORIENTATION, "orientation", "", 4, "1", "never"),
    # A coil is on or off: its state is that of the nearest sample, never a mean.
    ChannelSpec(Channel.COIL_STATE, "coil_state", "coil_state", 1, "1", "nearest", resting=0.0),
    ChannelSpec(
        Channel.TEMPERATURE,
        "temperature",
        "temperature_degc",
        1,
        "°C",
        "chord",
        scale_limit=0.1,
        full_scale=160.0,
    ),
)
"""In the order of their bits, which is that of the payload."""

INERTIAL: Final = int(Channel.GYROSCOPE | Channel.ACCELEROMETER)
"""What every packet must have to be estimated from."""
INERTIAL_WIDTH: Final = sum(spec.width for spec in CHANNELS if spec.bit & INERTIAL)
"""Columns of it, the first of each sensor."""
MOTION: Final = CHANNELS[:3]
"""Unpacked together, by compiled code, and bridged over short gaps."""
CARRIED: Final = tuple(spec for spec in CHANNELS[3:] if spec.field)
"""Carried with them where they are sent."""
