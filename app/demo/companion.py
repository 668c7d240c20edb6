"""Runs beside the demonstration's server: makes the history once, tells how to sign in, then streams live forever.

A process of its own, so that simulating a patient takes no time from the service.
"""

import argparse
import asyncio
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Final

import httpx

from app.commands.simulate import Options, stream
from app.database import engine as engines
from app.demo.history import make_history
from app.demo.on_demand import OnDemand
from app.demo.people import PASSWORD, PATIENTS, THERAPIST
from app.errors import TelemotionError
from app.gateway import DeviceStream, ServiceClient
from estimators.simulation import ArmScenario

READY_TIMEOUT_S: Final = 180.0
PAUSE_BETWEEN_SESSIONS_S: Final = 5.0
LIVE_REPETITIONS: Final = 40


async def run(server: str, database_url: str, history_mark: Path | None, with_stream: bool) -> None:
    """Do what the module says.

    Parameters
    ----------
    server : str
    database_url : str
        Of the demonstration, to date its history back.
    history_mark : Path or None
        Make the history and write this file when it is complete; None when it is there.
    with_stream : bool
    """
    leaving = asyncio.create_task(_leave_with_parent(os.getppid()))
    async with asyncio.timeout(READY_TIMEOUT_S):
        await _until_it_answers(server)
    async with ServiceClient(server) as service:
        await service.sign_in(THERAPIST, PASSWORD)
        caseload = (await service.http.get("/api/patients")).json()
        by_name = {(row["given_name"], row["family_name"]): row["id"] for row in caseload}
        patient_ids = {person.email: by_name[(person.given_name, person.family_name)] for person in PATIENTS}
        if history_mark is not None:
            engine = engines.create_from_url(database_url)
            try:
                await make_history(service, engine, patient_ids, _say)
            finally:
                engine.dispose()
            await asyncio.to_thread(history_mark.touch)
        _say(_welcome(server, with_stream))
        if with_stream:
            await _stream_forever(service, patient_ids)
    leaving.cancel()


async def _leave_with_parent(parent: int) -> None:
    """End when the server's process is gone, however it ended."""
    while os.getppid() == parent:  # noqa: ASYNC110 - the end of another process sets no event
        await asyncio.sleep(1.0)
    os._exit(0)


async def _until_it_answers(server: str) -> None:
    async with httpx.AsyncClient(base_url=server, trust_env=False) as probe:
        while True:
            try:
                if (await probe.get("/api/health")).is_success:
                    return
            except httpx.TransportError:
                pass
            await asyncio.sleep(0.2)


async def _stream_forever(service: ServiceClient, patient_ids: dict[str, str]) -> None:
    person = PATIENTS[0]
    prescriptions = (
        await service.http.get(f"/api/patients/{patient_ids[person.email]}/prescriptions")
    ).json()
    chosen = prescriptions[0] if prescriptions else None
    options = Options(
        server="",
        email="",
        password="",
        patient_id=patient_ids[person.email],
        exercise_id=chosen["exercise_id"] if chosen else None,
        prescription_id=chosen["id"] if chosen else None,
        movement=person.movement,
        arms=person.affected_side,
        repetitions=LIVE_REPETITIONS,
        patient_kind="moderate_stroke",
        progress=1.0,
        speed=1.0,
        loss_percent=0.5,
    )

    async def perform(device: DeviceStream, scenario: ArmScenario, session_id: str) -> None:
        own_until_s = scenario.schedule.n_pose_s
        await OnDemand(device, scenario).run(service, session_id, own_until_s)

    number, signed_out = 0, False
    while True:
        try:
            if signed_out:
                await service.sign_in(THERAPIST, PASSWORD)
                signed_out = False
            await stream(service, replace(options, seed=1000 + number), _quiet, perform)
        except TelemotionError as error:
            # Signed out over night, or somebody closed the session in the browser: begin a new one.
            signed_out = error.status == 401
        number += 1
        await asyncio.sleep(PAUSE_BETWEEN_SESSIONS_S)


def _welcome(server: str, with_stream: bool) -> str:
    lines = [
        "",
        f"  Telemotion demonstration:  {server}",
        "",
        f"    therapist   {THERAPIST}   password  {PASSWORD}",
        f"    patient     {PATIENTS[0].email}       password  {PASSWORD}",
        "",
    ]
    if with_stream:
        person = PATIENTS[0]
        lines.append(
            f"  {person.given_name} {person.family_name} streams live now: sign in and open her row."
        )
    lines.append("  Ctrl-C stops it. Everything here is invented; never use it with real patients.")
    return "\n".join([*lines, ""])


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def _quiet(text: str) -> None:
    """Say nothing: the live patient's steps are seen in the browser."""


def main() -> None:
    """Run until told to stop."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--database-url", required=True)
    parser.add_argument("--history-mark", type=Path)
    parser.add_argument("--stream", action="store_true")
    words = parser.parse_args()
    try:
        asyncio.run(run(words.server, words.database_url, words.history_mark, words.stream))
    except KeyboardInterrupt:
        sys.exit(0)


if __name__ == "__main__":
    main()
