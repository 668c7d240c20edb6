"""Marker positions and an inertial module together: gap filling, higher rate, smoothing."""

from estimators.optical._alignment import Alignment, align_cluster, align_markers
from estimators.optical._contract import (
    OpticalChunk,
    OpticalParameters,
    OpticalResult,
    OpticalStart,
    Provenance,
)
from estimators.optical._contradictions import TURNS
from estimators.optical._fusion import OpticalInertialFilter, filter_and_smooth, smooth_optical
from estimators.optical._gaps import WITHHELD_M, Gap, fill_by_spline, gap_report
from estimators.optical._lag import FixedLagSmoother, smooth_with_lag
from estimators.optical._recording import OpticalFusion, fuse_markers
from estimators.optical._stretch import GapCheck

__all__ = [
    "TURNS",
    "WITHHELD_M",
    "Alignment",
    "FixedLagSmoother",
    "Gap",
    "GapCheck",
    "OpticalChunk",
    "OpticalFusion",
    "OpticalInertialFilter",
    "OpticalParameters",
    "OpticalResult",
    "OpticalStart",
    "Provenance",
    "align_cluster",
    "align_markers",
    "fill_by_spline",
    "filter_and_smooth",
    "fuse_markers",
    "gap_report",
    "smooth_optical",
    "smooth_with_lag",
]
