"""Cameras of the demonstration: a marker on the hand of a past session, hidden now and then, uploaded like any file."""

import asyncio
import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from scipy.interpolate import make_interp_spline

from app.errors import TelemotionError
from app.gateway import ServiceClient
from app.readers.markers.schemas import MarkerUploadIn
from estimators import rotation
from estimators.conventions import Placement
from estimators.simulation import ArmScenario, simulate_arm

CAMERAS_HZ: Final = 120.0
LATE_S: Final = 1.4
"""The cameras begin later than the sensors."""
NOISE_M: Final = 0.0003
MARKER_M: Final = np.array([0.012, 0.008, 0.020])
"""From the sensor to its marker, sensor axes."""
HIDDEN_S: Final = (0.4, 1.0, 2.0)
"""Once in every third of the recording, longer each time."""
_POLL_S: Final = 0.3
_TIMEOUT_S: Final = 120.0


def write_markers(scenario: ArmScenario, segment: Placement, path: Path) -> None:
    """Write what cameras see of a marker beside one sensor: a CSV in millimetres with a clock of its own.

    Parameters
    ----------
    scenario : ArmScenario
        The same as that of the session: the same scenario is the same movement.
    segment : str
        One of its placements.
    """
    truth = simulate_arm(scenario).truth
    row = scenario.placements.index(segment)
    q_room_sensor = rotation.multiply(rotation.about_z(-truth.facing_rad), truth.q_earth_sensor[row])
    marker = truth.sensor_room_m[row] + rotation.rotate(q_room_sensor, MARKER_M)
    time_s = np.arange(truth.time_s[0] + LATE_S, truth.time_s[-1], 1.0 / CAMERAS_HZ)
    seen = np.asarray(make_interp_spline(truth.time_s, marker, k=5)(time_s))
    seen += np.random.default_rng([scenario.seed, 17]).normal(0.0, NOISE_M, seen.shape)
    is_hidden = np.zeros(len(time_s), dtype=np.bool_)
    begin_s = scenario.schedule.n_pose_s
    for number, length_s in enumerate(HIDDEN_S):
        start_s = begin_s + (number + 0.5) / len(HIDDEN_S) * (time_s[-1] - begin_s)
        is_hidden |= (time_s >= start_s) & (time_s < start_s + length_s)
    lines = ["time_s,HAND_x,HAND_y,HAND_z"]
    for t, place, hidden in zip(time_s - time_s[0], 1e3 * seen, is_hidden, strict=True):
        lines.append(f"{t:.4f}," + (",," if hidden else ",".join(f"{x:.2f}" for x in place)))
    path.write_text("\n".join(lines), encoding="utf-8")


async def send_markers(
    service: ServiceClient, session_id: str, scenario: ArmScenario, segment: Placement
) -> None:
    """Upload them to the session; they are fused while other things go on.

    Parameters
    ----------
    service : ServiceClient
        Signed in as the therapist.

    Raises
    ------
    TelemotionError
        They were refused.
    """
    declared = MarkerUploadIn(segment=segment, format="csv")
    address = f"/api/sessions/{session_id}/markers"
    with TemporaryDirectory() as folder:
        path = Path(folder) / "hand.csv"
        await asyncio.to_thread(write_markers, scenario, segment, path)
        answer = await service.http.post(
            address,
            files=[
                ("declaration", (None, json.dumps(declared.model_dump(mode="json")), "application/json")),
                ("file", (path.name, path.read_bytes(), "text/csv")),
            ],
        )
    if not answer.is_success:
        raise TelemotionError(f"{address} answered {answer.status_code}: {answer.text[:300]}")


async def until_fused(service: ServiceClient, session_id: str) -> None:
    """Wait until the markers of a session are fused.

    Raises
    ------
    TelemotionError
        They contradict the sensor, or it took too long.
    """
    for _ in range(round(_TIMEOUT_S / _POLL_S)):
        found = (await service.http.get(f"/api/sessions/{session_id}/markers")).json()[0]
        if found["status"] == "complete":
            return
        if found["status"] == "failed":
            raise TelemotionError(found["message"])
        await asyncio.sleep(_POLL_S)
    raise TelemotionError("The markers were not fused in time.")
