"""A walk on instrumented shoes through the service: forces, balance and steps, kept, read back and erased."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select

from app.database.unit_of_work import read_only
from app.errors import RecordingFormatError
from app.ingest.upload import register
from app.ingest.upload_task import upload
from app.kinds.walk.shoes import SHOES_STREAM
from app.readers import guess, read, write_instrumented_shoe
from app.recordings.analysis.jobs import run_job
from app.recordings.files_in_passing import upload_folder
from app.recordings.models import SignalChunk
from app.recordings.schemas import UploadIn
from app.recordings.signals.store import read_frames
from app.settings import Settings
from estimators.measures import measures_of
from estimators.simulation import Bout, Leg, SimulatedWalk, gait_preset, simulate_gait


@pytest.fixture(scope="module")
def simulated() -> SimulatedWalk:
    """Return a stroke-like walk: paretic left leg, weight and mass toward the right."""
    preset = gait_preset("stroke", 3)
    return simulate_gait(replace(preset, rate_hz=100.0, course=(Bout((Leg(11),), 3.0),)))


@pytest.mark.slow
def test_forces_and_balance_of_a_stroke_like_walk_are_kept_and_read(
    engine: Engine,
    settings: Settings,
    world: Any,
    therapist: Any,
    tmp_path: Path,
    simulated: SimulatedWalk,
) -> None:
    path = upload_folder(settings) / "walk.upload"
    source = tmp_path / "walk.csv"
    write_instrumented_shoe(simulated.recording, source)
    assert guess(source) == "instrumented_shoe"
    path.write_bytes(source.read_bytes())
    width_m = 0.18
    declaration = UploadIn(
        patient_id=world.patient_id,
        format="instrumented_shoe",
        feet_apart_m=width_m,
        feet_apart_end_m=width_m,
    )
    job = register(engine, settings, world.subjects["therapist"], declaration, path)
    done = run_job(engine, settings, job.id, upload)
    assert done.status == "complete", done.message
    walk = therapist.get(f"/api/sessions/{done.session_id}/gait").json()
    truth = simulated.truth
    balance = walk["balance"]
    assert balance["mass_kg"] == pytest.approx(truth.mass_kg, rel=0.03)
    assert balance["apart_source"] == "measured"
    # The centre of mass follows the truth; its level lies where the patient's stature says.
    centre = np.array(balance["centre_m"])
    expected = np.stack(
        [np.interp(balance["time_s"], truth.time_s, part) for part in truth.com.position.T], axis=1
    )
    assert np.sqrt(np.mean((centre - expected)[:, 0] ** 2)) < 0.03
    assert np.sqrt(np.mean((centre - expected)[:, 1] ** 2)) < 0.012
    # Toward the leg that is not paretic: to the right.
    measures = {one["measure"]: one["value"] for one in balance["measures"]}
    assert measures["weight_on_left"] == pytest.approx(0.38, abs=0.03)
    assert any(len(support["outline_m"]) >= 3 for support in balance["support"])
    both = {one["measure"]: one for one in walk["both"]}
    assert walk["has_step_width"] is True
    assert both["step_width"]["value"] == pytest.approx(width_m, abs=0.03)
    feet = {foot["side"]: foot for foot in walk["feet"]}
    # What is computed and what the table names are the same: neither is lost on the way to a comparison.
    computed = {"both": walk["both"], "asymmetry": walk["asymmetry"], "balance": balance["measures"]}
    for part, found in [*computed.items(), *(("foot", foot["measures"]) for foot in feet.values())]:
        assert {one["measure"] for one in found} == set(measures_of(part)), part
    for side, foot in feet.items():
        curves = {curve["name"]: curve for curve in foot["curves"]}
        assert {"force_vertical", "force_forward", "ankle_moment", "ankle_power", "toe_moment"} <= set(curves)
        assert 0.9 < max(curves["force_vertical"]["mean"]) < 1.4
        assert max(curves["ankle_moment"]["mean"]) > 0.5
        # The ground turns the foot as it truly does, outward positive, and only while it stands.
        loaded = truth.feet[side]
        twist = np.array(curves["free_moment"]["mean"])
        sign = 1.0 if side == "left" else -1.0
        counted = [stride for stride in foot["strides"] if stride["is_counted"]]
        phase_s = np.linspace(0.0, 1.0, 51)
        cycles = np.array([s["contact_s"] - s["duration_s"] + phase_s * s["duration_s"] for s in counted])
        true_twist = sign * np.interp(cycles, truth.time_s, np.nan_to_num(loaded.free_moment_nm)).mean(axis=0)
        assert np.sqrt(np.mean((twist - true_twist / truth.mass_kg) ** 2)) < 0.01
        numbers = {one["measure"]: one for one in foot["measures"]}
        vertical = np.interp(cycles, truth.time_s, loaded.force_n[:, 2]) / (truth.mass_kg * 9.80665)
        assert numbers["force_most"]["value"] == pytest.approx(vertical.max(axis=1).mean(), abs=0.05)
        assert numbers["force_most"]["count"] == len(counted)
        # Events are those of the forces.
        contacts = np.array([stride["contact_s"] for stride in foot["strides"] if stride["is_counted"]])
        landed = truth.feet[side].land_s
        assert np.abs(contacts[:, None] - landed[None]).min(axis=1).max() < 0.045
    step_time = {one["measure"]: one["value"] for one in walk["asymmetry"]}["step_time"]
    assert step_time == pytest.approx((0.9 - 0.6) / 0.75, abs=0.05)
    assert walk["test"]["kind"] == "walk"
    assert walk["test"]["step_count"] == 11
    way = np.mean([foot.foothold_m[-1, 0] - foot.foothold_m[0, 0] for foot in truth.feet.values()])
    assert walk["test"]["distance_m"] == pytest.approx(way, rel=0.03)
    shown = therapist.get(f"/api/sessions/{done.session_id}").json()
    with read_only(engine) as session:
        frames = read_frames(session, shown["main_result_id"])
    assert "centre_of_mass" in frames.layout.points
    assert frames.layout.scalars[-1] == "margin_of_stability_m"
    assert therapist.delete(f"/api/sessions/{done.session_id}").status_code == 204
    with read_only(engine) as session:
        left = select(SignalChunk).where(SignalChunk.stream == SHOES_STREAM)
        assert session.scalars(left).first() is None


@pytest.mark.slow
def test_shoes_in_the_wrong_unit_are_refused(tmp_path: Path, simulated: SimulatedWalk) -> None:
    sensors = {
        name: sensor if sensor.force_n is None else replace(sensor, force_n=sensor.force_n / 9.81)
        for name, sensor in simulated.recording.sensors.items()
    }
    path = tmp_path / "walk.csv"
    write_instrumented_shoe(replace(simulated.recording, sensors=sensors), path)
    with pytest.raises(RecordingFormatError, match="newton"):
        read(path)
    write_instrumented_shoe(simulated.recording, path)
    text = path.read_text().replace("forefoot_right_moment_y_nm", "other", 1)
    path.write_text(text)
    with pytest.raises(RecordingFormatError, match="forefoot_right_moment_y_nm"):
        read(path)
