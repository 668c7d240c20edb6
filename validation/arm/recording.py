"""Arms of a whole-body recording without truth: every joint must stay where human joints can be."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.conventions import SIDES
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames, SessionSetup, run
from estimators.recording import Float, Recording
from validation.protocol import Data, Figure, Protocol, Values


@dataclass(frozen=True)
class Reach:
    """How far a joint angle of a healthy person goes, degrees in our sign convention."""

    title: str
    column: str
    least_deg: float
    most_deg: float


REACHES: Final = (
    Reach("shoulder elevation", "thorax_humerus_{side}_yxy_elevation", 0.0, 180.0),
    Reach("elbow flexion", "humerus_forearm_{side}_zxy_flexion", 0.0, 150.0),
    Reach("elbow carrying", "humerus_forearm_{side}_zxy_carrying", -20.0, 20.0),
    Reach("elbow pronation", "humerus_forearm_{side}_zxy_pronation", 10.0, 170.0),
    Reach("wrist flexion", "forearm_hand_{side}_zxy_flexion", -70.0, 80.0),
    Reach("wrist deviation", "forearm_hand_{side}_zxy_deviation", -20.0, 30.0),
)
"""Active ranges of motion (American Academy of Orthopaedic Surgeons); carrying as far to either side."""
PLANE: Final = Reach("plane of the raised arm", "thorax_humerus_{side}_yxy_plane_of_elevation", -130.0, 150.0)
"""From the hand behind the back (extension with adduction) over abduction and flexion to across the chest.

No table gives it; judged where the arm is raised.
"""
RAISED_DEG: Final = 30.0
MOUNTING_DEG: Final = 20.0
"""Ten degrees for straps put on by hand and ten for a heading that, without a compass, the elbow tells no better."""
_WORN: Final = ("sternum", "upper_arm", "forearm", "hand")
_UNSOUND = int(OrientationFlag.INVALID | OrientationFlag.CONVERGING)


def beyond_deg(frames: Frames, reach: Reach, *, raised_only: bool = False) -> float:
    """Return how far the angle of either side goes beyond its reach at worst, degrees; 0 within.

    Parameters
    ----------
    frames : Frames
        Of the arm pipeline.
    raised_only : bool
        Leave out ticks with the arm raised less than `RAISED_DEG`, where the plane means little.
    """
    worst = 0.0
    for side in SIDES:
        column = reach.column.format(side=side)
        if column not in frames.layout.angles:
            continue
        i = frames.layout.angles.index(column)
        angle: Float = np.degrees(frames.angle_rad[:, i])
        sound = np.isfinite(angle) & ((frames.angle_flags[:, i] & _UNSOUND) == 0)
        if raised_only:
            elevation = frames.layout.angles.index(f"thorax_humerus_{side}_yxy_elevation")
            sound &= np.degrees(frames.angle_rad[:, elevation]) > RAISED_DEG
        if sound.any():
            past = np.maximum(reach.least_deg - angle[sound], angle[sound] - reach.most_deg)
            worst = max(worst, float(past.max()))
    return worst


def estimate_arms(recording: Recording, orientation: str) -> Frames:
    """Run the product's off-line chain over both arms, with what the elbows tell of the mounting."""
    placements = tuple(name for name in recording.placements if name.startswith(_WORN))
    setup = SessionSetup("arm", placements, recording.nominal_rate_hz, orientation=orientation)  # type: ignore[arg-type]
    return run(recording, setup, elbows_from_movement=True)[0]


def _reaches(seeds: Sequence[int], data: Data) -> Values:
    """One value a recording and filter; the seeds have nothing to vary."""
    values: dict[str, list[float]] = {}
    for recording in data.values():
        for name in ("telemotion", "telemotion_smoother"):
            frames = estimate_arms(recording, name)
            for reach in REACHES:
                values.setdefault(reach.title, []).append(beyond_deg(frames, reach))
            values.setdefault(PLANE.title, []).append(beyond_deg(frames, PLANE, raised_only=True))
    return {f"{name}, beyond human reach": np.array(found) for name, found in values.items()}


ARM_RECORDING = Protocol(
    name="arm_recording",
    title="Both arms of a real recording stay where arms can be (qmt)",
    source="Recording of dlaidig/qmt; reaches of the American Academy of Orthopaedic Surgeons",
    what="Sensors without compasses on trunk and both arms, calibrated by standing still and by their own elbows; "
    "how far each angle goes beyond what a healthy joint reaches, at the worst sample of filter and smoother. "
    f"{MOUNTING_DEG:.0f} degrees are allowed for mounting and heading; the plane counts where the arm is raised over "
    f"{RAISED_DEG:.0f} degrees.",
    figures=tuple(
        Figure(f"{reach.title}, beyond human reach", "deg", MOUNTING_DEG) for reach in (*REACHES, PLANE)
    ),
    measure=_reaches,
    needs_data="qmt_mat",
)
