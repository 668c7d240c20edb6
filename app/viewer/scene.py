"""One viser scene: the room, the patient's body, the template's ghost, trails, halos and what is lost.

The scene holds no clock. A player calls `draw` with a tick of a `PoseTrack`; only what changed is sent, as
one small message per segment that turned (the tree of segments makes positions follow).
"""

from typing import Any, Final

import numpy as np
import viser
from numpy.typing import NDArray

from app.exercises.models import Posture
from app.viewer.figure.body_mesh import build_figure
from app.viewer.figure.ghost import Limb
from app.viewer.figure.ghost_node import GhostNode
from app.viewer.figure.proportions import hip_height_m
from app.viewer.layers import nodes, palette
from app.viewer.layers.feet import FeetTrack
from app.viewer.layers.feet_layer import FeetLayer
from app.viewer.layers.markers_layer import MarkersLayer
from app.viewer.layers.mass_node import MassNode
from app.viewer.layers.modules import ModuleLayer, ModuleTrack
from app.viewer.layers.seat import add_seat, seat_height_m
from app.viewer.layers.single_sensors import SensorLayer, SensorTrack
from app.viewer.layers.words import Words, in_english
from app.viewer.pose import PARENT, SEGMENTS, PoseTrack
from app.viewer.silence import NO_DATA
from estimators.body import BodyDimensions
from estimators.conventions import SIDES, Side
from estimators.sentences import Sentence

_FADED: Final = 0.45
"""Opacity of a segment that gives nothing, or of which nobody knows well enough where it is."""
_WEARABLE: Final = tuple(
    name for name in SEGMENTS if not name.startswith(("pelvis", "thigh", "shank", "foot"))
)
_AROUND_MASS: Final = ("pelvis", "sternum", "thigh_left", "thigh_right")
_TURN_EPSILON: Final = 2e-4
"""Quaternion components closer than this (about 0.02 degrees) are not sent again."""
_SHIFT_EPSILON_M: Final = 5e-4


class BodyScene:
    """The contents of one `ViserServer`.

    Parameters
    ----------
    server : viser.ViserServer
        Empty; bound to loopback by the caller.
    measured : frozenset of str
        Segments that a sensor drives; the others are drawn paler.
    affected_side : str or None
        `left`, `right`, `both` or None: wears a band on the upper arm.
    ghost : PoseTrack or None
        The template over its phases 0 to 100, drawn on this body.
    ghost_side : {"left", "right"}
        The side that the template is about.
    posture : {"standing", "seated"}
        Of the exercise. Who sits does so until `sit` says otherwise.
    ghost_limb : {"arm", "leg"}
        What the template is about.
    words : callable(sentence)
        Says what stands within the picture in the language of the page.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        body: BodyDimensions,
        measured: frozenset[str],
        affected_side: str | None = None,
        ghost: PoseTrack | None = None,
        ghost_side: Side = "right",
        posture: Posture = "standing",
        ghost_limb: Limb = "arm",
        words: Words = in_english,
    ) -> None:
        self._server, self._words = server, words
        self._hip_m = hip_height_m(body, posture)
        self._drop_m = hip_height_m(body) - self._hip_m
        """How much lower than in the estimator's room, where everybody stands, the figure is while it sits."""
        self._is_sitting = posture == "seated"
        self._measured = measured
        bands = {"left": {"left"}, "right": {"right"}, "both": {"left", "right"}}.get(
            affected_side or "", set()
        )
        with server.atomic():
            nodes.add_room(server)
            self._solid = _Figure(server, "/patient", body, PARENT)
            self._seat = None
            if self._is_sitting:
                self._seat = add_seat(server, body)
            self._parts: dict[str, list[nodes.Part]] = {}
            for piece in build_figure(body):
                if piece.material == "band" and piece.segment.rpartition("_")[2] not in bands:
                    continue
                part = nodes.add_piece(server, self._solid.path[piece.segment], piece, measured)
                self._parts.setdefault(piece.segment, []).append(part)
            self._on_seat_m = seat_height_m(body) - self._hip_m
            self._place_hips()
            self._lost_labels = {
                name: nodes.add_lost_label(server, self._solid.path[name], name, words) for name in _WEARABLE
            }
            self._silence_label = nodes.add_silence_label(server, self._solid.path["sternum"], words(NO_DATA))
            self._halos = {
                (number, joint): nodes.Halo(server, self._solid.path[f"{segment}_{side}"], segment, body)
                for number, side in enumerate(SIDES)
                for joint, segment in enumerate(("forearm", "hand"))
            }
            self._trails = [nodes.Trail(server, f"/trail/{side}") for side in SIDES]
            self._ghost = None
            if ghost is not None:
                self._ghost = GhostNode(server, ghost, body, ghost_side, self._drop_m, ghost_limb)
        self._mass: MassNode | None = None
        self._modules: ModuleLayer | None = None
        self._sensors: SensorLayer | None = None
        self._feet: FeetLayer | None = None
        self._markers: MarkersLayer | None = None
        self._lost = np.zeros(len(SEGMENTS), dtype=bool)
        self._silence: Sentence | None = NO_DATA
        self._unsure = np.zeros(len(SIDES), dtype=bool)

    @property
    def has_ghost(self) -> bool:
        """Whether a template was given."""
        return self._ghost is not None

    @property
    def posture(self) -> Posture:
        """How the figure is shown now."""
        return "seated" if self._is_sitting else "standing"

    @property
    def exercise_posture(self) -> Posture:
        """In which the exercise is done."""
        return "standing" if self._seat is None else "seated"

    def sit(self, on: bool) -> None:
        """Let the figure of a seated exercise stand up, as for a calibration pose, or sit down again."""
        if self._seat is None or on == self._is_sitting:
            return
        self._is_sitting = on
        with self._server.atomic():
            self._seat.visible = on
            self._place_hips()

    def _place_hips(self) -> None:
        """Put the hips on the seat, with nothing of them below it, or where they are standing."""
        self._solid.stand_at(self._hip_m if self._is_sitting else self._hip_m + self._drop_m)
        if self._seat is not None:
            for part in self._parts["pelvis"]:
                vertices = part.piece.mesh.vertices_m.copy()
                if self._is_sitting:
                    vertices[:, 2] = np.maximum(vertices[:, 2], self._on_seat_m)
                part.handle.vertices = vertices

    @property
    def measured_mask(self) -> NDArray[np.bool_]:
        """Which of `SEGMENTS` a sensor drives, shape (S,)."""
        return np.array([name in self._measured for name in SEGMENTS])

    def show_measured(self, measured: frozenset[str]) -> None:
        """Take note of other sensors than those declared before: their segments get the warmer skin."""
        if measured == self._measured:
            return
        self._measured = measured
        with self._server.atomic():
            for parts in self._parts.values():
                for part in parts:
                    part.colour = nodes.piece_colour(part.piece, measured)
                    part.handle.color = part.colour

    def draw(
        self,
        track: PoseTrack,
        tick: int,
        trail: NDArray[np.float32] | None = None,
        silence: Sentence | None = NO_DATA,
    ) -> None:
        """Show one tick of the patient.

        Parameters
        ----------
        tick : int
            Index into the track.
        trail : ndarray of float32, shape (N, 2, 3), optional
            Past positions of the left and right hand up to this tick; None leaves the trails as they are.
        silence : Sentence, optional
            What is said where everything that is measured is lost; None says nothing.
        """
        with self._server.atomic():
            if track.markers is not None:
                if self._markers is None:
                    self._solid.visible(False)
                    self._markers = MarkersLayer(self._server)
                self._markers.show(track.markers, track.time_s, tick)
                return
            if track.modules is not None:
                self._draw_modules(track.modules, tick)
                return
            if track.sensors is not None:
                self._draw_sensors(track.sensors, tick)
                return
            if track.feet is not None:
                self._draw_feet(track.feet, tick)
                return
            if track.stands is not None:
                self.sit(not track.stands[tick])
            self._solid.show(track.wxyz[tick], track.shoulder_m[tick])
            unsure = track.halo_m[tick, :, 1] > nodes.HALO_MOST_M
            if not np.array_equal(unsure, self._unsure):
                self._unsure = unsure.copy()
                self._fade_arms()
            if not np.array_equal(track.lost[tick], self._lost) or silence != self._silence:
                self._show_lost(track.lost[tick], silence)
            self._draw_mass(track, tick)
            for (number, joint), halo in self._halos.items():
                halo.show(float(track.halo_m[tick, number, joint]))
            if trail is not None:
                lowered = trail - self._lowered()
                for number, line in enumerate(self._trails):
                    line.show(lowered[:, number])

    def _draw_mass(self, track: PoseTrack, tick: int) -> None:
        """Show the centre of mass within a trunk that can be looked into."""
        if track.mass_m is None or track.mass_spread_m is None:
            return
        if self._mass is None:
            self._mass = MassNode(self._server)
            for name in _AROUND_MASS:
                for part in self._parts.get(name, []):
                    part.handle.opacity = _FADED
        self._mass.show(track.mass_m[tick] - self._lowered(), float(track.mass_spread_m[tick]))

    def _lowered(self) -> NDArray[np.float32]:
        return np.array([0.0, 0.0, self._drop_m if self._is_sitting else 0.0], dtype=np.float32)

    def _draw_feet(self, track: FeetTrack, tick: int) -> None:
        """Show the feet of a walk, and no figure: nothing tells how the rest of the body moves."""
        if self._feet is None or self._feet.sides != track.sides:
            self._solid.visible(False)
            self._feet = FeetLayer(self._server, track)
        self._feet.show(track, tick)

    def _draw_modules(self, track: ModuleTrack, tick: int) -> None:
        """Show source and sensors, and no figure: where a body is, they do not tell."""
        if self._modules is None or self._modules.names != track.names:
            self._solid.visible(False)
            self._modules = ModuleLayer(self._server, track.names, self._words)
        self._modules.show(track, tick)

    def _draw_sensors(self, track: SensorTrack, tick: int) -> None:
        """Show single sensors, and no figure: nobody says that they were worn."""
        if self._sensors is None or self._sensors.names != track.names:
            self._solid.visible(False)
            self._sensors = SensorLayer(self._server, track, self._words)
        self._sensors.show(track, tick)

    def draw_ghost(self, phase: float | None, *, with_path: bool = True) -> None:
        """Show the template at a phase from 0 to 100 (interpolated), or hide it.

        Parameters
        ----------
        with_path : bool
            Whether the way of its hand stays in view.
        """
        if self._ghost is not None:
            with self._server.atomic():
                self._ghost.show(phase, with_path=with_path)

    def _is_unsure(self, segment: str) -> bool:
        if self._mass is not None and segment in _AROUND_MASS:
            return True
        part, _, side = segment.rpartition("_")
        return part in {"upper_arm", "forearm", "hand"} and bool(self._unsure[SIDES.index(side)])

    def _fade_arms(self) -> None:
        """Show translucent where an arm is not known to a hand's length, as after a calibration."""
        for number, name in enumerate(SEGMENTS):
            if not self._lost[number]:
                for part in self._parts.get(name, []):
                    opacity = _FADED if self._is_unsure(name) else None
                    if part.handle.opacity != opacity:
                        part.handle.opacity = opacity

    def _show_lost(self, lost: NDArray[np.bool_], silence: Sentence | None) -> None:
        for number in np.flatnonzero(lost != self._lost):
            name = SEGMENTS[number]
            for part in self._parts.get(name, []):
                part.handle.color = palette.LOST if lost[number] else part.colour
                part.handle.opacity = _FADED if lost[number] or self._is_unsure(name) else None
        # Where nothing comes from anywhere one label says so: seven lie over each other and none can be read.
        measured = self.measured_mask
        is_silent = bool(measured.any() and lost[measured].all())
        self._silence_label.visible = is_silent and silence is not None
        if silence is not None and self._silence_label.text != self._words(silence):
            self._silence_label.text = self._words(silence)
        for name, label in self._lost_labels.items():
            label.visible = bool(lost[SEGMENTS.index(name)]) and not is_silent
        self._lost, self._silence = lost.copy(), silence


class _Figure:
    """The frames of one body; knows what was sent, so that only changes go out."""

    def __init__(
        self, server: viser.ViserServer, root: str, body: BodyDimensions, segments: dict[str, str | None]
    ) -> None:
        self._server = server
        self._root = server.scene.add_frame(root, show_axes=False, position=(0.0, 0.0, hip_height_m(body)))
        self.path: dict[str, str] = {}
        self._frames: list[tuple[int, Any]] = []
        offsets = nodes.joint_offsets_m(body)
        for name, parent in segments.items():
            self.path[name] = f"{self.path.get(parent or '', root)}/{name}"
            frame = server.scene.add_frame(self.path[name], show_axes=False, position=offsets[name])
            self._frames.append((SEGMENTS.index(name), frame))
        self._columns = [column for column, _ in self._frames]
        self._shoulders = {
            number: frame
            for column, frame in self._frames
            for number, side in enumerate(SIDES)
            if SEGMENTS[column] == f"upper_arm_{side}"
        }
        self._sent = np.tile(np.array([1, 0, 0, 0], np.float32), (len(self._frames), 1))
        self._sent_shoulder = np.array([offsets[f"upper_arm_{side}"] for side in SIDES], np.float32)
        self._visible = True

    def show(self, wxyz: NDArray[np.float32], shoulder_m: NDArray[np.float32]) -> None:
        """Turn the segments (S, 4) and move the shoulders (2, 3) that changed."""
        wanted = wxyz[self._columns]
        for row in np.flatnonzero(np.abs(wanted - self._sent).max(axis=1) > _TURN_EPSILON):
            nodes.turn(self._server, self._frames[row][1], wanted[row])
            self._sent[row] = wanted[row]
        if np.abs(shoulder_m - self._sent_shoulder).max() > _SHIFT_EPSILON_M:
            for number, frame in self._shoulders.items():
                nodes.shift(self._server, frame, shoulder_m[number])
            self._sent_shoulder = shoulder_m.copy()

    def stand_at(self, hip_m: float) -> None:
        """Put the hips at a height above the floor."""
        self._root.position = (0.0, 0.0, hip_m)

    def visible(self, on: bool) -> None:
        """Show or hide the whole figure."""
        if on != self._visible:
            self._root.visible = self._visible = on
