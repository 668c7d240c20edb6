"""The template in the scene: a translucent arm or leg in the accent colour, and the dashed way of its end."""

from typing import Any, Final

import numpy as np
import viser
from numpy.typing import NDArray
from viser import _messages as wire

from app.viewer.figure.ghost import Limb
from app.viewer.figure.ghost_arm import bone_track, hand_points_m, skinned_arm
from app.viewer.figure.ghost_leg import foot_points_m, hip_joint_m, leg_bones, skinned_leg
from app.viewer.figure.proportions import hip_height_m
from app.viewer.layers.palette import ACCENT
from app.viewer.pose import PoseTrack
from estimators.body import BodyDimensions
from estimators.conventions import SIDES, Side
from estimators.recording import Float

GHOST: Final = "/template"
_LIMB: Final = f"{GHOST}/figure/limb"
_OPACITY: Final = 0.5
_DASH_M, _GAP_M = 0.030, 0.018
_SAME_WAY_M: Final = 0.03
_TURN_EPSILON: Final = 2e-4
_SHIFT_EPSILON_M: Final = 5e-4

Float32 = NDArray[np.float32]


class GhostNode:
    """A template on a stage.

    Parameters
    ----------
    track : PoseTrack
        Phases 0 to 100.
    body : BodyDimensions
        The patient's.
    drop_m : float
        How much lower the patient's hips are than standing.
    limb : {"arm", "leg"}
        What of the template is shown.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        track: PoseTrack,
        body: BodyDimensions,
        side: Side,
        drop_m: float = 0.0,
        limb: Limb = "arm",
    ) -> None:
        self._server = server
        skin = skinned_arm(body, side) if limb == "arm" else skinned_leg(body, side)
        bones = bone_track if limb == "arm" else leg_bones
        self._wxyz, self._position = bones(track, body, side)
        shoulder = np.array([0.0, (0.5 if side == "left" else -0.5) * body.shoulder_width_m, body.trunk_m])
        neutral = shoulder if limb == "arm" else hip_joint_m(body, side)
        server.scene.add_frame(GHOST, show_axes=False, position=(0.0, 0.0, -drop_m))
        self._root = server.scene.add_frame(
            f"{GHOST}/figure", show_axes=False, position=(0.0, 0.0, hip_height_m(body))
        )
        self._sent_wxyz = np.tile(np.array([1, 0, 0, 0], np.float32), (len(skin.joints_m), 1))
        self._sent_position = (skin.joints_m + neutral).astype(np.float32)
        server.scene.add_mesh_skinned(
            _LIMB,
            (skin.mesh.vertices_m + neutral).astype(np.float32),
            skin.mesh.faces,
            bone_wxyzs=self._sent_wxyz,
            bone_positions=self._sent_position,
            skin_weights=skin.weights,
            color=ACCENT,
            opacity=_OPACITY,
            cast_shadow=False,
            receive_shadow=False,
        )
        dashes = dashed(_end_m(track, body, side, limb))
        self._path: Any = None
        if len(dashes):
            self._path = server.scene.add_line_segments(
                f"{GHOST}/path", dashes, colors=ACCENT, thickness=2.5, thickness_units="screen"
            )
        self._is_visible = True

    def show(self, phase: float | None, *, with_path: bool = True) -> None:
        """Show a phase from 0 to 100, interpolated; None hides the limb, and its path only when asked for."""
        if self._path is not None and self._path.visible != with_path:
            self._path.visible = with_path
        if (phase is not None) != self._is_visible:
            self._root.visible = self._is_visible = phase is not None
        if phase is None:
            return
        place = min(max(phase, 0.0), 100.0) / 100.0 * (len(self._wxyz) - 1)
        before = min(int(place), len(self._wxyz) - 2)
        share = np.float32(place - before)
        # Neighbouring phases differ by a few degrees at most: the chord is as good as the arc.
        wxyz = _blend(self._wxyz[before], self._wxyz[before + 1], share)
        position = self._position[before] * (1 - share) + self._position[before + 1] * share
        queue = self._server._websock_server.queue_message
        for bone in range(len(wxyz)):
            if np.abs(wxyz[bone] - self._sent_wxyz[bone]).max() > _TURN_EPSILON:
                queue(wire.SetBoneOrientationMessage(_LIMB, bone, tuple(wxyz[bone].tolist())))
                self._sent_wxyz[bone] = wxyz[bone]
            if np.abs(position[bone] - self._sent_position[bone]).max() > _SHIFT_EPSILON_M:
                queue(wire.SetBonePositionMessage(_LIMB, bone, tuple(position[bone].tolist())))
                self._sent_position[bone] = position[bone]


def limb_points_m(track: PoseTrack, body: BodyDimensions, side: Side, limb: Limb) -> Float:
    """Return places over a template's movement by which it is looked at, its end first, shape (K, N, 3)."""
    return hand_points_m(track, body, side) if limb == "arm" else foot_points_m(track, body, side)


def _end_m(track: PoseTrack, body: BodyDimensions, side: Side, limb: Limb) -> Float32:
    if limb == "arm":
        return track.hand_m[:, SIDES.index(side)]
    ankle: Float32 = foot_points_m(track, body, side)[:, 0].astype(np.float32)
    ankle[:, 2] += np.float32(hip_height_m(body))
    return ankle


def ghost_visibility(on: bool) -> Any:
    """Return the viser message that shows or hides ghost and path in one page."""
    return wire.SetSceneNodeVisibilityMessage(GHOST, on)


def dashed(path_m: Float32) -> Float32:
    """Turn a path, shape (N, 3), into dashes of even length, shape (M, 2, 3).

    A way back that is the way out again would fill the gaps; it is left away.
    """
    path = path_m[np.isfinite(path_m).all(axis=1)].astype(np.float64)
    if len(path) < 2:
        return np.zeros((0, 2, 3), np.float32)
    farthest = int(np.argmax(np.linalg.norm(path - path[0], axis=1)))
    out, back = path[: farthest + 1], path[farthest:]
    if len(out) > 1 and len(back) > 1:
        apart = np.linalg.norm(back[:, None] - out[None], axis=2).min(axis=1)
        if apart.max() < _SAME_WAY_M:
            path = out
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    starts = np.arange(0.0, max(length[-1] - _DASH_M, 0.0), _DASH_M + _GAP_M)
    # Each dash bends in its middle with the path.
    at = starts[:, None] + _DASH_M * np.array([0.0, 0.5, 1.0])
    points = np.stack([np.interp(at, length, path[:, axis]) for axis in range(3)], axis=-1)
    return np.concatenate([points[:, :2], points[:, 1:]]).astype(np.float32)


def _blend(first: Float32, second: Float32, share: np.float32) -> Float32:
    near = np.where((first * second).sum(axis=-1, keepdims=True) < 0, -second, second)
    mixed = first * (1 - share) + near * share
    blended: Float32 = (mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)).astype(np.float32)
    return blended
