"""The REST side of a gateway: sign in or show a device token, create and steer a session."""

import asyncio
from types import TracebackType
from typing import Any, Self
from urllib.parse import urlsplit

import httpx

from app.accounts.schemas import Me, TicketOut
from app.errors import (
    Conflict,
    InvalidInput,
    NotAllowed,
    NotFound,
    SignInRequired,
    TelemotionError,
    Unavailable,
)
from app.kinds.magnetic.schemas import MagneticSafetyIn, MagneticSafetyOut, SourceUseOut
from app.live.calibration.messages import CalibrationMessage
from app.live.messages import StateMessage
from app.recordings.schemas import JobOut, SessionDetail, SessionIn

_BY_STATUS: dict[int, type[TelemotionError]] = {
    error.status: error
    for error in (SignInRequired, NotAllowed, NotFound, Conflict, InvalidInput, Unavailable)
}


class ServiceClient:
    """Talks to one service as one account or device; use it in an `async with` statement.

    Parameters
    ----------
    server : str
        Address such as `https://motion.example.org`, or `https://example.org/telemotion` behind a proxy that gives the
        service a path of its own.
    device_token : str, optional
        Instead of signing in.
    """

    def __init__(self, server: str, device_token: str | None = None) -> None:
        parts = urlsplit(server)
        if parts.scheme not in {"http", "https"} or not parts.netloc:
            raise InvalidInput("The server's address must begin with http:// or https://.")
        origin = f"{parts.scheme}://{parts.netloc}"
        self.server = origin + parts.path.rstrip("/")
        headers = {"Origin": origin}
        if device_token:
            headers["Authorization"] = f"Bearer {device_token}"
        self.http = httpx.AsyncClient(base_url=self.server, headers=headers, timeout=30.0, trust_env=False)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.http.aclose()

    @property
    def ingest_url(self) -> str:
        """Address of the gateway socket."""
        return self.server.replace("http", "ws", 1) + "/ws/ingest"

    async def sign_in(self, email: str, password: str) -> Me:
        """Sign in with e-mail and password; the cookie and the CSRF token are stored.

        Raises
        ------
        SignInRequired
            Wrong e-mail or password.
        """
        me = Me.model_validate(
            await self._call("POST", "/api/sign-in", {"email": email, "password": password})
        )
        self.http.headers["X-CSRF-Token"] = me.csrf_token
        return me

    async def create_session(self, session: SessionIn) -> SessionDetail:
        """Create a session."""
        return SessionDetail.model_validate(
            await self._call("POST", "/api/sessions", session.model_dump(mode="json"))
        )

    async def session(self, session_id: str) -> SessionDetail:
        """Get a session with its results and events."""
        return SessionDetail.model_validate(await self._call("GET", f"/api/sessions/{session_id}"))

    async def ticket(self, session_id: str, purpose: str = "ingest") -> str:
        """Get a one-use right to open a socket."""
        content = await self._call("POST", f"/api/sessions/{session_id}/ticket", {"purpose": purpose})
        return TicketOut.model_validate(content).ticket

    async def confirm_no_implants(self, session_id: str, said: MagneticSafetyIn) -> MagneticSafetyOut:
        """Say that neither the patient nor people close by wear an implant that a magnetic source disturbs."""
        content = await self._call("POST", f"/api/sessions/{session_id}/magnetic-safety", said.model_dump())
        return MagneticSafetyOut.model_validate(content)

    async def source_use(self, session_id: str) -> SourceUseOut:
        """Get what the magnetic source of a session did."""
        return SourceUseOut.model_validate(await self._call("GET", f"/api/sessions/{session_id}/source-use"))

    async def state(self, session_id: str) -> StateMessage:
        """Get the state of a session."""
        return StateMessage.model_validate(await self._call("GET", f"/api/sessions/{session_id}/state"))

    async def steer(self, session_id: str, action: str, body: dict[str, Any] | None = None) -> StateMessage:
        """`calibrate`, `record`, `stop`, `mark`, `close` or `reopen`."""
        return StateMessage.model_validate(
            await self._call("POST", f"/api/sessions/{session_id}/{action}", body)
        )

    async def calibration(
        self, session_id: str, action: str, body: dict[str, Any] | None = None
    ) -> CalibrationMessage:
        """`start` (with `kind`), `next` or `cancel` a guided calibration."""
        return CalibrationMessage.model_validate(
            await self._call("POST", f"/api/sessions/{session_id}/calibration/{action}", body)
        )

    async def calibration_state(self, session_id: str) -> CalibrationMessage | None:
        """Get the newest message of a guided calibration."""
        found = await self._call("GET", f"/api/sessions/{session_id}/calibration")
        return None if found is None else CalibrationMessage.model_validate(found)

    async def wait_for_state(self, session_id: str, *states: str, timeout_s: float = 60.0) -> StateMessage:
        """Wait until the session has one of the states.

        Raises
        ------
        Conflict
            It has failed, or the time is over; the message says the last state and its reason.
        """
        deadline = asyncio.get_running_loop().time() + timeout_s
        while True:
            state = await self.state(session_id)
            if state.state in states:
                return state
            if state.state == "failed" or asyncio.get_running_loop().time() > deadline:
                raise Conflict(
                    f"The session is {state.state} instead of {' or '.join(states)}: {state.reason}"
                    f" {state.calibration_hint}".strip()
                )
            await asyncio.sleep(0.2)

    async def jobs(self, session_id: str) -> list[JobOut]:
        """Get the newest long tasks of a session, newest first."""
        return [
            JobOut.model_validate(job) for job in await self._call("GET", f"/api/sessions/{session_id}/jobs")
        ]

    async def every(self, path: str) -> list[dict[str, Any]]:
        """Get a whole list, page after page.

        Parameters
        ----------
        path : str
            Of the list, with its query.
        """
        rows: list[dict[str, Any]] = []
        following: str | None = path
        while following is not None:
            response = await self._answer("GET", following)
            rows += response.json()
            following = response.links.get("next", {}).get("url")
        return rows

    async def _call(self, method: str, path: str, body: dict[str, Any] | None = None) -> Any:
        return (await self._answer(method, path, body)).json()

    async def _answer(self, method: str, path: str, body: dict[str, Any] | None = None) -> httpx.Response:
        try:
            response = await self.http.request(method, path, json=body)
        except httpx.TransportError as error:
            raise Unavailable(f"{self.server} cannot be reached: {type(error).__name__}.") from error
        if response.is_success:
            return response
        try:
            content = response.json()
            message, details = str(content["message"]), dict(content.get("details") or {})
        except (ValueError, KeyError, TypeError):
            message, details = f"{path} answered {response.status_code}.", {}
        raise _BY_STATUS.get(response.status_code, TelemotionError)(message, **details)
