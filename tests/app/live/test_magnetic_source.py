"""A magnetic source over the real socket: asked for pulses, cut off, switched off, wrongly numbered."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np
import pytest

from app.commands.simulate_relative import RelativeOptions, stream
from app.errors import SafetyUnconfirmed, TelemotionError
from app.gateway import ServiceClient
from app.gateway.relative_patient import RelativeFaults, RelativePatient
from app.gateway.source import SourceControl
from app.ingest.messages import ActuateMessage, ActuationPlanMessage
from estimators.magnetic import RelativeFlag

SignedIn = Callable[..., Awaitable[ServiceClient]]
PLAN = ActuationPlanMessage(
    coils=[1, 2, 3],
    current_a=1.3,
    on_ticks=4,
    off_ticks=3,
    cycle_ticks=60,
    after_s=0.5,
    current_limit_a=1.5,
)


def asked(number: int, coil: int = 2, current_a: float = 1.3, at_us: int = 0) -> ActuateMessage:
    return ActuateMessage(
        number=number,
        coil=coil,
        current_a=current_a,
        on_ticks=3,
        not_before_us=at_us,
        not_after_us=at_us + 400_000,
    )


class TestSourceControl:
    def ticks(self, control: SourceControl, first: int, stop: int) -> list[int]:
        return [control.tick(10_000.0 * k)[0] for k in range(first, stop)]

    def test_nothing_is_fired_before_a_plan_came(self) -> None:
        control = SourceControl(10_000.0)
        control.hear(asked(1))
        assert self.ticks(control, 0, 300) == [0] * 300

    def test_one_pulse_as_asked_and_no_repetition(self) -> None:
        control = SourceControl(10_000.0)
        control.hear(PLAN)
        control.hear(asked(1, at_us=20_000))
        assert self.ticks(control, 0, 8) == [0, 0, 2, 2, 2, 0, 0, 0]
        control.hear(asked(1, at_us=20_000))
        assert self.ticks(control, 8, 12) == [0] * 4
        control.hear(asked(2, coil=1, current_a=9.0, at_us=0))
        assert control.tick(120_000.0) == (1, 1.5), "the limit of the source holds"
        control.hear(asked(3, coil=3, at_us=0))
        assert self.ticks(control, 13, 17) == [1, 1, 0, 0], "asked for while one was on: forgotten"
        control.hear(asked(4, at_us=0))
        assert self.ticks(control, 50, 52) == [0, 0], "too late"
        assert (control.account.asked, control.account.too_late, control.account.while_on) == (2, 1, 1)

    def test_rounds_by_the_plan_while_nobody_is_heard_and_an_end_of_them(self) -> None:
        control = SourceControl(10_000.0)
        control.hear(PLAN)
        done = self.ticks(control, 0, 140)
        assert not any(done[:50])
        first = done[50:110]
        assert first[:18] == [1] * 4 + [0] * 3 + [2] * 4 + [0] * 3 + [3] * 4
        assert not any(first[18:])
        assert done[110:114] == [1] * 4
        control.hear(object())
        # The pulse that is on ends; then the service is waited for again.
        assert not any(self.ticks(control, 140, 185)[4:])


@pytest.mark.slow
def test_the_source_does_what_is_asked_and_a_cut_link_does_no_harm(signed_in: SignedIn, world: Any) -> None:
    async def run() -> None:
        async with await signed_in() as service:
            with pytest.raises((SafetyUnconfirmed, TelemotionError), match="pacemaker"):
                await stream(service, RelativeOptions("", "", "", world.patient_id, duration_s=10.0), print)
            options = RelativeOptions(
                "",
                "",
                "",
                world.patient_id,
                duration_s=12.0,
                no_implants=True,
                breaks_s=((9.0, 10.0),),
            )
            session_id, report, patient = await stream(service, options, print)
            account = patient.control.account
            assert account.asked >= 5
            assert report.connections == 2
            assert report.unacknowledged == 0
            use = await service.source_use(session_id)
            assert use.pulse_count == account.asked + account.by_plan
            assert use.on_time_s == pytest.approx(sum(use.length_s), abs=0.01)
            assert use.charge_as == pytest.approx(1.3 * use.on_time_s, rel=1e-3)
            # The start took long pulses of each coil in turn.
            assert use.coil[:3] == [1, 2, 3]
            found = await service.session(session_id)
            assert found.results[0].orientation == "relative_pose"
            assert [result.kind for result in found.results].count("offline") == 1
            block = await service.http.get(f"/api/sessions/{session_id}/frames")
            here, columns = read_block(block.content, found)
            truth = patient.scene.position_m
            rows = slice(840, int(8.8 * 120))
            place = np.stack([here[rows, columns.index(f"sternum_{axis}_m")] for axis in "xyz"], axis=1)
            error = np.linalg.norm(place - truth[rows], axis=1)
            assert np.sqrt(np.mean(error**2)) < 0.03

    asyncio.run(run())


@pytest.mark.slow
def test_a_source_switched_off_is_told_and_the_session_goes_on(signed_in: SignedIn, world: Any) -> None:
    async def run() -> None:
        async with await signed_in() as service:
            options = RelativeOptions(
                "",
                "",
                "",
                world.patient_id,
                duration_s=13.0,
                no_implants=True,
                faults=RelativeFaults(silent_s=(6.0, 30.0)),
            )
            session_id, _, _ = await stream(service, options, print)
            found = await service.session(session_id)
            told = [(event.kind, event.placement) for event in found.events]
            assert ("source_trouble", "sternum") in told
            trouble = next(event for event in found.events if event.kind == "source_trouble")
            assert 6.0 < trouble.time_s < 10.0
            assert "switched on" in trouble.text
            use = await service.source_use(session_id)
            assert use.inertial_only_s["sternum"] > 0.5
            state = np.array(use.state["sternum"])
            assert (state & RelativeFlag.MISSING_PULSE).any()
            assert found.state == "analysed"

    asyncio.run(run())


def test_what_is_simulated_obeys_and_its_faults_are_real() -> None:
    patient = RelativePatient("feet", 4.0, faults=RelativeFaults(dead_s=(2.0, 3.0)))
    assert patient.placements == ("foot_left", "foot_right")
    patient.control.hear(PLAN)
    packets = list(patient.deliveries())
    assert len(packets) == 4 * 120 // 5
    assert patient.control.account.by_plan >= 6


def read_block(data: bytes, session: Any) -> tuple[Any, list[str]]:
    from app.live.blocks import column_names
    from app.recordings.chunks import layout_from_dict

    columns = column_names(layout_from_dict(session.layout.model_dump()))
    ticks, width = np.frombuffer(data, "<u4", 2, offset=4).tolist()
    return np.frombuffer(data, "<f4", ticks * width, offset=40).reshape(ticks, width), columns
