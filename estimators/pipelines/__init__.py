"""Pipelines of a session: a setup in, frames out; live by `step`, off-line by `run`."""

from estimators.pipelines._balance import (
    TRUNK,
    BalancePipeline,
    hips_above_ankles_m,
    sway_columns,
    trunk_above_ankles_m,
)
from estimators.pipelines._contract import (
    SLIPPED,
    BodyDimensions,
    Calibration,
    DeviceConstants,
    FrameLayout,
    Frames,
    Pipeline,
    SessionSetup,
)
from estimators.pipelines._offline import is_offline, smooth_network
from estimators.pipelines._orientation import OrientationPipeline
from estimators.pipelines._run import available, concatenate, create, find_pose, kind, run, step_through
from estimators.pipelines.arm.elbows import elbow_poses, elbows_to_refine, refine_elbows
from estimators.pipelines.arm.pipeline import ArmPipeline
from estimators.pipelines.arm.slips import Slip, SlipSearch, in_doubt, with_slips
from estimators.pipelines.arm.worn import WornCheck, judge_worn
from estimators.pipelines.relative.pipeline import ModulesChunk, RelativePosePipeline
from estimators.pipelines.relative.smoothing import smooth_modules, with_modules
from estimators.pipelines.relative.source import NOMINAL_GAIN_SIGMA, SourceSettings, relative_source
from estimators.pipelines.relative.tracker_bursts import (
    BURST_ORIENTATION,
    BURSTS,
    BurstAnalysis,
    analyse_bursts,
    angles_with_sigma,
)
from estimators.pipelines.walk.layout import FORCE_STATES
from estimators.pipelines.walk.magnetic_feet import FEET, apart_at_start, relative_feet, with_relative_feet
from estimators.pipelines.walk.pipeline import GaitPipeline
from estimators.pipelines.walk.shoes import ShoeWalk, analyse_shoes, has_shoes, with_shoes
from estimators.pipelines.walk.walk import Walk, analyse_walk

__all__ = [
    "BURSTS",
    "BURST_ORIENTATION",
    "FEET",
    "FORCE_STATES",
    "NOMINAL_GAIN_SIGMA",
    "SLIPPED",
    "TRUNK",
    "ArmPipeline",
    "BalancePipeline",
    "BodyDimensions",
    "BurstAnalysis",
    "Calibration",
    "DeviceConstants",
    "FrameLayout",
    "Frames",
    "GaitPipeline",
    "ModulesChunk",
    "OrientationPipeline",
    "Pipeline",
    "RelativePosePipeline",
    "SessionSetup",
    "ShoeWalk",
    "Slip",
    "SlipSearch",
    "SourceSettings",
    "Walk",
    "WornCheck",
    "analyse_bursts",
    "analyse_shoes",
    "analyse_walk",
    "angles_with_sigma",
    "apart_at_start",
    "available",
    "concatenate",
    "create",
    "elbow_poses",
    "elbows_to_refine",
    "find_pose",
    "has_shoes",
    "hips_above_ankles_m",
    "in_doubt",
    "is_offline",
    "judge_worn",
    "kind",
    "refine_elbows",
    "relative_feet",
    "relative_source",
    "run",
    "smooth_modules",
    "smooth_network",
    "step_through",
    "sway_columns",
    "trunk_above_ankles_m",
    "with_modules",
    "with_relative_feet",
    "with_shoes",
    "with_slips",
]
