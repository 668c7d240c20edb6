"""A source is stopped at once when the word that it is safe is taken back; one that fires unasked is told."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from app.errors import TelemotionError
from app.gateway import GatewayClient, ServiceClient
from app.gateway.relative_patient import RelativePatient
from app.gateway.source import SourceControl
from app.kinds.magnetic.schemas import MagneticSafetyIn
from app.live.checks.unexpected_emission import GRACE_S, UnexpectedEmission
from app.live.session.actuation import Actuation
from app.live.session.opening import setup_for
from app.network.declaration import Declaration
from app.network.messages import ActuateMessage, ActuationPlanMessage
from app.recordings.schemas import SessionIn
from estimators.magnetic import coil_state
from estimators.pipelines import RelativePosePipeline, SessionSetup
from tests.patience import PATIENCE_S

SignedIn = Callable[..., Awaitable[ServiceClient]]
PAIR = ("pelvis", "sternum")
PLAN = ActuationPlanMessage(
    coils=[1, 2, 3],
    current_a=1.3,
    on_ticks=8,
    off_ticks=3,
    cycle_ticks=60,
    after_s=0.5,
    current_limit_a=1.5,
)

ASKED = ActuateMessage(number=1, coil=2, current_a=1.3, on_ticks=8, not_before_us=0, not_after_us=900_000_000)


def test_a_plan_without_coils_ends_the_pulse_that_is_on_and_everything_after_it() -> None:
    control = SourceControl(10_000.0)
    control.hear(PLAN)
    control.hear(ASKED)
    assert [control.tick(10_000.0 * k)[0] for k in range(3)] == [2, 2, 2]
    control.hear(PLAN.model_copy(update={"coils": []}))
    control.hear(ASKED.model_copy(update={"number": 2}))
    # Nor when nothing is heard for ten minutes.
    assert not any(control.tick(10_000.0 * k)[0] for k in range(3, 62_000))
    control.hear(PLAN)
    control.hear(ASKED)
    assert control.tick(620_010_000.0)[0] == 2


def test_orders_that_wait_are_thrown_away_and_a_new_connection_gets_no_coils() -> None:
    async def run() -> None:
        actuation = Actuation(
            RelativePosePipeline(SessionSetup("relative_pose", PAIR, 100.0)), lambda *_: None
        )
        orders = actuation.connect()
        orders.put_nowait(ASKED)
        assert actuation.allow(False)
        assert not actuation.allow(False), "no news"
        (only,) = [orders.get_nowait() for _ in range(orders.qsize())]
        assert isinstance(only, ActuationPlanMessage)
        assert only.coils == []
        again = actuation.connect().get_nowait()
        assert isinstance(again, ActuationPlanMessage)
        assert again.coils == []
        assert actuation.allow(True)
        assert actuation.plan().coils == [1, 2, 3]

    asyncio.run(run())


def ticks(first: int, state: list[float] | None) -> tuple[float, float, NDArray[np.float64] | None]:
    """Return when five ticks began, their step, and the coil states that two sensors sent."""
    if state is None:
        return 0.01 * first, 0.01, None
    states = np.zeros((2, 5))
    states[0, : len(state)] = state
    states[1] = np.nan
    return 0.01 * first, 0.01, states


class TestUnexpectedEmission:
    def watched(self) -> tuple[UnexpectedEmission, list[tuple[str, float, str, str]]]:
        told: list[tuple[str, float, str, str]] = []
        return UnexpectedEmission(lambda *event: told.append(event)), told

    def test_a_session_without_a_source_says_once_that_one_fires(self) -> None:
        stray, told = self.watched()
        stray.add(*ticks(0, None), PAIR, None)
        stray.add(*ticks(5, [0.0] * 5), PAIR, None)
        assert told == [], "zeros are what sensors without coils send"
        on = float(coil_state(2, 1.3))
        for first in (10, 15, 5000):
            stray.add(*ticks(first, [0.0, on, on]), PAIR, None)
        ((kind, at_s, placement, words),) = told
        assert (kind, at_s, placement) == ("source_unasked", pytest.approx(0.11), "pelvis")
        assert "nobody was asked about implants" in words

    def test_a_stopped_source_that_goes_on_is_told_after_its_last_pulse_had_time_to_end(self) -> None:
        stray, told = self.watched()
        on = [float(coil_state(1, 1.3))] * 5
        for stopped in (1, 2):
            stray.add(*ticks(0, on), PAIR, True)
            assert len(told) == stopped - 1
            late = round(GRACE_S * 100)
            stray.add(*ticks(5, on), PAIR, False)
            assert len(told) == stopped - 1
            stray.add(*ticks(late, on), PAIR, False)
            stray.add(*ticks(late + 10, on), PAIR, False)
            stray.add(*ticks(late + 20, on), PAIR, False)
            assert len(told) == stopped
            assert "Switch it off by hand" in told[-1][3]


@pytest.mark.parametrize(
    ("pipeline", "given", "declared", "used"),
    [
        ("relative_pose", {}, 2e-4, 2e-4),
        ("relative_pose", {}, None, None),
        ("relative_pose", {"full_scale_t": 5e-4}, 2e-4, 5e-4),
        ("arm", {}, 2e-4, None),
    ],
)
def test_the_device_tells_where_its_magnetometer_ends(
    pipeline: str, given: dict[str, Any], declared: float | None, used: float | None
) -> None:
    setup = SessionSetup(pipeline, PAIR, 100.0, orientation_parameters=given)
    found = setup_for(
        setup, Declaration(PAIR, 120.0, full_scales={} if declared is None else {"magnetometer": declared})
    )
    assert found.orientation_parameters.get("full_scale_t") == used
    assert found.rate_hz == 120.0
    if pipeline == "relative_pose":
        (one,) = RelativePosePipeline(found).filters.values()
        assert one.parameters["full_scale_t"] == pytest.approx(0.99 * (used or 8e-4))


@pytest.mark.slow
def test_a_live_source_stops_at_once_and_streams_on(signed_in: SignedIn, world: Any) -> None:
    async def run() -> None:
        async with await signed_in() as service:
            patient = RelativePatient("flexion", 26.0)
            created = await service.create_session(
                SessionIn(
                    patient_id=world.patient_id,
                    pipeline="relative_pose",
                    placements=list(patient.placements),
                    rate_hz=patient.rate_hz,
                    use_mounting=False,
                )
            )
            said = MagneticSafetyIn(patient_has_no_implant=True, people_nearby_have_none=True)
            await service.confirm_no_implants(created.id, said)
            gateway = GatewayClient(
                service.ingest_url,
                lambda: service.ticket(created.id),
                patient.hello,
                pace=2.0,
                heard=patient.control.hear,
            )
            path = f"/api/sessions/{created.id}/magnetic-safety"

            async def therapist() -> int:
                for _ in range(200):
                    if patient.control.account.asked >= 5:
                        break
                    await asyncio.sleep(0.1)
                told = await service.http.delete(path)
                assert told.status_code == 200, told.text
                assert told.json()["confirmed"] is False
                assert told.json()["withdrawn_by"]
                await asyncio.sleep(0.3)
                done = patient.control.account.asked + patient.control.account.by_plan
                with pytest.raises(TelemotionError, match="withdrawn"):
                    await service.ticket(created.id)
                await asyncio.sleep(1.5)
                assert patient.control.account.asked + patient.control.account.by_plan == done
                await service.confirm_no_implants(created.id, said)
                return done

            sending = asyncio.create_task(gateway.run(patient.deliveries()))
            done = await therapist()
            report = await sending
            assert report.unacknowledged == 0
            assert report.connections == 1, "the sensors stream on"
            # Confirmed again while it was live: it goes on within the time of one check.
            assert patient.control.account.asked > done
            await service.wait_for_state(created.id, "analysed", timeout_s=PATIENCE_S)
            kinds = [event.kind for event in (await service.session(created.id)).events]
            assert kinds.count("source_stopped") == kinds.count("source_allowed") == 1
            assert "source_unasked" not in kinds

    asyncio.run(run())
