"""The demonstration's session with a magnetic source, as it is sent."""

import numpy as np
import pytest

from app.demo.sources import MOVEMENT, rehearse, setup_of
from app.gateway.relative_patient import RelativePatient
from app.network.alignment import align_all
from app.network.declaration import check_hello
from app.network.packet import decode_packet
from estimators import pipelines


@pytest.mark.slow
def test_a_rehearsed_source_was_asked_and_is_found_in_what_is_sent() -> None:
    patient = RelativePatient("flexion", 9.0, seed=3)
    sent = rehearse(patient)
    declaration = check_hello(patient.hello("again"))
    chunk = align_all([decode_packet(one.data, declaration) for one in sent], declaration)
    frames = pipelines.create(setup_of(patient)).step(chunk)
    names = frames.layout.scalars
    asked = (frames.scalar[:, names.index("source_ask_coil")] > 0).sum()
    fired = (np.diff(frames.scalar[:, names.index("source_coil")], prepend=0.0) > 0).sum()
    assert patient.control.account.asked == fired >= 8
    assert patient.control.account.by_plan == 0
    assert fired <= asked
    place = np.stack([frames.scalar[:, names.index(f"sternum_{axis}_m")] for axis in "xyz"], axis=1)
    error = np.linalg.norm(place - patient.scene.position_m[: len(place)], axis=1)[480:]
    assert np.sqrt(np.mean(error**2)) < 0.025


@pytest.mark.slow
def test_the_magnetic_session_moves_where_one_can_see_it() -> None:
    """On what the pipeline finds, not on what was simulated."""
    patient = RelativePatient(MOVEMENT, 14.0, seed=3)
    declaration = check_hello(patient.hello("again"))
    chunk = align_all([decode_packet(one.data, declaration) for one in rehearse(patient)], declaration)
    frames = pipelines.create(setup_of(patient)).step(chunk)
    names, sensor = frames.layout.scalars, patient.placements[1]
    place = np.stack([frames.scalar[:, names.index(f"{sensor}_{axis}_m")] for axis in "xyz"], axis=1)[600:]
    distance = np.linalg.norm(place, axis=1)
    assert np.ptp(distance) > 0.12
    q = frames.q_room_segment[600:, list(frames.layout.segments).index(sensor)]
    turned = 2.0 * np.arccos(np.clip(np.abs(q @ q[0]), 0.0, 1.0))
    assert np.degrees(turned.max()) > 50.0
