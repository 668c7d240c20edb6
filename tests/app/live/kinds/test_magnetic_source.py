"""A magnetic source over the real socket: asked for pulses, cut off, switched off, wrongly numbered."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from app.commands.simulation.relative import RelativeOptions, stream
from app.errors import SafetyUnconfirmed, TelemotionError
from app.gateway import ServiceClient
from app.gateway.relative_patient import RelativeFaults, RelativePatient
from app.gateway.source import SourceControl
from app.network.messages import AcknowledgeMessage, ActuateMessage, ActuationPlanMessage, ErrorMessage
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

    def test_a_pulse_asked_for_may_follow_the_plans_without_a_pause(self) -> None:
        """Of the same coil they are one in the samples, though two in the account."""
        control = SourceControl(10_000.0)
        control.hear(PLAN)
        assert self.ticks(control, 0, 114)[110:] == [1] * 4
        done = control.account.by_plan
        control.hear(asked(1, coil=1, at_us=1_140_000))
        assert self.ticks(control, 114, 118)[0] == 1
        assert (control.account.asked, control.account.by_plan) == (1, done)

    def test_the_end_of_the_session_takes_the_plan_back_at_once(self) -> None:
        control = SourceControl(10_000.0)
        control.hear(PLAN)
        control.hear(asked(1))
        assert control.tick(0.0)[0] == 2
        control.hear(
            AcknowledgeMessage(session_id="s", acknowledged=1, highest=1, missing=[], state="closing")
        )
        control.hear(asked(2))
        assert self.ticks(control, 1, 5000) == [0] * 4999

    def test_a_refusal_for_want_of_the_word_takes_the_plan_back_at_once(self) -> None:
        control = SourceControl(10_000.0)
        control.hear(PLAN)
        assert any(self.ticks(control, 0, 400))
        control.hear(ErrorMessage(code=SafetyUnconfirmed.code, message="Not confirmed.", closing=True))
        assert not any(self.ticks(control, 400, 5000))

    def test_a_plan_ends_when_nobody_was_heard_for_ten_minutes(self) -> None:
        control = SourceControl(10_000.0)
        control.hear(PLAN)
        fired = np.array(self.ticks(control, 0, 62_000))
        assert fired[59_000:59_900].any()
        assert not fired[60_010:].any()

    def test_wrong_coils_endless_pulses_and_currents_of_any_sign_are_bounded(self) -> None:
        control = SourceControl(10_000.0)
        control.hear(PLAN.model_copy(update={"current_a": -20.0}))
        control.hear(asked(1, coil=7))
        assert not any(self.ticks(control, 0, 10))
        control.hear(asked(2).model_copy(update={"on_ticks": 10**6}))
        assert sum(coil > 0 for coil in self.ticks(control, 10, 60)) == 50
        currents = {control.tick(10_000.0 * k)[1] for k in range(70, 400)}
        assert min(currents) == -1.5
        assert control.account.no_such_coil == 1


@pytest.mark.slow
def test_the_source_does_what_is_asked_and_a_cut_link_does_no_harm(signed_in: SignedIn, world: Any) -> None:
    async def run() -> None:
        async with await signed_in() as service:
            with pytest.raises((SafetyUnconfirmed, TelemotionError), match="pacemaker"):
                await stream(service, RelativeOptions(patient_id=world.patient_id, duration_s=10.0), print)
            options = RelativeOptions(
                patient_id=world.patient_id,
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
            # Where the link returns, the plan's last pulse and the first one asked for may touch: one in the samples.
            fired = account.asked + account.by_plan
            assert fired - (report.connections - 1) <= use.pulse_count <= fired
            assert use.on_time_s == pytest.approx(sum(use.length_s), abs=0.01)
            assert use.charge_as == pytest.approx(1.3 * use.on_time_s, rel=1e-3)
            # The start took long pulses of each coil in turn; where one was asked for too late it begins again.
            assert "123" in "".join(str(coil) for coil in use.coil[:6])
            found = await service.session(session_id)
            made = {result.kind: result for result in found.results}
            assert (made["live"].orientation, made["offline"].orientation) == (
                "relative_pose",
                "relative_pose_smoothed",
            )
            # What is replayed is smoothed; the live result stays beside it.
            assert found.main_result_id == made["offline"].id
            truth, rows = patient.scene.position_m, slice(840, int(8.8 * 120))
            errors = []
            for kind in ("live", "offline"):
                block = await service.http.get(
                    f"/api/sessions/{session_id}/frames", params={"result_id": made[kind].id}
                )
                here, columns = read_block(block.content, found)
                place = np.stack([here[rows, columns.index(f"sternum_{axis}_m")] for axis in "xyz"], axis=1)
                errors.append(np.sqrt(np.mean(np.sum((place - truth[rows]) ** 2, axis=1))))
            live, smoothed = errors
            assert smoothed < 0.8 * live < 0.024

    asyncio.run(run())


@dataclass(frozen=True)
class Wrong:
    """A fault, how long it is watched, what the therapist is told, and whether there was a pose before it."""

    faults: RelativeFaults
    duration_s: float
    flag: RelativeFlag
    words: str
    from_s: float = 0.0


WRONG = {
    "source off, then on again": Wrong(
        RelativeFaults(silent_s=(5.0, 9.0)), 14.0, RelativeFlag.MISSING_PULSE, "switched on", 5.0
    ),
    "coils exchanged": Wrong(
        RelativeFaults(exchanged_s=(0.0, 99.0)), 5.0, RelativeFlag.FAULT, "numbers of the coils"
    ),
    "source and sensor exchanged": Wrong(
        RelativeFaults(modules_exchanged=True), 6.0, RelativeFlag.FAULT, "which module is the source"
    ),
    "pulses missing": Wrong(
        RelativeFaults(lost_share=0.9, lost_from_s=3.5), 9.0, RelativeFlag.MISSING_PULSE, "do not come", 3.5
    ),
    "magnetometer saturated": Wrong(
        RelativeFaults(beside_coil_s=(4.0, 99.0)), 8.0, RelativeFlag.SATURATED, "too close to a coil", 4.0
    ),
    # At a level of its own, which the hello tells.
    "weaker magnetometer saturated": Wrong(
        RelativeFaults(beside_coil_s=(4.0, 99.0), full_scale_t=1e-4),
        8.0,
        RelativeFlag.SATURATED,
        "too close to a coil",
        4.0,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", WRONG)
def test_what_goes_wrong_is_told_and_the_session_goes_on(signed_in: SignedIn, world: Any, name: str) -> None:
    wrong = WRONG[name]

    async def run() -> None:
        async with await signed_in() as service:
            options = RelativeOptions(
                patient_id=world.patient_id,
                duration_s=wrong.duration_s,
                speed=2.0,
                no_implants=True,
                faults=wrong.faults,
            )
            session_id, report, _ = await stream(service, options, print)
            assert report.unacknowledged == 0
            found = await service.session(session_id)
            assert found.state == "analysed"
            trouble = next(event for event in found.events if event.kind == "source_trouble")
            assert trouble.placement == "sternum"
            assert wrong.from_s < trouble.time_s < wrong.duration_s
            assert wrong.words in trouble.text
            live = next(result for result in found.results if result.kind == "live")
            block = await service.http.get(
                f"/api/sessions/{session_id}/frames", params={"result_id": live.id}
            )
            here, columns = read_block(block.content, found)
            assert len(here) == pytest.approx(120 * wrong.duration_s, abs=10)
            time_s = np.arange(len(here)) / 120.0
            state = here[:, columns.index("sternum_state")].astype(int)
            assert (state[time_s > wrong.from_s] & wrong.flag).any()
            sigma = here[:, columns.index("sternum_distance_sigma_m")]
            if not wrong.from_s:
                assert np.isnan(sigma).all(), "no pose is better than a wrong one"
                return
            # Live, the first pulses come when the network brings them.
            assert not state[(time_s > 3.4) & (time_s < wrong.from_s)].any()
            alone = (state & RelativeFlag.INERTIAL_ONLY) > 0
            last = sigma[time_s < min(wrong.faults.silent_s[1], wrong.duration_s)][-1]
            assert last > 2.0 * sigma[(time_s > 3.4) & (time_s < wrong.from_s)].max()
            if not np.isfinite(wrong.faults.silent_s[0]):
                return
            assert alone[(time_s > 7.5) & (time_s < 9.0)].all()
            told = [event for event in found.events if event.kind in {"source_trouble", "source_sound"}]
            assert told[-1].kind == "source_sound"
            assert 9.0 < told[-1].time_s < 13.5
            assert not (state[time_s > told[-1].time_s] & wrong.flag).any()
            assert np.nanmax(sigma[time_s > told[-1].time_s]) < 0.1

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
    from app.recordings.signals.chunks import layout_from_dict

    columns = column_names(layout_from_dict(session.layout.model_dump()))
    ticks, width = np.frombuffer(data, "<u4", 2, offset=4).tolist()
    return np.frombuffer(data, "<f4", ticks * width, offset=40).reshape(ticks, width), columns
