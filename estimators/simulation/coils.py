"""Body-worn magnetic sources: movements, signals, and a source that follows the filter, under one name."""

from estimators.simulation._coil import EARTH_FIELD_T, Iron, ModuleErrors, RelativeScene, relative_scene
from estimators.simulation._coil_bench import bench_motion, bench_places, wound_by_hand
from estimators.simulation._coil_bursts import BURST_MOVEMENTS, burst_motion, fire_bursts
from estimators.simulation._coil_loop import SourceFaults, run_closed_loop
from estimators.simulation._coil_motion import MOVEMENTS, RelativeMotion, relative_motion

__all__ = [
    "BURST_MOVEMENTS",
    "EARTH_FIELD_T",
    "MOVEMENTS",
    "Iron",
    "ModuleErrors",
    "RelativeMotion",
    "RelativeScene",
    "SourceFaults",
    "bench_motion",
    "bench_places",
    "burst_motion",
    "fire_bursts",
    "relative_motion",
    "relative_scene",
    "run_closed_loop",
    "wound_by_hand",
]
