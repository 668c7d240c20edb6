"""Sources of a clinic: kept with their measured coils, chosen for sessions, calibrated from a bench in the store."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select
from typer.testing import CliRunner

from app.accounts.models import AuditEvent
from app.cli import cli
from app.database.unit_of_work import read_only
from app.demo.sources import rehearse, setup_of
from app.errors import TelemotionError
from app.gateway.relative_patient import RelativePatient
from app.network.declaration import check_hello
from app.network.packet import decode_packet
from app.network.packet_log import log_entry, log_head
from app.network.raw_packet import RawPacket
from app.recordings.signals.group_commit import GroupCommitWriter
from estimators import pipelines
from estimators.magnetic import perpendicular_source
from estimators.pipelines import SessionSetup, relative_source
from estimators.simulation.coils import bench_places

COILS = [coil.to_dict() for coil in perpendicular_source(0.061, turns=51.0).coils]
TYPED = {"name": "Belt", "serial": "S-1", "coils": COILS, "gain_sigma": 0.006, "current_limit_a": 1.4}


def test_a_source_is_kept_replaced_listed_and_retired(
    therapist: Any, patient: Any, foreign_therapist: Any, engine: Engine
) -> None:
    made = therapist.post("/api/magnetic-sources", json=TYPED)
    assert made.status_code == 201, made.text
    first = made.json()
    assert (first["method"], first["session_id"]) == ("typed", None)
    assert first["calibrated_by"]
    again = therapist.post(
        "/api/magnetic-sources", json=TYPED | {"gain_sigma": 0.004, "method": "file"}
    ).json()
    assert (again["id"], again["gain_sigma"], again["method"]) == (first["id"], 0.004, "file")
    assert [one["id"] for one in therapist.get("/api/magnetic-sources").json()] == [first["id"]]
    # Another clinic may have the same number on another source, and sees nothing of this one.
    assert foreign_therapist.get("/api/magnetic-sources").json() == []
    other = foreign_therapist.post("/api/magnetic-sources", json=TYPED).json()
    assert other["id"] != first["id"]
    assert foreign_therapist.delete(f"/api/magnetic-sources/{first['id']}").status_code == 404
    assert patient.get("/api/magnetic-sources").status_code == 403
    for _ in range(2):
        assert therapist.delete(f"/api/magnetic-sources/{first['id']}").status_code == 204
    assert therapist.get("/api/magnetic-sources").json() == []
    with read_only(engine) as session:
        actions = session.scalars(
            select(AuditEvent.action).where(AuditEvent.resource_id == first["id"])
        ).all()
    assert actions == ["source.calibrate", "source.calibrate", "source.retire"]


@pytest.mark.parametrize(
    "wrong",
    [
        {"coils": COILS[:2]},
        {"coils": [COILS[0] | {"axis": [0, 0, 0]}, *COILS[1:]]},
        {"coils": [COILS[0] | {"turns": 5000.0}, *COILS[1:]]},
        {"coils": [COILS[0] | {"turns": float("inf")}, *COILS[1:]]},
        {"gain_sigma": 0.0},
        {"current_limit_a": 20.0},
        {"serial": ""},
    ],
)
def test_what_is_no_source_is_refused(therapist: Any, wrong: dict[str, Any]) -> None:
    answer = therapist.post(
        "/api/magnetic-sources",
        content=json.dumps(TYPED | wrong),
        headers={"Content-Type": "application/json"},
    )
    assert answer.status_code == 422, answer.text


def session_with(client: Any, world: Any, **more: Any) -> Any:
    return client.post(
        "/api/sessions",
        json={
            "patient_id": world.patient_id,
            "pipeline": "relative_pose",
            "placements": ["pelvis", "sternum"],
            "rate_hz": 120.0,
            **more,
        },
    )


def test_a_session_takes_the_coils_of_its_source_and_keeps_them(
    therapist: Any, foreign_therapist: Any, world: Any
) -> None:
    source = therapist.post("/api/magnetic-sources", json=TYPED).json()
    typed = {"coil_turns": 999.0, "current_a": 1.2}
    answer = session_with(therapist, world, magnetic_source_id=source["id"], orientation_parameters=typed)
    assert answer.status_code == 201, answer.text
    told = answer.json()["orientation_parameters"]
    setup = SessionSetup("relative_pose", ("pelvis", "sternum"), 120.0, orientation_parameters=told)
    assert [coil.to_dict() for coil in relative_source(setup).coils.coils] == COILS
    (one,) = pipelines.create(setup).filters.values()  # type: ignore[attr-defined]
    assert (one.parameters["gain_sigma"], one.parameters["current_a"]) == (0.006, 1.2)
    shown = therapist.get(f"/api/sessions/{answer.json()['id']}/magnetic-safety").json()
    assert (shown["source_name"], shown["source_serial"], shown["gain_sigma"]) == ("Belt", "S-1", 0.006)
    # Calibrated again or retired: what was recorded stays as it was.
    therapist.post("/api/magnetic-sources", json=TYPED | {"gain_sigma": 0.02})
    therapist.delete(f"/api/magnetic-sources/{source['id']}")
    kept = therapist.get(f"/api/sessions/{answer.json()['id']}").json()["orientation_parameters"]
    assert kept["gain_sigma"] == 0.006
    assert session_with(therapist, world, magnetic_source_id=source["id"]).status_code == 404
    other = foreign_therapist.post("/api/magnetic-sources", json=TYPED).json()
    assert session_with(therapist, world, magnetic_source_id=other["id"]).status_code == 404


def test_only_a_magnetic_session_has_a_source(therapist: Any, world: Any) -> None:
    source = therapist.post("/api/magnetic-sources", json=TYPED).json()
    answer = session_with(therapist, world, pipeline="arm", magnetic_source_id=source["id"])
    assert answer.status_code == 422
    unmeasured = session_with(therapist, world).json()
    shown = therapist.get(f"/api/sessions/{unmeasured['id']}/magnetic-safety").json()
    assert (shown["source_serial"], shown["gain_sigma"]) == ("", 0.04)


@pytest.fixture(scope="module")
def bench() -> tuple[RelativePatient, list[bytes]]:
    """Return a source wound by hand on a bench, and what its network sent."""
    patient = RelativePatient("bench")
    return patient, [delivery.data for delivery in rehearse(patient)]


@pytest.mark.slow
def test_a_bench_session_tells_the_coils_and_the_source_is_kept(
    bench: tuple[RelativePatient, list[bytes]],
    engine: Engine,
    therapist: Any,
    patient: Any,
    new_session: Callable[..., str],
) -> None:
    measured, sent = bench
    declared = check_hello(measured.hello("-"))
    session_id = new_session(setup=setup_of(measured), state="analysed", hello=declared.to_dict())
    writer = GroupCommitWriter(engine)
    writer.start()
    writer.open_session(session_id)
    for number, data in enumerate(sent):
        writer.append_packet(session_id, RawPacket.from_packet(decode_packet(data, declared), 1, number))
    writer.close()
    path = f"/api/sessions/{session_id}/source-calibration"
    places = bench_places().tolist()
    found = therapist.get(f"/api/sessions/{session_id}/source-stops").json()
    assert (found["source"], found["sensor"], len(found["stops"])) == ("pelvis", "sternum", len(places))
    for stop, place in zip(found["stops"], places, strict=True):
        # Coils as described are good enough to recognise a place.
        assert np.linalg.norm(np.subtract(stop["position_m"], place)) < 0.07
        assert min(stop["pulses"]) >= 3
    wanted = {"name": "Belt", "serial": "S-9", "positions_m": places}
    assert patient.post(path, json=wanted).status_code == 403
    few = therapist.post(path, json=wanted | {"positions_m": places[:-1]})
    assert (few.status_code, few.json()["code"]) == (422, "invalid_input")
    assert f"at {len(places)} places" in few.json()["message"]
    mirrored = therapist.post(path, json=wanted | {"positions_m": [[x, -y, z] for x, y, z in places]})
    assert "iron" in mirrored.json()["message"]
    answer = therapist.post(path, json=wanted | {"positions_m": [*places[:-1], None]})
    assert answer.status_code == 201, answer.text
    kept = answer.json()
    assert (kept["method"], kept["session_id"], kept["found"]["places"]) == ("session", session_id, 13)
    assert 0.002 <= kept["gain_sigma"] < 0.01
    check_coils(kept, measured)


@pytest.mark.slow
def test_the_command_line_finds_the_same_coils(
    bench: tuple[RelativePatient, list[bytes]], tmp_path: Path, therapist: Any
) -> None:
    measured, sent = bench
    log, table, out = tmp_path / "bench.tml", tmp_path / "places.csv", tmp_path / "S-9.json"
    hello = measured.hello("-").model_dump(exclude={"type", "ticket"})
    log.write_bytes(log_head(hello) + b"".join(log_entry(data) for data in sent))
    run = CliRunner()
    listed = run.invoke(cli, ["calibrate-source", str(log)], catch_exceptions=False)
    assert listed.output.count("pulses  about") == len(bench_places())
    lines = ["x_m,y_m,z_m", *(",".join(str(value) for value in place) for place in bench_places())]
    table.write_text("\n".join(lines))
    words = ["calibrate-source", str(log), "--places", str(table), "--serial", "S-9", "--out", str(out)]
    done = run.invoke(cli, words, catch_exceptions=False)
    assert "field known to 0." in done.output
    written = json.loads(out.read_text())
    check_coils(written, measured)
    # What it wrote is what the service takes.
    assert therapist.post("/api/magnetic-sources", json=written).json()["method"] == "file"
    table.write_text("\n".join([*lines[:3], "0.1,here,0.2"]))
    with pytest.raises(TelemotionError, match="Line 4"):
        run.invoke(cli, words, catch_exceptions=False)


def check_coils(found: dict[str, Any], measured: RelativePatient) -> None:
    for coil, true, made in zip(found["coils"], measured.source.coils, COILS, strict=True):
        assert coil["turns"] == pytest.approx(true.turns, rel=0.015)
        assert np.linalg.norm(np.subtract(coil["centre_m"], true.centre_m)) < 3e-3
        assert set(coil) == set(made)
