"""A source measured on a bench: a magnetic session in which the sensor was laid at measured places, one after another.

No database here: ticks in, coils out. `magnetic_sources` keeps them; `telemotion calibrate-source` writes them down.
"""

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from app.errors import InvalidInput
from app.kinds.magnetic.source_schemas import WORST_GAIN_SIGMA, CoilIn, SourceFindings, SourceStopOut
from estimators.conventions import Placement
from estimators.errors import EstimationError
from estimators.magnetic import (
    CoilCalibration,
    Source,
    Stop,
    TrackerFlag,
    TrackerLimits,
    calibrate_at_places,
    find_stops,
    locate,
    read_coil_state,
)
from estimators.pipelines import SessionSetup, relative_source
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

LONGEST_S: Final = 3600.0
_FULL_SCALE_T: Final = 8e-4
_ROUGHLY: Final = 0.05
"""Share by which coils as described may be wrong when a place is only to be recognised."""


class Bench:
    """What a session holds of a bench.

    Parameters
    ----------
    pieces : iterable of ImuChunk
        The whole session, sensors in the order of the setup.
    setup : SessionSetup
        Of the pipeline `relative_pose`; its coils are taken as the design.
    sensor : Placement, optional
        By default the first that is not the source.

    Raises
    ------
    InvalidInput
        No such sensor, no coil states, a session too long, or nothing in it.
    """

    def __init__(
        self, pieces: Iterable[ImuChunk], setup: SessionSetup, sensor: Placement | None = None
    ) -> None:
        settings = relative_source(setup)
        others = [name for name in setup.placements if name != settings.source]
        if sensor is not None and sensor not in others:
            raise InvalidInput(say("bench.no_sensor", place=sensor), field="sensor")
        chunks, ticks = [], 0
        for piece in pieces:
            chunks.append(piece)
            ticks += piece.tick_count
            if ticks > LONGEST_S * setup.rate_hz:
                raise InvalidInput(say("bench.too_long"))
        if not chunks:
            raise InvalidInput(say("session.no_packets"))
        chunk = ImuChunk.join(chunks)
        if chunk.coil_state is None or chunk.magnetometer_t is None:
            raise InvalidInput(say("bench.no_coils"))
        self.source = next(name for name in setup.placements if name == settings.source)
        self.sensor: Placement = sensor or others[0]
        self.design: Source = settings.coils
        self.current_limit_a = settings.current_limit_a
        row, own = setup.placements.index(self.sensor), setup.placements.index(self.source)
        coil, current, _ = read_coil_state(np.nan_to_num(chunk.coil_state[own]))
        self._step_s = chunk.time_step_s
        self.stops: list[Stop] = find_stops(
            chunk.gyroscope_radps[row],
            chunk.accelerometer_mps2[row],
            chunk.magnetometer_t[row],
            coil,
            current,
            chunk.time_step_s,
            full_scale_t=0.99 * float(setup.orientation_parameters.get("full_scale_t", _FULL_SCALE_T)),
        )

    def to_schema(self) -> list[SourceStopOut]:
        """Return the stops for people, each with where the sensor seems to have been."""
        return [
            SourceStopOut(
                start_s=round(one.start * self._step_s, 2),
                end_s=round(one.stop * self._step_s, 2),
                pulses=one.count.tolist(),
                strength_t=[float(value) for value in np.linalg.norm(one.pulses_t, axis=1)],
                position_m=self._roughly(one),
            )
            for one in self.stops
        ]

    def calibrate(
        self, positions_m: Sequence[tuple[float, float, float] | None], place_sigma_m: float
    ) -> CoilCalibration:
        """Fit the coils to the stops at these places, in their order; None leaves a stop out.

        Raises
        ------
        InvalidInput
            As many places as stops are needed, or the fit says what is wrong.
        """
        if len(positions_m) != len(self.stops):
            times = [
                say("bench.time", start_s=one.start_s, end_s=one.end_s) for one in self.to_schema()[:40]
            ] or [say("bench.no_stop")]
            raise InvalidInput(
                say("bench.places", stops=len(self.stops), places=len(positions_m), times=times),
                field="positions_m",
            )
        pairs = [
            (one, place) for one, place in zip(self.stops, positions_m, strict=True) if place is not None
        ]
        try:
            fit = calibrate_at_places(
                self.design,
                np.array([place for _, place in pairs]).reshape(-1, 3),
                np.array([one.pulses_t for one, _ in pairs]).reshape(-1, 3, 3),
                np.array([one.current_a for one, _ in pairs]).reshape(-1, 3),
                np.array([one.sigma_t for one, _ in pairs]),
                place_sigma_m,
            )
        except (EstimationError, np.linalg.LinAlgError) as error:
            raise InvalidInput(
                say(
                    "bench.no_fit",
                    reason=error.message if isinstance(error, EstimationError) else say("bench.singular"),
                ),
                field="positions_m",
            ) from error
        if not fit.gain_sigma <= WORST_GAIN_SIGMA:
            raise InvalidInput(
                say("bench.weak", sigma=fit.gain_sigma),
                field="positions_m",
            )
        return fit

    def _roughly(self, one: Stop) -> tuple[float, float, float] | None:
        fix = locate(
            self.design,
            np.arange(3),
            one.current_a,
            one.pulses_t,
            one.sigma_t,
            limits=TrackerLimits(gain_sigma=_ROUGHLY),
        )
        place: Float = np.asarray(fix.position_m)
        if fix.flags & ~TrackerFlag.AMBIGUOUS or not np.isfinite(place).all():
            return None
        x, y, z = (round(float(value), 3) for value in place)
        return x, y, z


def coils_out(source: Source) -> list[CoilIn]:
    """Return the coils of a source for the wire."""
    return [CoilIn.model_validate(coil.to_dict()) for coil in source.coils]


def findings(found: CoilCalibration, places: int) -> SourceFindings:
    """Return what a calibration said of itself."""
    return SourceFindings(
        moment_sigma=[float(value) for value in found.moment_sigma],
        place_sigma_m=[float(value) for value in found.place_sigma_m],
        direction_sigma_rad=[float(value) for value in found.direction_sigma_rad],
        residual_t=found.residual_t,
        place_residual_m=found.place_residual_m,
        places=places,
    )
