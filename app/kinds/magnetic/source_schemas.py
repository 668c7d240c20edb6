"""Wire types of magnetic sources whose coils were measured."""

from datetime import UTC, datetime
from typing import Annotated, Literal

from pydantic import AwareDatetime, Field

from app.schemas import Moment, Schema
from estimators.conventions import Placement

Triple = tuple[float, float, float]
Finite = Annotated[float, Field(allow_inf_nan=False)]


WORST_GAIN_SIGMA = 0.2
"""Coils known less well than this are better described than measured."""
_EARLIEST = datetime(2000, 1, 1, tzinfo=UTC)
_LATEST = datetime(2200, 1, 1, tzinfo=UTC)
_Metre = Annotated[Finite, Field(ge=-2, le=2)]
"""No module is larger, no bench longer, and no axis needs to be."""


class CoilIn(Schema):
    """One coil in the frame of its module; see `estimators.magnetic.Coil`."""

    turns: Annotated[Finite, Field(ge=-5000, le=5000)]
    """May carry the measured gain, so need not be whole."""
    radius_m: float = Field(gt=0, le=0.5)
    centre_m: tuple[_Metre, _Metre, _Metre]
    axis: tuple[_Metre, _Metre, _Metre]
    length_m: float = Field(default=0.0, ge=0, le=0.5)
    depth_m: float = Field(default=0.0, ge=0, le=0.5)
    layers: tuple[int, int] = (1, 1)


class SourceFindings(Schema):
    """What a calibration said of itself; one number a coil where there are lists."""

    moment_sigma: list[Finite] = Field(default_factory=list, max_length=3)
    place_sigma_m: list[Finite] = Field(default_factory=list, max_length=3)
    direction_sigma_rad: list[Finite] = Field(default_factory=list, max_length=3)
    residual_t: Finite | None = None
    place_residual_m: Finite | None = None
    places: int | None = None


class MagneticSourceIn(Schema):
    """A source as somebody typed it or `telemotion calibrate-source` wrote it. The same serial number replaces."""

    name: str = Field(min_length=1, max_length=100)
    serial: str = Field(min_length=1, max_length=100)
    coils: list[CoilIn] = Field(min_length=3, max_length=3)
    current_limit_a: float = Field(default=1.5, gt=0, lt=10)
    gain_sigma: float = Field(ge=0.001, le=WORST_GAIN_SIGMA)
    found: SourceFindings = Field(default_factory=SourceFindings)
    method: Literal["file", "typed"] = "typed"
    calibrated_at: Annotated[AwareDatetime, Field(ge=_EARLIEST, le=_LATEST)] | None = None
    """With its zone; by default now."""


class MagneticSourceOut(Schema):
    """A source of the clinic."""

    id: str
    name: str
    serial: str
    coils: list[CoilIn]
    current_limit_a: float
    gain_sigma: float
    found: SourceFindings
    method: Literal["session", "file", "typed"]
    session_id: str | None
    calibrated_at: Moment
    calibrated_by: str | None
    """Name of the person."""


class SourceStopOut(Schema):
    """A stretch of a bench session in which the sensor lay still while every coil fired."""

    start_s: float
    end_s: float
    pulses: list[int]
    """Of each coil."""
    strength_t: list[float]
    position_m: Triple | None
    """Where it was, roughly, as the coils as described say; None where they cannot."""


class SourceStopsOut(Schema):
    """What a magnetic session holds of a bench."""

    source: Placement
    sensor: Placement
    stops: list[SourceStopOut]


class SourceCalibrationIn(Schema):
    """Where the sensor lay, stop by stop."""

    name: str = Field(min_length=1, max_length=100)
    serial: str = Field(min_length=1, max_length=100)
    positions_m: list[tuple[_Metre, _Metre, _Metre] | None] = Field(min_length=1, max_length=200)
    """From the middle of the source along its axes, one for each stop; None leaves a stop out."""
    place_sigma_m: float = Field(default=0.001, gt=0, le=0.02)
    """How well the places were measured."""
    sensor: Placement | None = None
    """By default the first."""
