"""Wire types of markers: what an upload declares, and the report of their fusion with a sensor."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from app.schemas import Schema, Spoken
from estimators.conventions import Placement

MarkerFormat = Literal["c3d", "csv"]


class MarkerFileIn(Schema):
    """What a file of marker trajectories holds, and what of it is to be used."""

    format: MarkerFormat
    marker: str | None = Field(default=None, max_length=100)
    """Its name in the file; by default the one seen most."""
    cluster: list[str] = Field(default_factory=list, max_length=20)
    """Three or more markers on the same rigid body: clocks can then be aligned by the angular rate too."""
    up: Literal["x", "y", "z", "-x", "-y", "-z"] = "z"
    """Which axis of the laboratory points up."""
    unit: Literal["m", "cm", "mm", "inch"] = "mm"
    """Of a CSV file; a C3D file tells its own."""
    rate_hz: float | None = Field(default=None, gt=0, le=10_000)
    """Of a CSV file without a column `time_s`."""
    delimiter: Literal[",", ";", "\t"] = ","
    lever_arm_m: tuple[float, float, float] | None = None
    """From the sensor to the marker in sensor axes, where somebody measured it; otherwise it is found."""
    largest_offset_s: float | None = Field(default=None, gt=0)
    """How far the clocks can be apart; anything by default."""


class MarkerUploadIn(MarkerFileIn):
    """The JSON part `declaration` of uploaded marker trajectories; the file is the other part."""

    segment: Placement
    """The sensor that moved with the marker."""


class MarkerGap(Schema):
    """A stretch without the marker, filled by the sensor."""

    start_s: float
    length_s: float
    sigma_m: float
    """Largest one-sigma of the filled place."""
    withheld: bool
    """Two sigma exceed 10 mm: do not rely on it."""


class MarkerGapCheck(Schema):
    """Seen markers were hidden, filled and compared with what was seen."""

    length_s: float
    count: int
    inertial_m: float
    """Largest error of a gap, mean over the gaps."""
    spline_m: float | None
    """The same for a spline without the sensor."""
    within_three_sigma: float


class MarkerCurves(Schema):
    """For a plot: of each stretch of ticks the one with the largest value."""

    time_s: list[float]
    """Session time."""
    residual_m: list[float | None]
    """Distance of the marker from the fused one."""
    sigma_m: list[float | None]
    """One-sigma of the fused place, its longest axis."""
    speed_mps: list[float | None]


class MarkerReport(Spoken):
    """How markers and a sensor fit."""

    marker: str
    offset_s: float
    """Camera time minus session time, at the middle of the overlap."""
    offset_sigma_s: float
    drift_ppm: float
    drift_sigma_ppm: float
    correlation: float
    rival: float
    overlap_s: float
    aligned_by: Literal["acceleration", "rate"]
    lever_arm_m: list[float]
    lever_arm_sigma_m: list[float]
    heading_sigma_rad: float
    residual_rms_m: list[float]
    """Of the frames that were used; x, y, z of the laboratory."""
    sigma_scale: float
    """How far noise was raised until the innovations fitted it."""
    mean_nis: float | None
    frame_count: int
    used_count: int
    rejected_count: int
    bridged_s: float = 0.0
    """Of the sensor's samples, interpolated over lost packets: they counted as noisier."""
    gaps: list[MarkerGap]
    gap_count: int
    """All of them; the list holds the longest."""
    checks: list[MarkerGapCheck]
    curves: MarkerCurves
    reasons: list[str]
    """What was left out and why."""


class MarkerMotionOut(Schema):
    """A stretch of the fused motion, for curves; laboratory with z up, null where nothing is known."""

    markers_id: str
    time_s: list[float]
    """Session time."""
    place_m: tuple[list[float | None], list[float | None], list[float | None]]
    """x, y and z of the fused marker."""
    sigma_m: tuple[list[float | None], list[float | None], list[float | None]]
    """One-sigma of each."""
    measured_m: tuple[list[float | None], list[float | None], list[float | None]]
    """The marker as the cameras saw it."""
    speed_mps: list[float | None]
    """Of the sensor."""
    is_gap: list[bool]
    """The cameras did not see the marker for longer than they take from frame to frame: filled by the sensor."""


class MarkersOut(Spoken):
    """Uploaded trajectories with what became of them."""

    id: str
    session_id: str
    segment: str
    format: MarkerFormat
    file_bytes: int
    uploaded_at: datetime | None
    status: Literal["queued", "running", "complete", "failed"]
    message: str
    report: MarkerReport | None
