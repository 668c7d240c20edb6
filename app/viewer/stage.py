"""A stage: one viser server on loopback with its scene and its player, shared by those who watch the same."""

import asyncio
import logging
from collections.abc import Iterable
from typing import Any, Final

import rich
import viser
from viser import _messages as viser_messages

from app.errors import Unavailable
from app.live.bus import Bus
from app.viewer.camera import FIELD_OF_VIEW_RAD, Camera, Preset, around, best_sight, preset
from app.viewer.figure.ghost import Limb
from app.viewer.figure.ghost_node import limb_points_m
from app.viewer.guard import SceneSecret, guarded
from app.viewer.layers.nodes import theme_updates
from app.viewer.layers.single_sensors import HEIGHT_M
from app.viewer.layers.words import words_in
from app.viewer.player import LivePlayer, Player, ReplayPlayer
from app.viewer.repository import Contents, ViewTarget
from app.viewer.scene import BodyScene

logger = logging.getLogger(__name__)

LOOPBACK: Final = "127.0.0.1"
_LEG: Final = frozenset({"thigh", "shank", "foot"})
_ARM: Final = frozenset({"upper_arm", "forearm", "hand"})
_ON_FEET: Final = frozenset({"foot_left", "foot_right"})


class LoopbackServer(viser.ViserServer):  # type: ignore[misc]  # viser is not typed here
    """A viser server on loopback that answers only to this process and never opens a public address."""

    def __init__(self) -> None:
        # viser tells its address on the terminal whatever `verbose` says; a service has a log for that.
        rich.get_console().quiet = True
        self.secret = SceneSecret()
        try:
            with guarded(self.secret):
                super().__init__(host=LOOPBACK, port=0, verbose=False)
        except Unavailable:
            self.stop()
            raise
        self.gui.configure_theme(show_logo=False, show_share_button=False, dark_mode=False)

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: patient data does not go to a public tunnel."""
        return None


class Stage:
    """One scene, its server and its clock.

    Parameters
    ----------
    bus : Bus
        For live sessions.

    Notes
    -----
    Building takes about a second (a new body is modelled) and must not run on the event loop.
    """

    def __init__(self, target: ViewTarget, contents: Contents, bus: Bus) -> None:
        self.target = target
        self.body = contents.body
        self._is_walk = contents.view == "feet"
        self._markers = contents.track.markers if contents.track is not None else None
        self._around = _modules_extent(contents)
        self.side = contents.side
        self._server = LoopbackServer()
        ghost = contents.ghost
        self._posture, self._movement = contents.posture, contents.movement
        self._limb: Limb = ghost.limb if ghost is not None else limb_of(contents.measured)
        self._sight = None
        if ghost is not None:
            self._sight = best_sight(
                limb_points_m(ghost.track, contents.body, ghost.side, ghost.limb), ghost.side
            )
        try:
            self.scene = BodyScene(
                self._server,
                contents.body,
                contents.measured,
                contents.affected_side,
                ghost.track if ghost is not None else None,
                contents.side,
                contents.posture,
                ghost.limb if ghost is not None else "arm",
                words_in(target.language),
            )
        except BaseException:
            self._server.stop()
            raise
        # Whether it is a desk or a phone is not known yet; words beside the modules must fit on a phone as well.
        camera = self.look("start", aspect=0.8 if contents.view == "modules" else 1.4)
        self._server.initial_camera.position = camera.position_m
        self._server.initial_camera.look_at = camera.look_at_m
        self._server.initial_camera.fov = FIELD_OF_VIEW_RAD
        self.player: Player
        if contents.track is not None:
            self.player = ReplayPlayer(self.scene, contents.track, contents.ghost_clock)
        else:
            duration_s = ghost.duration_s if ghost is not None else None
            self.player = LivePlayer(
                self.scene, bus, target.session_id, contents.body, duration_s, contents.is_calibrating
            )
        self._task: asyncio.Task[None] | None = None
        self._watchers = 0

    def look(self, name: Preset, aspect: float) -> Camera:
        """Return a point of view that fits what is shown; see `preset`."""
        if self._markers is not None:
            return around(name, self._markers.height_m, self._markers.size_m, aspect)
        if self._around is not None:
            return around(name, *self._around, aspect)
        return preset(
            name,
            self.body,
            self.side,
            aspect,
            is_walk=self._is_walk,
            posture=self._posture,
            sight=self._sight,
            movement=self._movement,
            limb=self._limb,
        )

    @property
    def address(self) -> str:
        """Where the relay finds viser."""
        return f"ws://{LOOPBACK}:{self._server.get_port()}"

    @property
    def headers(self) -> dict[str, str]:
        """What the relay must send to be let in."""
        return self._server.secret.headers

    @property
    def watchers(self) -> int:
        """How many pages are connected."""
        return self._watchers

    def enter(self) -> None:
        """Count a watcher; the first one sets the clock going."""
        self._watchers += 1
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._run(), name="viewer player")

    def leave(self) -> None:
        """Count a watcher out; without any nothing is drawn."""
        self._watchers -= 1
        if self._watchers == 0 and self._task is not None:
            self._task.cancel()

    async def close(self) -> None:
        """Stop drawing and take the server down."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await asyncio.to_thread(self._server.stop)

    async def _run(self) -> None:
        try:
            await self.player.run()
        except Exception:
            # The picture stands still; the next page that enters sets the clock going again.
            logger.exception("a 3D view has stopped drawing")


def limb_of(measured: Iterable[str]) -> Limb:
    """Return what a session is of, by its segments: a leg where some of a leg are measured and none of an arm.

    Parameters
    ----------
    measured : iterable of str
        Segments or places of sensors.
    """
    parts = {name.rsplit("_", 1)[0] for name in measured}
    return "leg" if parts & _LEG and not parts & _ARM else "arm"


def _modules_extent(contents: Contents) -> tuple[float, float] | None:
    """Return height of the middle and size of modules or single sensors; None for other sessions."""
    if contents.view != "modules":
        return None
    track = contents.track
    if track is not None and track.modules is not None:
        return track.modules.height_m, track.modules.size_m
    if track is not None and track.sensors is not None:
        return HEIGHT_M, track.sensors.size_m
    # Live, before anything is known; feet go a step apart.
    return (0.1, 1.4) if contents.measured <= _ON_FEET else (1.15, 0.9)


def theme_messages(dark: bool) -> list[Any]:
    """Return the viser messages that make one page light or dark, whatever the other watchers chose."""
    return [
        viser_messages.ThemeConfigurationMessage(
            titlebar_content=None,
            control_layout="floating",
            control_width="medium",
            show_logo=False,
            show_share_button=False,
            dark_mode=dark,
            colors=None,
        ),
        *theme_updates("dark" if dark else "light"),
    ]
