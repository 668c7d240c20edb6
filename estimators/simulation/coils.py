"""Body-worn magnetic sources: movements, signals, and a source that follows the filter, under one name."""

from estimators.simulation.coil.bench import bench_motion, bench_places, wound_by_hand
from estimators.simulation.coil.bursts import BURST_MOVEMENTS, burst_motion, fire_bursts
from estimators.simulation.coil.loop import SourceFaults, run_closed_loop
from estimators.simulation.coil.motion import MOVEMENTS, RelativeMotion, relative_motion
from estimators.simulation.coil.scene import EARTH_FIELD_T, Iron, ModuleErrors, RelativeScene, relative_scene

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
