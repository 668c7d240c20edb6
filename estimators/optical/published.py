"""Optical fusion as published, with the parts of its smoothing: for experiments and tests."""

from estimators.optical._contract import OpticalChunk, OpticalStart
from estimators.optical._fusion import OpticalInertialFilter, filter_and_smooth, smooth_optical
from estimators.optical._gaps import fill_by_spline, gap_report
from estimators.optical._lag import FixedLagSmoother, smooth_with_lag
from estimators.optical.alignment._clusters import align_cluster, align_markers

__all__ = [
    "FixedLagSmoother",
    "OpticalChunk",
    "OpticalInertialFilter",
    "OpticalStart",
    "align_cluster",
    "align_markers",
    "fill_by_spline",
    "filter_and_smooth",
    "gap_report",
    "smooth_optical",
    "smooth_with_lag",
]
