"""A walk of hours: its page gets the numbers and the beginning, its strides come in pages."""

import numpy as np
import pytest
from sqlalchemy import Engine

from app.database.unit_of_work import unit_of_work
from app.kinds.walk.schemas import FootholdOut, FootOut, StrideOut, WalkContent
from app.kinds.walk.stored import store_walk
from app.recordings.models import MotionSession, Result
from estimators.pipelines import SessionSetup

STRIDES = 3560
"""Of each foot: two hours, a stride in 2 s."""


def stride(number: int) -> StrideOut:
    numbers = {
        name: float(number)
        for name in StrideOut.model_fields
        if name not in ("number", "bout", "is_counted", "is_initiation", "is_termination", "flags")
    }
    return StrideOut(
        **numbers | {"contact_s": 2.0 * number},
        number=number,
        bout=1,
        is_counted=number > 1,
        is_initiation=number == 1,
        is_termination=False,
        flags=0,
    )


def long_walk() -> WalkContent:
    """Return two feet that each make `STRIDES`, the right one a second later."""
    feet = []
    for side in ("left", "right"):
        later_s = 0.0 if side == "left" else 1.0
        strides = [stride(number + 1) for number in range(STRIDES)]
        for one in strides:
            one.contact_s = (one.contact_s or 0.0) + later_s
        holds = [
            FootholdOut(start_s=2.0 * k, stop_s=2.0 * k + 1, x_m=k, y_m=0, z_m=0, heading_rad=0, sigma_m=0.01)
            for k in range(STRIDES + 1)
        ]
        path = np.zeros((144_000, 2)).tolist()
        feet.append(FootOut(side=side, measures=[], footholds=holds, strides=strides, path_m=path, curves=[]))
    return WalkContent(
        feet=feet, both=[], asymmetry=[], turn_count=0, bout_count=1, reasons=[], has_step_width=False
    )


@pytest.fixture
def session_id(engine: Engine, world) -> str:
    setup = SessionSetup("gait", ("foot_left", "foot_right"), 100.0).to_dict()
    with unit_of_work(engine) as session:
        found = MotionSession(
            clinic_id=world.subjects["therapist"].clinic_id,
            patient_id=world.patient_id,
            state="analysed",
            setup=setup,
            created_by=world.subjects["therapist"].account_id,
        )
        session.add(found)
        session.flush()
        result = Result(
            session_id=found.id,
            kind="offline",
            pipeline="gait",
            pipeline_version="3",
            orientation="foot",
            orientation_version="1",
            setup=setup,
            layout={},
            status="complete",
            progress=1.0,
        )
        session.add(result)
        session.flush()
        found.main_result_id = result.id
        store_walk(session, found.id, result.id, long_walk())
        return found.id


def test_a_long_walk_answers_its_beginning_and_its_strides_in_pages(session_id, therapist) -> None:
    answer = therapist.get(f"/api/sessions/{session_id}/gait")
    assert answer.status_code == 200
    for foot in answer.json()["feet"]:
        assert (foot["stride_count"], foot["counted_count"]) == (STRIDES, STRIDES - 1)
        assert (len(foot["strides"]), len(foot["footholds"])) == (200, 201)
        assert len(foot["path_m"]) <= 5_000
    address, found = f"/api/sessions/{session_id}/gait/strides?limit=200", []
    while address:
        page = therapist.get(address)
        assert len(page.json()) <= 200
        found += [(one["contact_s"], one["side"], one["number"]) for one in page.json()]
        following = page.links.get("next")
        address = following["url"] if following and len(found) < 1_000 else ""
    assert found == sorted(found)
    assert found[:3] == [(2.0, "left", 1), (3.0, "right", 1), (4.0, "left", 2)]
    assert len(set(found)) == len(found) == 1_000


def test_a_page_of_no_walk_is_refused(therapist) -> None:
    assert therapist.get("/api/sessions/nobody/gait/strides").status_code == 404
