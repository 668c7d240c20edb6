"""Messages between a gateway and `/ws/ingest`, and the typed error of every socket."""

from typing import Annotated, Any, Literal

from pydantic import Field

from app.errors import TelemotionError
from app.schemas import Schema, SessionState, Spoken

PROTOCOL_VERSION = 1


class ErrorMessage(Spoken):
    """A typed error on any socket; the socket stays open unless `closing`."""

    type: Literal["error"] = "error"
    code: str
    message: str
    details: dict[str, Any] = Field(default_factory=dict)
    closing: bool = False

    @classmethod
    def of(cls, error: TelemotionError, *, closing: bool) -> "ErrorMessage":
        """Return an error as clients get it."""
        return cls(
            code=error.code,
            message=error.message,
            details=error.details,
            closing=closing,
        )


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
    force_scale: float | None = None
    """N per count, of the load cells of instrumented shoes; below Nm and °C per count."""
    moment_scale: float | None = None
    temperature_scale: float | None = None
    clip_gyroscope_radps: float | None = None
    clip_accelerometer_mps2: float | None = None
    clip_magnetometer_t: float | None = None
    """Full scale: a pulse of a magnetic source with a sample at it is not used, and flagged."""
    device: str = Field(default="", max_length=100)
    firmware: str = Field(default="", max_length=100)
    serials: list[Annotated[str, Field(min_length=1, max_length=100)]] = Field(default_factory=list)
    """Serial number of each sensor, in the order of the placements: what is known of a sensor is used again."""


class AcknowledgeMessage(Schema):
    """Server to gateway: after hello, when something has changed, and otherwise once a second."""

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
    """One sensor's values in a JSON packet: K rows of three, K coil states."""

    gyroscope: list[list[float]]
    accelerometer: list[list[float]]
    magnetometer: list[list[float]] | None = None
    force: list[list[float]] | None = None
    """N, of the ground on a load cell, in the sensor's axes; below Nm about its centre."""
    moment: list[list[float]] | None = None
    coil_state: list[float] | None = None
    """Of a magnetic source, as in binary packets: 0 for nothing, 2.13 for the second coil at 1.3 A."""
    temperature: list[float] | None = None
    """Degrees Celsius inside the sensor."""


class JsonPacket(Schema):
    """The binary packet's content as JSON, SI units, for people with curl; at low rate."""

    type: Literal["packet"] = "packet"
    sequence: int = Field(ge=0, lt=2**32)
    device_time_us: int = Field(ge=0)
    tick_interval_us: int = Field(gt=0)
    sensors: list[JsonSensor]


class ActuationPlanMessage(Schema):
    """Server to the gateway of a magnetic source, once after each hello: what to do when the link is lost."""

    type: Literal["actuation_plan"] = "actuation_plan"
    coils: list[int]
    """Fired in this order, numbered from 1."""
    current_a: float
    on_ticks: int
    off_ticks: int
    """Of silence after each pulse."""
    cycle_ticks: int
    """From the start of one round to the next."""
    after_s: float
    """When nothing came from the server for so long, fire rounds until something comes."""
    current_limit_a: float
    """Never above this, whatever is asked."""


class ActuateMessage(Schema):
    """Server to the gateway of a magnetic source: the next pulse. The coil states in the packets are the answer."""

    type: Literal["actuate"] = "actuate"
    number: int
    """Counts up; ignore one that is not above the last."""
    coil: int
    """From 1."""
    current_a: float
    on_ticks: int
    not_before_us: int
    """Device time; begin with the first tick at or after it, at once when it is past."""
    not_after_us: int
    """Device time; forget it when this is past before the pulse began."""


class GoodbyeMessage(Schema):
    """Gateway: no more packets; `last_sequence` lets the server know what is missing."""

    type: Literal["goodbye"] = "goodbye"
    last_sequence: int = Field(ge=-1, lt=1 << 62)
