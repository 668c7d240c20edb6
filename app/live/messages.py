"""Messages of the live, player and gateway sockets; the browser's types are generated from here.

Text messages are JSON with a `type`. Binary messages to the browser are frame blocks::

    0   4 bytes  magic `TMF1`
    4   u32      tick count K
    8   u32      column count C
    12  u32      first tick, modulo 2^32
    16  f64      session time of the first tick, s
    24  f64      tick interval, s
    32  f64      server time of publication, s since the epoch (for the latency mark)
    40  f32[K*C] rows: per tick the columns of the `layout` message in order

Columns: every angle in rad, then every `<angle>.sigma` in rad, then every scalar, then points as `<point>.x|y|z` in m,
then `<segment>.flags` and `<angle>.flags` as small whole numbers. NaN where there is nothing to show.
"""

from typing import Annotated, Any, Literal

from pydantic import Field

from app.recordings.schemas import CalibrationOut, FrameLayoutOut, SessionEventOut, SessionState
from app.schemas import Schema

PROTOCOL_VERSION = 1


class LayoutMessage(Schema):
    """First message after connecting, and again when the setup changes."""

    type: Literal["layout"] = "layout"
    protocol_version: int = PROTOCOL_VERSION
    session_id: str
    layout: FrameLayoutOut
    columns: list[str]
    rate_hz: float


class StateMessage(Schema):
    """The session's state machine, on change and on connecting."""

    type: Literal["state"] = "state"
    state: SessionState
    reason: str
    session_time_s: float
    recording_start_s: float | None
    calibration: CalibrationOut | None
    calibration_progress: float | None
    """0 to 1 while a pose is being held."""
    calibration_hint: str = ""


class SensorHealth(Schema):
    """One sensor's link and signal over the last two seconds."""

    placement: str
    status: Literal["ok", "noisy", "lost"]
    loss_percent: float
    jitter_ms: float
    saturated: bool
    magnetic_disturbance: bool
    heading_trusted: bool
    battery_percent: float | None = None


class HealthMessage(Schema):
    """Link health, twice a second."""

    type: Literal["health"] = "health"
    sensors: list[SensorHealth]
    packets_stored: int
    packets_missing: int
    latency_ms_median: float | None
    latency_ms_p99: float | None
    """Packet arrival to published frame."""
    clock_skew_ppm: float | None


class EventMessage(Schema):
    """Something new on the time line."""

    type: Literal["event"] = "event"
    event: SessionEventOut


class ErrorMessage(Schema):
    """A typed error on any socket; the socket stays open unless `closing`."""

    type: Literal["error"] = "error"
    code: str
    message: str
    details: dict[str, Any] = {}
    closing: bool = False


LiveMessage = Annotated[
    LayoutMessage | StateMessage | HealthMessage | EventMessage | ErrorMessage, Field(discriminator="type")
]


class PlayerCommand(Schema):
    """Browser to `/ws/views/{view}`: steer a replay; also sent once a second while playing to stay together."""

    type: Literal["player"] = "player"
    time_s: float
    playing: bool
    speed: float = Field(default=1.0, ge=0.1, le=4.0)
    ghost: bool = True
    warp: bool = True
    """Ghost follows the patient's own timing; False plays it at the therapist's pace from the repetition's start."""


class HelloMessage(Schema):
    """Gateway to `/ws/ingest`: first message. JSON; after it binary packets or `packet` messages."""

    type: Literal["hello"] = "hello"
    protocol_version: int
    ticket: str
    placements: list[str]
    rate_hz: float = Field(gt=0, le=2000)
    gyroscope_scale: float | None = None
    """rad/s per count, for encoding 1; likewise below in m/s^2 and T per count."""
    accelerometer_scale: float | None = None
    magnetometer_scale: float | None = None
    clip_gyroscope_radps: float | None = None
    clip_accelerometer_mps2: float | None = None
    device: str = Field(default="", max_length=100)
    firmware: str = Field(default="", max_length=100)


class AcknowledgeMessage(Schema):
    """Server to gateway: after hello and at least four times a second while packets come."""

    type: Literal["acknowledge"] = "acknowledge"
    session_id: str
    acknowledged: int
    """Everything up to and including this sequence is stored or given up; -1 when nothing is."""
    highest: int
    """Highest sequence stored; -1 when none."""
    missing: list[tuple[int, int]]
    """Half-open ranges below `highest` not stored; send them again if you have them."""
    state: SessionState


class JsonSensor(Schema):
    """One sensor's values in a JSON packet, K rows of three."""

    gyroscope: list[list[float]]
    accelerometer: list[list[float]]
    magnetometer: list[list[float]] | None = None


class JsonPacket(Schema):
    """The binary packet's content as JSON, SI units, for people with curl; at low rate."""

    type: Literal["packet"] = "packet"
    sequence: int = Field(ge=0, lt=2**32)
    device_time_us: int = Field(ge=0)
    tick_interval_us: int = Field(gt=0)
    sensors: list[JsonSensor]


class GoodbyeMessage(Schema):
    """Gateway: no more packets; `last_sequence` lets the server know what is missing."""

    type: Literal["goodbye"] = "goodbye"
    last_sequence: int
