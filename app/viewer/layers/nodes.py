"""Nodes of the scene in viser: room, pieces of the body, ghost, trail, halo, labels."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
import viser
from numpy.typing import NDArray
from viser import _messages as wire

from app.viewer.figure.body_mesh import Piece
from app.viewer.figure.proportions import hip_half_width_m, leg_lengths_m, neck_height_m
from app.viewer.layers.palette import HALO, MATERIAL_COLOURS, PALETTES, TRAIL, UNMEASURED_SKIN, Rgb, Theme
from app.viewer.layers.words import Words
from estimators.body import BodyDimensions
from estimators.sentences import say

FLOOR: Final = "/room/floor"
_LIGHTS: Final = ("/room/sky", "/room/key", "/room/fill")
_HALF_FLOOR_M: Final = 2.0
_GLYPH_M: Final = 0.060
_ABOVE_FLOOR_M: Final = 0.002
_HALO_SHELLS: Final = 5
_HALO_OPACITY: Final = 0.05
_HALO_DENSE_M: Final = 0.05
"""Up to here a halo is equally dense; a wider one has the same paint over more room, so it thins to a mist."""
_HALO_LEAST_M: Final = 0.008
HALO_MOST_M: Final = 0.15
"""Wider than a hand is long it says no longer where the hand is: the whole arm turns translucent instead."""
# Strokes in units of the height, and the width, of what the scale on the floor needs.
_GLYPHS: Final[dict[str, tuple[list[list[tuple[float, float]]], float]]] = {
    "0": (
        [[(0.15, 0), (0, 0.2), (0, 0.8), (0.15, 1), (0.4, 1), (0.55, 0.8), (0.55, 0.2), (0.4, 0), (0.15, 0)]],
        0.55,
    ),
    "1": ([[(0.0, 0.78), (0.22, 1), (0.22, 0)]], 0.28),
    "5": (
        [[(0.52, 1), (0.06, 1), (0.03, 0.56), (0.3, 0.62), (0.52, 0.45), (0.52, 0.18), (0.36, 0), (0, 0.04)]],
        0.52,
    ),
    ".": ([[(0.04, 0), (0.04, 0.09)]], 0.08),
    "m": (
        [
            [(0, 0), (0, 0.62)],
            [(0, 0.48), (0.2, 0.62), (0.38, 0.5), (0.38, 0)],
            [(0.38, 0.48), (0.6, 0.62), (0.76, 0.5), (0.76, 0)],
        ],
        0.76,
    ),
    " ": ([], 0.2),
}
_TRAIL_OLD_SHARE: Final = 0.55
_TRAIL_STEP_M: Final = 0.003


def joint_offsets_m(body: BodyDimensions) -> dict[str, tuple[float, float, float]]:
    """Return where each segment's origin lies in its parent (or above the hips), standing."""
    thigh, shank, _ = leg_lengths_m(body)
    offsets = {"pelvis": (0.0, 0.0, 0.0), "sternum": (0.0, 0.0, 0.0), "head": (0.0, 0.0, neck_height_m(body))}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        offsets |= {
            f"upper_arm_{side}": (0.0, sign * 0.5 * body.shoulder_width_m, body.trunk_m),
            f"forearm_{side}": (0.0, 0.0, -body.upper_arm_m),
            f"hand_{side}": (0.0, 0.0, -body.forearm_m),
            f"thigh_{side}": (0.0, sign * hip_half_width_m(body), 0.0),
            f"shank_{side}": (0.0, 0.0, -thigh),
            f"foot_{side}": (0.0, 0.0, -shank),
        }
    return offsets


def add_room(server: viser.ViserServer) -> None:
    """Add floor with scale, and lights; take viser's own lights and reflections away."""
    scene = server.scene
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(hdri=None)
    scene.add_light_hemisphere(_LIGHTS[0])
    scene.add_light_directional(_LIGHTS[1], position=(2.4, 1.8, 3.4), cast_shadow=True)
    scene.add_light_directional(_LIGHTS[2], position=(1.2, -3.0, 1.4))
    scene.add_grid(
        FLOOR,
        width=2 * _HALF_FLOOR_M + 3.0,
        height=2 * _HALF_FLOOR_M + 3.0,
        cell_size=0.5,
        section_size=1.0,
        fade_distance=3.6,
        fade_strength=1.0,
        fade_from="origin",
    )
    for theme, palette in PALETTES.items():
        scene.add_line_segments(
            _scale(theme),
            floor_scale_m(),
            colors=palette.floor_text,
            thickness=2.0,
            thickness_units="screen",
            visible=False,
        )
    for message in theme_updates("light"):
        server._websock_server.queue_message(message)


def floor_scale_m() -> NDArray[np.float32]:
    """Return the numbers painted on the floor as line segments, shape (N, 2, 3).

    Metres forward and to both sides, readable for somebody who looks at the patient from the front.
    """
    segments: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = []
    for text, x, y in (
        ("0.5 m", 0.5, 0.0),
        ("1 m", 1.0, 0.0),
        ("0.5 m", 0.0, 0.5),
        ("0.5 m", 0.0, -0.5),
        ("1 m", 0.0, 1.0),
        ("1 m", 0.0, -1.0),
    ):
        place = y + 0.02
        for character in text:
            strokes, width = _GLYPHS[character]
            for stroke in strokes:
                for (u0, v0), (u1, v1) in pairwise(stroke):
                    start = (x - 0.02 - _GLYPH_M * v0, place + _GLYPH_M * u0, _ABOVE_FLOOR_M)
                    end = (x - 0.02 - _GLYPH_M * v1, place + _GLYPH_M * u1, _ABOVE_FLOOR_M)
                    segments.append((start, end))
            place += _GLYPH_M * (width + 0.22)
    return np.array(segments, dtype=np.float32)


def _scale(theme: Theme) -> str:
    return f"/room/scale/{theme}"


SCALES: Final = tuple(_scale(theme) for theme in PALETTES)


def theme_updates(name: Theme) -> list[Any]:
    """Return the viser messages that give floor and lights the colours of a theme."""
    sky, key, fill = _LIGHTS
    theme = PALETTES[name]
    return [
        *(wire.SetSceneNodeVisibilityMessage(_scale(each), each == name) for each in PALETTES),
        wire.SceneNodeUpdateMessage(
            FLOOR,
            {
                "cell_color": theme.floor_line,
                "section_color": theme.floor_section,
                "shadow_opacity": theme.floor_shadow,
            },
        ),
        wire.SceneNodeUpdateMessage(
            sky, {"sky_color": theme.sky, "ground_color": theme.ground, "intensity": theme.sky_intensity}
        ),
        wire.SceneNodeUpdateMessage(key, {"color": theme.key, "intensity": theme.key_intensity}),
        wire.SceneNodeUpdateMessage(fill, {"color": theme.sky, "intensity": theme.fill_intensity}),
    ]


@dataclass
class Part:
    """One piece of the patient in the scene."""

    piece: Piece
    handle: Any
    colour: Rgb


def piece_colour(piece: Piece, measured: frozenset[str]) -> Rgb:
    """Return the colour of a piece: skin without a sensor is paler."""
    if piece.material == "skin" and piece.segment not in measured:
        return UNMEASURED_SKIN
    return MATERIAL_COLOURS[piece.material]


def add_piece(server: viser.ViserServer, path: str, piece: Piece, measured: frozenset[str]) -> Part:
    """Add one piece of the patient."""
    colour = piece_colour(piece, measured)
    handle = server.scene.add_mesh_simple(
        f"{path}/{piece.material}",
        piece.mesh.vertices_m,
        piece.mesh.faces,
        color=colour,
        cast_shadow=True,
        receive_shadow=False,
    )
    return Part(piece, handle, colour)


def add_lost_label(server: viser.ViserServer, path: str, segment: str, words: Words) -> Any:
    """Add the hidden words that say which sensor gives nothing."""
    return server.scene.add_label(
        f"{path}/lost",
        words(say("viewer.no_signal", place=segment)),
        position=(0.0, 0.0, -0.1),
        visible=False,
        font_screen_scale=1.4,
        anchor="center-left",
    )


def add_silence_label(server: viser.ViserServer, path: str, words: str) -> Any:
    """Add the hidden words for when no sensor gives anything: one label, not one over another."""
    return server.scene.add_label(
        f"{path}/silent",
        words,
        position=(0.0, 0.0, 0.55),
        visible=False,
        font_screen_scale=1.6,
        anchor="bottom-center",
    )


class Trail:
    """Where a hand has been: thick where it has just been, thin before."""

    def __init__(self, server: viser.ViserServer, name: str) -> None:
        nothing = np.zeros((1, 2, 3), dtype=np.float32)
        self._ends = np.zeros((2, 3), dtype=np.float32)
        self._new = server.scene.add_line_segments(
            f"{name}/new", nothing, colors=TRAIL, thickness=5.0, thickness_units="screen", visible=False
        )
        self._old = server.scene.add_line_segments(
            f"{name}/old", nothing, colors=TRAIL, thickness=2.0, thickness_units="screen", visible=False
        )

    def show(self, points_m: NDArray[np.float32]) -> None:
        """Draw a path, shape (N, 3), oldest first; NaN breaks it. A hand that rests is not drawn again."""
        ends = points_m[[0, -1]] if len(points_m) > 1 else np.zeros((2, 3), np.float32)
        if np.abs(ends - self._ends).max() < _TRAIL_STEP_M:
            return
        self._ends = ends
        pairs = (
            np.stack([points_m[:-1], points_m[1:]], axis=1)
            if len(points_m) > 1
            else np.zeros((0, 2, 3), np.float32)
        )
        sound = np.isfinite(pairs).all(axis=(1, 2))
        recent = np.arange(len(pairs)) >= _TRAIL_OLD_SHARE * len(pairs)
        for line, chosen in ((self._new, sound & recent), (self._old, sound & ~recent)):
            part = pairs[chosen]
            if len(part):
                line.points = part
            if line.visible != bool(len(part)):
                line.visible = bool(len(part))


def halo_opacity(spread_m: float) -> float:
    """Return the opacity of each shell of a halo; zero where nothing, or nothing sensible, is to be shown.

    Parameters
    ----------
    spread_m : float
        Two standard deviations. Below 8 mm the joint itself hides them.
    """
    if not _HALO_LEAST_M <= spread_m <= HALO_MOST_M:
        return 0.0
    return _HALO_OPACITY * min(1.0, _HALO_DENSE_M / spread_m)


class Halo:
    """A soft shell around the elbow or the hand, as wide as two standard deviations of its place."""

    def __init__(self, server: viser.ViserServer, path: str, segment: str, body: BodyDimensions) -> None:
        self._core_m = (0.055 if segment == "forearm" else 0.075) * body.stature_m / 1.70
        middle = 0.0 if segment == "forearm" else -0.5 * body.hand_m
        self._shells = [
            server.scene.add_icosphere(
                f"{path}/halo{number}",
                radius=1.0,
                color=HALO,
                subdivisions=3,
                opacity=_HALO_OPACITY,
                cast_shadow=False,
                receive_shadow=False,
                position=(0.0, 0.0, middle),
                visible=False,
            )
            for number in range(_HALO_SHELLS)
        ]
        self._shown_m = 0.0

    def show(self, spread_m: float) -> None:
        """Resize to two standard deviations; the wider, the thinner."""
        opacity = halo_opacity(spread_m)
        spread_m = spread_m if opacity else 0.0
        if abs(spread_m - self._shown_m) <= 0.12 * self._shown_m:
            return
        for number, shell in enumerate(self._shells):
            if spread_m:
                shell.scale = self._core_m + spread_m * (number + 1) / len(self._shells)
                shell.opacity = opacity
            if shell.visible != (spread_m > 0.0):
                shell.visible = spread_m > 0.0
        self._shown_m = spread_m


def turn(server: viser.ViserServer, frame: Any, wxyz: NDArray[np.float32]) -> None:
    """Send a segment's rotation."""
    server._websock_server.queue_message(wire.SetOrientationMessage(frame.name, tuple(wxyz.tolist())))


def shift(server: viser.ViserServer, frame: Any, position_m: NDArray[np.float32]) -> None:
    """Send a segment's place in its parent."""
    frame.position = position_m
