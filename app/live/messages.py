"""Messages of the live and player sockets; those of the gateway socket stand in `app.network.messages`.

The browser's types are generated from here.

Text messages are JSON with a `type`. Binary messages to the browser are frame blocks::

    0   4 bytes  magic `TMF1`
    4   u32      tick count K
    8   u32      column count C
    12  u32      first tick, modulo 2^32
    16  f64      session time of the first tick, s
    24  f64      tick interval, s
    32  f64      server time of publication, s since the epoch (for the latency mark)
    40  f32[K*C] rows: per tick the columns of the `layout` message in order

Columns: every angle in rad, then every `<angle>.sigma` in rad, then every scalar, then points as
`<point>.x|y|z` in m, then `<segment>.flags` and `<angle>.flags` as small whole numbers. NaN where there is
nothing to show.
"""

from typing import Literal

from pydantic import Field

from app.network.messages import PROTOCOL_VERSION

# Sent on these sockets too; rooms that have nothing to do with the network read it from here.
from app.network.messages import ErrorMessage as ErrorMessage
from app.recordings.schemas import CalibrationOut, FrameLayoutOut, SessionEventOut
from app.schemas import Schema, SessionState, Spoken


class LayoutMessage(Schema):
    """First message after connecting, and again when the setup changes."""

    type: Literal["layout"] = "layout"
    protocol_version: int = PROTOCOL_VERSION
    session_id: str
    layout: FrameLayoutOut
    columns: list[str]
    rate_hz: float
    delay_s: float = 0.0
    """By so much the frames show what was, beside the way of the packets: a stance is understood only after it."""


class StateMessage(Spoken):
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
    is_starting: bool = False
    """Not calibrated, or the orientation still converges: `heading_trusted` cannot be true yet, whatever the sensor."""
    battery_percent: float | None = None


class HealthMessage(Schema):
    """Link health, once a second."""

    type: Literal["health"] = "health"
    sensors: list[SensorHealth]
    packets_received: int
    packets_stored: int
    """Durable: a crash does not lose them."""
    packets_missing: int
    is_being_stored: bool
    """False when packets come and none has become durable for some seconds."""
    latency_ms_median: float | None
    latency_ms_p99: float | None
    """Packet arrival to published frame."""
    clock_skew_ppm: float | None


class EventMessage(Schema):
    """Something new on the time line."""

    type: Literal["event"] = "event"
    event: SessionEventOut


class PulseMessage(Schema):
    """Nothing new, once a second in which nothing else was said: a reader that misses it is out of reach."""

    type: Literal["pulse"] = "pulse"


class PlayerCommand(Schema):
    """Browser to `/ws/views/{view}`: steer a replay; also once a second while playing, to stay together."""

    type: Literal["player"] = "player"
    time_s: float
    playing: bool
    speed: float = Field(default=1.0, ge=0.1, le=4.0)
    ghost: bool = True
    warp: bool = True
    """Ghost follows the patient's own timing; False plays it at the therapist's pace from each start."""


class CameraCommand(Schema):
    """Browser to `/ws/views/{view}`: turn the view by key or button; say whether the page is dark."""

    type: Literal["camera"] = "camera"
    preset: Literal["start", "front", "side", "top", "arm", "movement"] | None = None
    """`start`: half from the side, as when opened; `side`: that of the exercise's arm; `arm`: close to it; `movement`:
    from where the template's movement is large."""
    turn_deg: float = Field(default=0.0, ge=-180.0, le=180.0)
    """Walk around the patient, counter-clockwise seen from above."""
    tilt_deg: float = Field(default=0.0, ge=-90.0, le=90.0)
    """Rise."""
    zoom: float = Field(default=1.0, ge=0.2, le=5.0)
    """Above 1 comes nearer."""
    theme: Literal["light", "dark"] | None = None


class PlayerState(Schema):
    """Server to browser on `/ws/views/{view}`: on connecting and after each command."""

    type: Literal["player_state"] = "player_state"
    mode: Literal["live", "replay"]
    time_s: float | None
    """Session time that is shown; None in live views, which always show the newest."""
    start_s: float | None
    end_s: float | None
    playing: bool
    speed: float
    has_ghost: bool
    has_warp: bool
    """A comparison with this template exists, so the ghost can follow the patient's timing."""
