"""Runs beside the demonstration's server: makes the history once, or streams a live patient for ever.

Processes of their own, so that simulating patients takes no time from the service.
"""

import argparse
import asyncio
import logging
import os
import sys
import time
from collections.abc import Awaitable, Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import httpx

from app.commands.simulation.arm import Options, stream
from app.database import engine as engines
from app.demo.history import make_history
from app.demo.on_demand import OnDemand
from app.demo.people import PASSWORD, PATIENTS, THERAPIST
from app.edge.demonstration import HistoryProgress
from app.gateway import DeviceStream, ServiceClient
from estimators.simulation import ArmScenario

logger = logging.getLogger("telemotion.demo")

PAUSE_BETWEEN_SESSIONS_S: Final = 5.0
LIVE_REPETITIONS: Final = 40
FIRST_REPETITIONS: Final = 4
"""Until there is a template to compare with, a session is short, so that the next one has it."""
HISTORY_NICENESS: Final = 10


async def for_ever(server: str, perform: Callable[[ServiceClient], Awaitable[Any]], pause_s: float) -> None:
    """Sign in and perform again and again, whatever happens.

    The service may be stopped and come back, a sign-in ends over night, and somebody may close the session in the
    browser: each time a new client signs in and begins again.

    Parameters
    ----------
    perform : async callable(service)
        Signed in as the therapist.
    pause_s : float
        Between two performances.
    """
    reported = ""
    while True:
        try:
            await signed_in(server, perform)
            reported = ""
        except Exception as error:
            # Once for each kind of trouble: a service that is away for the night must not fill a screen.
            if type(error).__name__ != reported:
                logger.warning("the simulated patient begins again after: %s", error)
                reported = type(error).__name__
        await asyncio.sleep(pause_s)


async def signed_in(server: str, perform: Callable[[ServiceClient], Awaitable[Any]]) -> None:
    """Wait until the service answers, sign in as the therapist, and perform once."""
    await until_it_answers(server)
    async with ServiceClient(server) as service:
        await service.sign_in(THERAPIST, PASSWORD)
        await perform(service)


async def until_it_answers(server: str) -> None:
    """Return when the service answers, however long that takes."""
    async with httpx.AsyncClient(base_url=server, trust_env=False) as probe:
        while True:
            try:
                if (await probe.get("/api/health")).is_success:
                    return
            except httpx.TransportError:
                pass
            await asyncio.sleep(0.2)


async def patients_of(service: ServiceClient) -> dict[str, str]:
    """Return the identifiers of the demonstration's patients by e-mail."""
    patients = await service.every("/api/patients")
    by_name = {(row["given_name"], row["family_name"]): row["id"] for row in patients}
    return {person.email: by_name[(person.given_name, person.family_name)] for person in PATIENTS}


class LivePatient:
    """Streams one session after the other.

    Parameters
    ----------
    streamed : callable()
        Called once, when frames of the first session come.
    """

    def __init__(self, streamed: Callable[[], None]) -> None:
        self._streamed: Callable[[], None] | None = streamed
        self._number = 0

    async def stream_one(self, service: ServiceClient) -> None:
        """Stream a session to its end."""
        person = PATIENTS[0]
        patient_id = (await patients_of(service))[person.email]
        found = (await service.http.get(f"/api/patients/{patient_id}/prescriptions")).raise_for_status()
        prescriptions = found.json()
        chosen = prescriptions[0] if prescriptions else None
        options = Options(
            patient_id=patient_id,
            exercise_id=chosen["exercise_id"] if chosen else None,
            prescription_id=chosen["id"] if chosen else None,
            movement=person.movement,
            arms=person.affected_side,
            repetitions=LIVE_REPETITIONS if chosen else FIRST_REPETITIONS,
            patient_kind="moderate_stroke",
            progress=1.0,
            speed=1.0,
            loss_percent=0.5,
        )
        self._number += 1
        await stream(service, replace(options, seed=1000 + self._number), _quiet, self._beside(service))

    def _beside(self, service: ServiceClient) -> Callable[[DeviceStream, ArmScenario, str], Any]:
        async def perform(device: DeviceStream, scenario: ArmScenario, session_id: str) -> None:
            if self._streamed is not None:
                await service.wait_for_state(session_id, "calibrating", "ready", "recording", timeout_s=600.0)
                self._streamed()
                self._streamed = None
            await OnDemand(device, scenario).run(service, session_id, scenario.schedule.n_pose_s)

        return perform


async def past_sessions(server: str, folder: Path, database_url: str, say: Callable[[str], None]) -> None:
    """Make what is missing of the history."""
    progress = HistoryProgress.of(folder)
    if progress is None:
        return
    engine = engines.create_from_url(database_url)

    async def make(service: ServiceClient) -> None:
        await make_history(service, engine, await patients_of(service), progress, say)

    try:
        while not progress.is_complete:
            try:
                await signed_in(server, make)
            except Exception as error:
                logger.warning("making past sessions goes on after: %s", error)
                await asyncio.sleep(PAUSE_BETWEEN_SESSIONS_S)
    finally:
        engine.dispose()


async def _beside_parent(work: Awaitable[None]) -> None:
    leaving = asyncio.create_task(_leave_with_parent(os.getppid()))
    await work
    leaving.cancel()


async def _leave_with_parent(parent: int) -> None:
    """End when the server's process is gone, however it ended."""
    while os.getppid() == parent:  # noqa: ASYNC110 - the end of another process sets no event
        await asyncio.sleep(1.0)
    os._exit(0)


def _quiet(text: str) -> None:
    """Say nothing: the live patient's steps are seen in the browser."""


def main() -> None:
    """Run until asked to stop."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--started-s", type=float, default=time.time())
    parser.add_argument("--stream", action="store_true")
    parser.add_argument("--history", type=Path)
    parser.add_argument("--database-url")
    words = parser.parse_args()

    def say(text: str) -> None:
        sys.stdout.write(f"  {text} after {time.time() - words.started_s:.0f} s\n")
        sys.stdout.flush()

    if words.stream:
        patient = LivePatient(lambda: say("live patient seen"))
        work = for_ever(words.server, patient.stream_one, PAUSE_BETWEEN_SESSIONS_S)
    else:
        os.nice(HISTORY_NICENESS)
        work = past_sessions(words.server, words.history, words.database_url, say)
    try:
        asyncio.run(_beside_parent(work))
    except KeyboardInterrupt:
        sys.exit(0)


if __name__ == "__main__":
    main()
