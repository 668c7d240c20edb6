"""A simulated person with a magnetic source: measured as it is sent, because what the source does is asked for."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from app.errors import InvalidInput
from app.gateway.client import Delivery
from app.gateway.encoding import EPOCH_US
from app.gateway.source import FixedBursts, SourceControl
from app.network.messages import PROTOCOL_VERSION, HelloMessage
from app.network.packet import encode_packet
from estimators.channels import Channel
from estimators.conventions import Placement
from estimators.magnetic import coil_state
from estimators.pipelines import SessionSetup, relative_source
from estimators.simulation.coils import (
    RelativeScene,
    bench_motion,
    bench_places,
    relative_motion,
    relative_scene,
    wound_by_hand,
)

RELATIVE_MOVEMENTS: Final[dict[str, tuple[Placement, Placement]]] = {
    "flexion": ("pelvis", "sternum"),
    "rotation": ("pelvis", "sternum"),
    "walk_back": ("pelvis", "sternum"),
    "shoulder": ("pelvis", "upper_arm_left"),
    "hip": ("pelvis", "thigh_left"),
    "walk_leg": ("pelvis", "thigh_left"),
    "feet": ("foot_left", "foot_right"),
    "bench": ("pelvis", "sternum"),
}
"""Movements of `estimators.simulation.coils`, and where source and sensor are worn in them.

On the `bench` nobody wears them: the source lies still, and the sensor is laid at `bench_places`. Its coils are wound
by hand: they differ from what the session declares, as a calibration is to find.
"""
_SHOE: Final[dict[str, Any]] = {"coil_radius_m": 0.075, "current_a": 1.36}
_BENCH: Final[dict[str, Any]] = {"fixed_interval_s": 0.25, "mounting_direction": [0.0, 0.0, 0.0]}
"""Every coil in turn, whatever the uncertainty; the sensor may be on any side."""
_MASK: Final = Channel.GYROSCOPE | Channel.ACCELEROMETER | Channel.MAGNETOMETER | Channel.COIL_STATE
_FULL_SCALE_T: Final = 8e-4
_SLIPPED: Final = 1e4
"""So many times stronger is the field on a coil than where sensors are worn."""


@dataclass(frozen=True)
class RelativeFaults:
    """What goes wrong, session times in seconds.

    `dead_s`: the coils are said to be on and are not. `silent_s`: the source does nothing and says so.
    `exchanged_s`: the numbers of the first two coils are exchanged. `beside_coil_s`: the sensor has slipped onto the
    source. Each until its end. `lost_share` of the pulses from `lost_from_s` on are neither fired nor reported.
    `full_scale_t`: of the magnetometers, as the hello says.
    `modules_exchanged`: the network sends what the source measures as the sensor's, and the other way round.
    """

    dead_s: tuple[float, float] = (np.inf, np.inf)
    silent_s: tuple[float, float] = (np.inf, np.inf)
    exchanged_s: tuple[float, float] = (np.inf, np.inf)
    beside_coil_s: tuple[float, float] = (np.inf, np.inf)
    lost_share: float = 0.0
    lost_from_s: float = 0.0
    modules_exchanged: bool = False
    full_scale_t: float = _FULL_SCALE_T


@dataclass
class RelativePatient:
    """One session of a simulated person; commands to the source come in through `control`.

    Parameters
    ----------
    movement : str
        A key of `RELATIVE_MOVEMENTS`.
    duration_s : float
        A bench lasts as long as its places take.
    bursts : FixedBursts, optional
        The source fires these by itself, whatever it is asked.
    """

    movement: str = "flexion"
    duration_s: float = 60.0
    rate_hz: float = 120.0
    seed: int = 1
    faults: RelativeFaults = field(default_factory=RelativeFaults)
    ticks_per_packet: int = 5
    bursts: FixedBursts | None = None

    def __post_init__(self) -> None:
        if self.movement not in RELATIVE_MOVEMENTS:
            raise InvalidInput(
                f"--relative is {self.movement!r}; choose one of {', '.join(RELATIVE_MOVEMENTS)}"
            )
        self.control = SourceControl(1e6 / self.rate_hz, self.bursts)
        settings = relative_source(
            SessionSetup(
                "relative_pose", self.placements, self.rate_hz, orientation_parameters=self.parameters
            )
        )
        self.source = settings.coils
        if self.movement == "bench":
            self.source = wound_by_hand(settings.coils, self.seed)
            motion, self.duration_s = bench_motion(bench_places(), self.seed)
        else:
            motion = relative_motion(self.movement, self.duration_s, self.seed)
        self.scene: RelativeScene = relative_scene(
            self.source,
            motion,
            self.duration_s,
            self.rate_hz,
            seed=self.seed,
        )
        self._chance = np.random.default_rng([self.seed, 83])
        self._was_on = self._is_lost = False

    @property
    def placements(self) -> tuple[Placement, Placement]:
        """Source, then sensor."""
        return RELATIVE_MOVEMENTS[self.movement]

    @property
    def parameters(self) -> dict[str, Any]:
        """What the session must declare about the source."""
        known: dict[str, dict[str, Any]] = {"feet": _SHOE, "bench": _BENCH}
        return dict(known.get(self.movement, {}))

    def hello(self, ticket: str) -> HelloMessage:
        """Return the first message of a connection."""
        return HelloMessage(
            protocol_version=PROTOCOL_VERSION,
            ticket=ticket,
            placements=list(self.placements),
            rate_hz=self.rate_hz,
            clip_magnetometer_t=self.faults.full_scale_t,
            device="telemotion simulator with a magnetic source",
            firmware="1",
        )

    def deliveries(self) -> Iterator[Delivery]:
        """Yield packets; each is measured when it is asked for, with the coils as they are then."""
        count, size = len(self.scene.time_s), self.ticks_per_packet
        for number in range(count // size):
            first = number * size
            data = encode_packet(
                np.stack([self._tick(k) for k in range(first, first + size)]).astype("<f4"),
                sequence=number,
                device_time_us=EPOCH_US + round(1e6 * first / self.rate_hz),
                tick_interval_us=round(1e6 / self.rate_hz),
                channels=_MASK,
            )
            yield Delivery(number, data, (first + size) / self.rate_hz)

    def _tick(self, k: int) -> np.ndarray[Any, np.dtype[np.float64]]:
        scene, time_s = self.scene, float(self.scene.time_s[k])
        coil, current = self.control.tick(EPOCH_US + 1e6 * time_s)
        faults = self.faults
        if coil and not self._was_on:
            self._is_lost = time_s >= faults.lost_from_s and self._chance.random() < faults.lost_share
        self._was_on = coil > 0
        if self._is_lost or faults.silent_s[0] <= time_s < faults.silent_s[1]:
            coil, current = 0, 0.0
        field_t = scene.ambient_t[k].copy()
        if coil and not faults.dead_s[0] <= time_s < faults.dead_s[1]:
            fired = coil - 1
            if faults.exchanged_s[0] <= time_s < faults.exchanged_s[1]:
                fired = {0: 1, 1: 0}.get(fired, fired)
            near = _SLIPPED if faults.beside_coil_s[0] <= time_s < faults.beside_coil_s[1] else 1.0
            field_t += near * current * scene.per_ampere_t[k, fired]
        limit_t = faults.full_scale_t
        source = np.r_[
            scene.source_gyroscope_radps[k],
            scene.source_accelerometer_mps2[k],
            np.clip(scene.source_ambient_t[k], -limit_t, limit_t),
            coil_state(coil, current),
        ]
        sensor = np.r_[
            scene.gyroscope_radps[k], scene.accelerometer_mps2[k], np.clip(field_t, -limit_t, limit_t), 0.0
        ]
        return np.stack([sensor, source] if faults.modules_exchanged else [source, sensor])
