"""The declaration in a gateway's hello, checked once and stored with the session."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, Final, get_args

import numpy as np

from app.errors import PacketError
from app.network.messages import PROTOCOL_VERSION, HelloMessage
from estimators.channels import CHANNELS
from estimators.conventions import Placement
from estimators.recording import Float
from estimators.sentences import say

WALKING: Final = "gait"
_COUNTED: Final = tuple(spec for spec in CHANNELS if spec.scale_limit is not None)
_CLIPPED: Final = tuple(spec for spec in CHANNELS if spec.clip_limit is not None)


@dataclass(frozen=True)
class ClockEpoch:
    """Where the device clock stands on the session clock, from one packet on.

    A session has one, and another each time its device starts its clock afresh.

    Attributes
    ----------
    first_sequence : int
        Unwrapped sequence of the first packet on this clock.
    device_start_us, session_start_us : int
        The same moment on both clocks: the first tick of that packet.
    """

    first_sequence: int
    device_start_us: int
    session_start_us: int


@dataclass(frozen=True)
class FoundClips:
    """Levels at which one sensor was found to be cut off, in force from one packet on.

    Attributes
    ----------
    first_sequence : int
        Unwrapped sequence of the first packet looked at with them.
    sensor : int
        In the order of the placements.
    levels : tuple of 12 (float or None)
        `RecordingCheck.clip_levels` of the sensor, row by row; None for infinite: JSON has no other word.
    """

    first_sequence: int
    sensor: int
    levels: tuple[float | None, ...]

    def write(self, clip_levels: Float) -> None:
        """Put them in force in the levels of all sensors, shape (S, 2, 2, 3)."""
        found = [np.inf if level is None else level for level in self.levels]
        clip_levels[self.sensor] = np.reshape(found, clip_levels.shape[1:])


@dataclass(frozen=True)
class Declaration:
    """A checked hello without its ticket; `to_dict` is what the session stores.

    Attributes
    ----------
    placements : tuple of Placement
        Sensors in the order of the packets.
    rate_hz : float
        Tick rate of the device, also the common tick of the session.
    scales : dict of str to float
        SI value of a count in int16 packets, by name of the channel; a channel without is sent as float32.
    full_scales : dict of str to float
        By name of the channel, SI; one that is absent is unknown.
    serials : tuple of str
        Serial number of each sensor in the order of the placements; empty when the gateway tells none.
    is_stamped : bool
        The packets hold a file: ticks have its own stamps, not a device's count. No gateway says so.
    clock_epochs : tuple of ClockEpoch
        Found by the live session; empty until its first packet.
    found_clips : tuple of FoundClips
        Found by the check of the running session, oldest first. A restart goes on with them; the analysis afterwards
        finds its own in all of the session.
    """

    placements: tuple[Placement, ...]
    rate_hz: float
    scales: Mapping[str, float] = field(default_factory=dict)
    full_scales: Mapping[str, float] = field(default_factory=dict)
    device: str = ""
    firmware: str = ""
    serials: tuple[str, ...] = ()
    is_stamped: bool = False
    clock_epochs: tuple[ClockEpoch, ...] = field(default=())
    found_clips: tuple[FoundClips, ...] = field(default=())

    @property
    def serial_of(self) -> dict[Placement, str]:
        """Serial number of each sensor; empty when the gateway tells none."""
        return dict(zip(self.placements, self.serials, strict=False))

    @cached_property
    def countable_channels(self) -> int:
        """Channel mask of what may be sent as counts: the channels with a declared scale."""
        return sum(int(spec.bit) for spec in CHANNELS if spec.name in self.scales)

    @property
    def sensor_count(self) -> int:
        """Number of sensors in every packet."""
        return len(self.placements)

    @property
    def time_step_s(self) -> float:
        """Interval of the common tick."""
        return 1.0 / self.rate_hz

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON types; `from_dict` reverses it."""
        stored = asdict(self)
        scales, full_scales = stored.pop("scales"), stored.pop("full_scales")
        stored |= {f"{spec.name}_scale": scales.get(spec.name) for spec in _COUNTED}
        stored |= {f"clip_{spec.field}": full_scales.get(spec.name) for spec in _CLIPPED}
        stored["placements"], stored["serials"] = list(self.placements), list(self.serials)
        stored["clock_epochs"] = [asdict(epoch) for epoch in self.clock_epochs]
        stored["found_clips"] = [asdict(clips) | {"levels": list(clips.levels)} for clips in self.found_clips]
        return stored

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> "Declaration":
        """Rebuild from what the session stored."""
        values = {name: stored[name] for name in cls.__dataclass_fields__ if name in stored}
        values["scales"] = _known({spec.name: stored.get(f"{spec.name}_scale") for spec in _COUNTED})
        values["full_scales"] = _known({spec.name: stored.get(f"clip_{spec.field}") for spec in _CLIPPED})
        values["placements"] = tuple(values["placements"])
        values["serials"] = tuple(values.get("serials") or ())
        values["clock_epochs"] = tuple(ClockEpoch(**epoch) for epoch in values.get("clock_epochs") or ())
        values["found_clips"] = tuple(
            FoundClips(**clips | {"levels": tuple(clips["levels"])})
            for clips in values.get("found_clips") or ()
        )
        return cls(**values)

    @property
    def clip_levels(self) -> Float:
        """The newest found levels of every sensor, shape (S, 2, 2, 3); infinite where none was found."""
        levels = np.full((self.sensor_count, 2, 2, 3), np.inf)
        for clips in self.found_clips:
            clips.write(levels)
        return levels

    def with_clips(self, levels: Float, first_sequence: int) -> "Declaration":
        """Return it with these levels in force from a packet on; the same one where none is new."""
        found = tuple(
            FoundClips(
                first_sequence,
                sensor,
                tuple(float(level) if np.isfinite(level) else None for level in new.ravel()),
            )
            for sensor, (new, known) in enumerate(zip(levels, self.clip_levels, strict=True))
            if (new != known).any()
        )
        return replace(self, found_clips=(*self.found_clips, *found)) if found else self

    def same_network(self, other: "Declaration") -> bool:
        """Whether packets under the two declarations mean the same."""
        names = (
            "placements",
            "rate_hz",
            "scales",
            "full_scales",
        )
        return all(getattr(self, name) == getattr(other, name) for name in names)


def check_hello(hello: HelloMessage) -> Declaration:
    """Check what a gateway declares.

    One count and a full scale may be at most what `estimators.channels` says of the channel.

    Raises
    ------
    PacketError
        With the reason `protocol_version`, `placements`, `rate` or `scales`.
    """
    if hello.protocol_version != PROTOCOL_VERSION:
        raise PacketError(
            say("hello.protocol_version", ours=PROTOCOL_VERSION, theirs=hello.protocol_version),
            reason="protocol_version",
        )
    return Declaration(
        placements=check_placements(hello.placements),
        rate_hz=_check_rate(hello.rate_hz),
        serials=check_serials(hello.serials, len(hello.placements)),
        device=hello.device,
        firmware=hello.firmware,
        scales=_known(
            {spec.name: _declared(hello, f"{spec.name}_scale", spec.scale_limit) for spec in _COUNTED}
        ),
        full_scales=_known(
            {spec.name: _declared(hello, f"clip_{spec.field}", spec.clip_limit) for spec in _CLIPPED}
        ),
    )


def check_placements(names: list[str]) -> tuple[Placement, ...]:
    """Return the placements, or say which name is unknown or given twice."""
    if not names:
        raise PacketError(say("hello.no_sensor"), reason="placements")
    unknown = [name for name in names if name not in get_args(Placement)]
    if unknown:
        raise PacketError(
            say(
                "hello.placements_unknown",
                unknown=[name[:40] for name in unknown[:5]],
                known=list(get_args(Placement)),
            ),
            reason="placements",
        )
    if len(set(names)) != len(names):
        raise PacketError(say("hello.placement_twice"), reason="placements")
    return tuple(name for placement in names for name in get_args(Placement) if name == placement)


def check_serials(serials: list[str], count: int) -> tuple[str, ...]:
    """Return the serial numbers, one a sensor, or say what is wrong with them."""
    if serials and (len(serials) != count or len(set(serials)) != count):
        raise PacketError(
            say("hello.serials", sensors=count, serials=len(set(serials))),
            reason="placements",
        )
    return tuple(serials)


def _check_rate(rate_hz: float) -> float:
    if not (math.isfinite(rate_hz) and 10.0 <= rate_hz <= 1000.0):
        raise PacketError(say("hello.rate", rate_hz=rate_hz), reason="rate")
    return rate_hz


def _declared(hello: HelloMessage, name: str, limit: float | None) -> float | None:
    value: float | None = getattr(hello, name)
    if value is None:
        return None
    if not (math.isfinite(value) and value > 0.0 and (limit is None or value <= limit)):
        raise PacketError(say("hello.scale", field=name, value=value, limit=f"{limit:g}"), reason="scales")
    return value


def _known(values: Mapping[str, float | None]) -> dict[str, float]:
    return {name: value for name, value in values.items() if value is not None}
