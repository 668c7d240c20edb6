"""Views: who opened which, the stages they are shown on, and when both end.

A view belongs to the account that opened it, and takes a place of its account's and its clinic's until nobody has
watched it for a minute. Live views of one session share a stage, and each has its own place; a replay has its own
stage. A stage without a view that has a place is taken down, and built again when somebody comes back. Room is made by
what the same account does not watch, never by what others have open.
"""

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import Engine

from app.accounts.subject import Subject
from app.database.base import new_id, utc_now
from app.errors import LimitReached, NotFound, Unavailable
from app.limits import Hold, Limits
from app.live.bus import Bus
from app.live.messages import CameraCommand, PlayerCommand, PlayerState
from app.recordings.schemas import ViewIn, ViewOut
from app.viewer import repository, wire
from app.viewer.camera import Camera
from app.viewer.figure.ghost_node import ghost_visibility
from app.viewer.repository import ViewTarget
from app.viewer.stage import Stage, theme_messages
from estimators.sentences import say

logger = logging.getLogger(__name__)

VIEW_LIFE: Final = timedelta(hours=12)
MOST_OF_ACCOUNT: Final = 20
"""Views that one account may come back to; a further one takes the place of its oldest that nobody watches."""
UNWATCHED_S: Final = 60.0
CHECK_RIGHT_EVERY_S: Final = 5.0
NO_SUCH_VIEW: Final = say("viewer.not_found")

Inject = Callable[[bytes], None]


@dataclass
class View:
    """One opened view.

    Attributes
    ----------
    target : ViewTarget
        What it shows.
    owner : Subject
        Whose it is; nobody else's cookie opens it.
    camera : Camera or None
        Last pose that the page reported.
    pages : set of callable
        Take packed messages for this view's own pages.
    hold : Hold or None
        Its place among those of its account, its clinic and the service.
    watchers : int
        Open sockets of its page and its controls.
    """

    target: ViewTarget
    owner: Subject
    id: str = field(default_factory=new_id)
    expires_at: datetime = field(default_factory=lambda: utc_now() + VIEW_LIFE)
    camera: Camera | None = None
    aspect: float = 1.4
    is_dark: bool = False
    shows_ghost: bool = True
    pages: set[Inject] = field(default_factory=set)
    hold: Hold | None = None
    watchers: int = 0
    unwatched_since: float = field(default_factory=time.monotonic)

    @contextlib.contextmanager
    def watched(self) -> Iterator[None]:
        """Count a socket while it is open."""
        self.watchers += 1
        try:
            yield
        finally:
            self.watchers -= 1
            self.unwatched_since = time.monotonic()

    def release(self) -> None:
        """Give the place back."""
        if self.hold is not None:
            self.hold.release()
            self.hold = None

    @property
    def stage_key(self) -> tuple[str, ...]:
        """Views with the same key share a stage."""
        if self.target.mode == "live":
            target = self.target
            return ("live", target.session_id, target.template_version_id or "", target.language)
        return ("replay", self.id)

    def to_pages(self, messages: list[Any]) -> None:
        """Send viser messages to this view's pages only."""
        if messages:
            packed = wire.pack(messages)
            for page in self.pages:
                page(packed)


class Viewer:
    """All views of this process.

    Parameters
    ----------
    limits : Limits
        How many scenes may stand at once.
    unwatched_s : float
        A stage without watchers is taken down after so long.
    check_right_every_s : float
        How often an open socket's right is checked again.
    """

    def __init__(
        self,
        engine: Engine,
        bus: Bus,
        limits: Limits,
        *,
        unwatched_s: float = UNWATCHED_S,
        check_right_every_s: float = CHECK_RIGHT_EVERY_S,
    ) -> None:
        self._engine = engine
        self._bus = bus
        self._limits = limits
        self._unwatched_s = unwatched_s
        self.check_right_every_s = check_right_every_s
        self._views: dict[str, View] = {}
        self._stages: dict[tuple[str, ...], Stage] = {}
        self._building: dict[tuple[str, ...], asyncio.Task[Stage]] = {}
        self._sweeper: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Begin to look after views that nobody watches."""
        self._sweeper = asyncio.create_task(self._sweep_forever(), name="viewer sweep")

    async def close(self) -> None:
        """Take every stage down."""
        if self._sweeper is not None:
            self._sweeper.cancel()
        for task in list(self._building.values()):
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError, Exception):
                await task
        stages = list(self._stages.values())
        self._stages.clear()
        for view in self._views.values():
            view.release()
        self._views.clear()
        await asyncio.gather(*(stage.close() for stage in stages))

    @property
    def stage_count(self) -> int:
        """Scenes that stand now."""
        return len(self._stages) + len(self._building)

    async def open(self, subject: Subject, session_id: str, wanted: ViewIn) -> ViewOut:
        """Open a view for a person who may read the session.

        Raises
        ------
        NotFound, NotAllowed, Conflict, InvalidInput
            See `repository.find_target` and `repository.load_contents`.
        LimitReached, Unavailable
            Too many scenes are open, see `app.limits`.
        """
        target = await asyncio.to_thread(repository.find_target, self._engine, subject, session_id, wanted)
        view = View(target=target, owner=subject)
        self._views[view.id] = view
        try:
            await self.stage_of(view)
        except BaseException:
            self._forget(view)
            raise
        own = [one for one in self._views.values() if one.owner.id == subject.id and one is not view]
        unwatched = [one for one in own if one.watchers == 0]
        for one in unwatched[: max(0, len(own) + 1 - MOST_OF_ACCOUNT)]:
            self._forget(one)
        return ViewOut(
            id=view.id,
            page_path=f"/viewer/{view.id}/",
            control_path=f"/ws/views/{view.id}",
            expires_at=view.expires_at,
        )

    def find(self, subject: Subject, view_id: str) -> View:
        """Return a view of this account.

        Raises
        ------
        NotFound
            Another's, ended, or none.
        """
        view = self._views.get(view_id)
        if view is None or view.owner.id != subject.id or view.expires_at <= utc_now():
            raise NotFound(NO_SUCH_VIEW)
        return view

    async def check(self, subject: Subject, view_id: str) -> View:
        """Return a view of this account while its right to the patient stands.

        Raises
        ------
        NotFound, NotAllowed
        """
        view = self.find(subject, view_id)
        await asyncio.to_thread(repository.check_right, self._engine, subject, view.target)
        return view

    async def stage_of(self, view: View) -> Stage:
        """Return the stage of a view, built now if it does not stand.

        Raises
        ------
        LimitReached, Unavailable
            Too many scenes are open, see `app.limits`.
        """
        key = view.stage_key
        if view.hold is None:
            try:
                view.hold = self._limits.take("views", view.owner)
            except (LimitReached, Unavailable):
                self._release_unwatched(0.0, view.owner)
                view.hold = self._limits.take("views", view.owner)
                await self._close_unused()
        if key in self._stages:
            return self._stages[key]
        if key not in self._building:
            self._building[key] = asyncio.create_task(self._build(key, view.target), name="viewer stage")
        return await asyncio.shield(self._building[key])

    async def _build(self, key: tuple[str, ...], target: ViewTarget) -> Stage:
        try:
            stage = await asyncio.to_thread(
                lambda: Stage(target, repository.load_contents(self._engine, target), self._bus)
            )
            self._stages[key] = stage
            return stage
        finally:
            self._building.pop(key, None)

    async def obey(self, view: View, command: PlayerCommand | CameraCommand) -> PlayerState:
        """Carry out what a page asks through the control socket; return what is shown then."""
        stage = await self.stage_of(view)
        if isinstance(command, CameraCommand):
            self._look(view, stage, command)
        else:
            if command.ghost != view.shows_ghost:
                view.shows_ghost = command.ghost
                view.to_pages([ghost_visibility(command.ghost)])
            stage.player.command(command)
        return stage.player.state()

    def greeting(self, view: View, stage: Stage) -> list[Any]:
        """Return the messages that give a page that has just connected this view's own look."""
        camera = view.camera or stage.look("start", view.aspect)
        messages = camera.messages()
        if view.is_dark:
            messages += theme_messages(dark=True)
        if stage.scene.has_ghost and not view.shows_ghost:
            messages.append(ghost_visibility(False))
        return messages

    def _look(self, view: View, stage: Stage, command: CameraCommand) -> None:
        messages: list[Any] = []
        camera = view.camera or stage.look("start", view.aspect)
        if command.preset is not None:
            camera = stage.look(command.preset, view.aspect)
        if command.turn_deg or command.tilt_deg or command.zoom != 1.0:
            camera = camera.stepped(command.turn_deg, command.tilt_deg, command.zoom)
        if camera is not view.camera:
            view.camera = camera
            messages += camera.messages()
        if command.theme is not None and (command.theme == "dark") != view.is_dark:
            view.is_dark = command.theme == "dark"
            messages += theme_messages(view.is_dark)
        view.to_pages(messages)

    async def _sweep_forever(self) -> None:
        while True:
            await asyncio.sleep(min(self._unwatched_s / 4, 5.0))
            try:
                await self._sweep(self._unwatched_s)
            except Exception:
                logger.exception("cannot take an unwatched 3D view down")

    async def _sweep(self, unwatched_s: float) -> None:
        for view in [v for v in self._views.values() if v.expires_at <= utc_now()]:
            self._forget(view)
        self._release_unwatched(unwatched_s)
        await self._close_unused()

    def _forget(self, view: View) -> None:
        self._views.pop(view.id, None)
        view.release()

    def _release_unwatched(self, unwatched_s: float, owner: Subject | None = None) -> None:
        """Give back the places of views that nobody watches, of one account or of all."""
        now = time.monotonic()
        for view in self._views.values():
            is_idle = view.watchers == 0 and now - view.unwatched_since >= unwatched_s
            is_asked = owner is None or view.owner.id == owner.id
            if is_idle and is_asked and view.stage_key not in self._building:
                view.release()

    async def _close_unused(self) -> None:
        """Take down the stages of which no view has a place."""
        in_use = {view.stage_key for view in self._views.values() if view.hold is not None}
        idle = {
            key: stage for key, stage in self._stages.items() if key not in in_use and stage.watchers == 0
        }
        # All at once, before anything is awaited: another request may sweep meanwhile, or come to watch.
        for key in idle:
            del self._stages[key]
        for stage in idle.values():
            await stage.close()
