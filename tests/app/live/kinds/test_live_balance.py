"""A balance test live: marked while it is recorded, analysed when it ends, read as measures with Romberg's ratio."""

import asyncio
from typing import Any

import httpx
import numpy as np
import pytest

from app.errors import InvalidInput
from app.gateway import ServiceClient
from estimators.body import BodyDimensions
from estimators.pipelines import hips_above_ankles_m
from estimators.simulation.standing import Lean, Stance, expected_measures
from tests.app.live.sockets import SignedIn, gateway, new_session
from tests.app.live.standing import TRIALS, new_balance_test, stream_balance_test


async def balance(client: ServiceClient, session_id: str, **query: str) -> dict[str, Any]:
    asked = httpx.QueryParams(query)
    return dict(await client._call("GET", f"/api/sessions/{session_id}/balance?{asked}"))


@pytest.mark.slow
def test_marks_become_trials_with_measures_that_cover_the_truth(signed_in: SignedIn, world: Any) -> None:
    async def run() -> tuple[Any, dict[str, Any], dict[str, Any], Any]:
        async with await signed_in() as client:
            session_id = await new_balance_test(client, world.patient_id)
            person = await stream_balance_test(client, session_id)
            detail = await client.session(session_id)
            of_pelvis = await balance(client, session_id)
            of_chest = await balance(client, session_id, placement="sternum")
            with pytest.raises(InvalidInput):
                await balance(client, session_id, result_id="", placement="head")
            return person, of_pelvis, of_chest, detail

    person, found, of_chest, detail = asyncio.run(run())
    labels = [event.label for event in detail.events if event.label]
    assert labels == [label for name, _ in TRIALS for label in (name, "rest")]
    assert found["placement"] == "pelvis"
    assert of_chest["placement"] == "sternum"
    assert [one["condition"] for one in found["trials"]] == [name for name, _ in TRIALS]
    height_m = found["height_m"]
    assert height_m == pytest.approx(hips_above_ankles_m(BodyDimensions(stature_m=1.75)), abs=0.1)
    for answer, place in ((found, "pelvis"), (of_chest, "sternum")):
        for (name, trial), shown, (start_s, end_s) in zip(
            TRIALS, answer["trials"], person.trials_s, strict=True
        ):
            # The therapist presses when the packet goes out; on a busy machine it shows up to a second later.
            assert shown["start_s"] == pytest.approx(start_s, abs=1.5)
            assert shown["end_s"] == pytest.approx(end_s, abs=1.5)
            measures = {one["measure"]: one for one in shown["measures"]}
            if isinstance(trial, Lean):
                reached = measures["reach_lean"]
                assert abs(reached["value"] - trial.angle_rad) < 3.0 * reached["sigma"] < 0.1
                continue
            assert isinstance(trial, Stance)
            for name, truth in expected_measures(trial, person.height_m[place], height_m).items():
                # A variance from few sways is skewed: its logarithm is not.
                value, sigma = measures[name]["value"], measures[name]["sigma"]
                assert abs(np.log(value / truth)) < 4.0 * sigma / value, (place, name)
            assert len(shown["path_m"]) == pytest.approx(30 * 20, abs=60)
            assert shown["ellipse"]["long_m"] > shown["ellipse"]["short_m"] > 0.0
    (romberg,) = found["romberg"]
    assert romberg["surface"] == "firm"
    speed = next(one for one in romberg["measures"] if one["measure"] == "sway_speed")
    assert speed["value"] > 1.0 + 2.0 * speed["sigma"]


@pytest.mark.slow
def test_a_mark_of_another_kind_is_refused(signed_in: SignedIn, world: Any, stream: Any) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            async with gateway(client, session_id, stream):
                with pytest.raises(InvalidInput):
                    await client.steer(session_id, "mark", {"label": "eyes_open_firm"})
                await client.steer(session_id, "mark", {"text": "a note"})

    asyncio.run(run())
