"""Marker positions and an inertial module together: gap filling, higher rate, smoothing."""

from estimators.optical._contract import OpticalResult, Provenance
from estimators.optical._contradictions import TURNS
from estimators.optical._gaps import WITHHELD_M, Gap
from estimators.optical._recording import OpticalFusion, fuse_markers
from estimators.optical._stretch import GapCheck
from estimators.optical.alignment._clusters import Alignment

__all__ = [
    "TURNS",
    "WITHHELD_M",
    "Alignment",
    "Gap",
    "GapCheck",
    "OpticalFusion",
    "OpticalResult",
    "Provenance",
    "fuse_markers",
]
