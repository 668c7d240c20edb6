"""The modules of a magnetic session: the source with its coils, the sensors around it, how well their place is known.

They are drawn instead of the body: what is measured is where one module is from another, not where the body is.
"""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import viser
from numpy.typing import NDArray

from app.viewer.layers import palette
from app.viewer.layers.palette import Rgb
from app.viewer.layers.words import Words
from estimators import rotation
from estimators.magnetic import RelativeFlag
from estimators.pipelines import Frames
from estimators.sentences import Sentence, say

Float32 = NDArray[np.float32]

COILS: Final[tuple[Rgb, Rgb, Rgb]] = ((200, 104, 58), (92, 148, 76), (122, 108, 200))
"""Along x, y and z of the source; the hues of the three lanes of the pulse time line."""
_COIL_ON: Final[Rgb] = (250, 214, 96)
_CASE: Final[Rgb] = (128, 126, 131)
_SENSOR: Final[Rgb] = (236, 232, 226)
_LINK: Final[Rgb] = (140, 140, 146)
_LINK_M: Final = 0.003
_ALONG: Final = np.array([1.0, 0.0, 0.0])
_COIL_RADIUS_M: Final = 0.055
_COIL_OFFSET_M: Final = 0.06
_SIGMAS: Final = 2.0
_ELLIPSE_LEAST_M: Final = 0.004
_ELLIPSE_MOST_M: Final = 0.6
_PLACE_LOST_M: Final = 0.5
_UP: Final = np.array([0.0, 0.0, 1.0], dtype=np.float32)
_LABEL_SCALE: Final = 1.3
_LABEL_ABOVE_M: Final = 0.07
_LABEL_BELOW_M: Final = 0.11
_LONE: Final = int(RelativeFlag.INERTIAL_ONLY | RelativeFlag.FAULT | RelativeFlag.INVALID)


@dataclass(frozen=True)
class ModuleTrack:
    """Source and sensors over K ticks.

    Attributes
    ----------
    names : tuple of str
        Placements, the source first.
    place_m : ndarray of float32, shape (K, N, 3)
        In the room; NaN where it is not known.
    wxyz : ndarray of float32, shape (K, N, 4)
    ellipse_m : ndarray of float32, shape (K, N - 1, 3)
        Half axes of two standard deviations of a sensor's place.
    ellipse_wxyz : ndarray of float32, shape (K, N - 1, 4)
        Their directions in the room.
    lone : ndarray of bool, shape (K, N - 1)
        The place goes on without the source.
    coil : ndarray of int, shape (K,)
        Which coil is on, from 1; 0 for none.
    """

    names: tuple[str, ...]
    place_m: Float32
    wxyz: Float32
    ellipse_m: Float32
    ellipse_wxyz: Float32
    lone: NDArray[np.bool_]
    coil: NDArray[np.int64]

    @property
    def height_m(self) -> float:
        """Middle of what is mostly seen, above the floor."""
        low, high = self._extent_m()
        return float(0.5 * (low[2] + high[2]))

    @property
    def size_m(self) -> float:
        """Largest extent of what is mostly seen, with the source and room for words."""
        low, high = self._extent_m()
        reach = 2.0 * np.maximum(np.abs(low[:2]), np.abs(high[:2])).max()
        return float(max(reach, high[2] - low[2] + 0.3, 0.6))

    def _extent_m(self) -> tuple[Float32, Float32]:
        known = self.place_m[np.isfinite(self.place_m).all(axis=2)]
        if not len(known):
            return np.zeros(3, np.float32), np.zeros(3, np.float32)
        # A moment far out is not to make everything else small.
        return np.percentile(known, 2.0, axis=0), np.percentile(known, 98.0, axis=0)


def distance_words(placement: str, distance_m: float, *, is_lone: bool) -> Sentence:
    """Return what is written at a sensor: where it is worn and how far from the source.

    Parameters
    ----------
    is_lone : bool
        The place goes on without the source: the distance is then not shown as if it were measured.
    """
    if is_lone:
        return say("viewer.distance_about", place=placement, distance_m=distance_m)
    return say("viewer.distance", place=placement, distance_m=distance_m)


def modules_of(frames: Frames) -> ModuleTrack | None:
    """Return the modules in frames; None when they are of another pipeline."""
    scalars = frames.layout.scalars
    if "source_coil" not in scalars:
        return None

    def column(name: str) -> NDArray[np.float64]:
        return frames.scalar[:, scalars.index(name)]

    axes, turns, lone = [], [], []
    place = frames.point_room_m.astype(np.float32)
    for number, name in enumerate(frames.layout.segments[1:], start=1):
        sigma = np.stack([column(f"{name}_{axis}_sigma_m") for axis in "xyz"], axis=1)
        covariance = sigma[:, :, None] * sigma[:, None, :]
        for a, b in ((0, 1), (0, 2), (1, 2)):
            shared = column(f"{name}_{'xyz'[a]}{'xyz'[b]}_correlation")
            covariance[:, a, b] *= shared
            covariance[:, b, a] *= shared
        # After seconds without the source it may be anywhere: then nothing is drawn rather than something wrong.
        place[(sigma > _PLACE_LOST_M).any(axis=1), number] = np.nan
        known = np.asarray(
            np.isfinite(covariance).all(axis=(1, 2)) & np.isfinite(place[:, number]).all(axis=1)
        )
        variance, vectors = np.linalg.eigh(np.where(known[:, None, None], covariance, np.eye(3) * 1e-8))
        # Right-handed, so that it is a rotation.
        vectors[:, :, 2] *= np.sign(np.linalg.det(vectors))[:, None]
        axes.append(np.where(known[:, None], _SIGMAS * np.sqrt(np.maximum(variance, 0.0)), 0.0))
        turns.append(rotation.multiply(frames.q_room_segment[:, 0], rotation.from_matrix(vectors)))
        lone.append((np.nan_to_num(column(f"{name}_state"), nan=1.0).astype(np.int64) & _LONE) != 0)
    return ModuleTrack(
        names=frames.layout.segments,
        place_m=place,
        wxyz=np.nan_to_num(frames.q_room_segment).astype(np.float32),
        ellipse_m=np.stack(axes, axis=1).astype(np.float32),
        ellipse_wxyz=np.stack(turns, axis=1).astype(np.float32),
        lone=np.stack(lone, axis=1),
        coil=np.nan_to_num(column("source_coil")).astype(np.int64),
    )


class ModuleLayer:
    """The nodes of source and sensors in one scene.

    Parameters
    ----------
    names : tuple of str
        Placements, the source first.
    words : callable(sentence)
        In the language of the page.
    """

    def __init__(self, server: viser.ViserServer, names: tuple[str, ...], words: Words) -> None:
        scene = server.scene
        self.names, self._words = names, words
        self._source = scene.add_frame("/modules/source", show_axes=False)
        scene.add_box("/modules/source/case", color=_CASE, dimensions=(0.05, 0.05, 0.03))
        self._coils = [_add_coil(server, number) for number in range(3)]
        self._coil_on = 0
        self._sensors: list[Any] = []
        self._cases: list[Any] = []
        self._ellipses: list[Any] = []
        self._links: list[Any] = []
        self._labels: list[Any] = []
        # Words hang on nothing that turns, so that they stay above and below.
        self._name = scene.add_label(
            "/modules/name",
            words(say("viewer.source", place=names[0])),
            font_screen_scale=_LABEL_SCALE,
            anchor="top-center",
        )
        for number, _ in enumerate(names[1:]):
            path = f"/modules/sensor{number}"
            self._sensors.append(scene.add_frame(path, axes_length=0.07, axes_radius=0.0025))
            self._cases.append(scene.add_box(f"{path}/case", color=_SENSOR, dimensions=(0.05, 0.036, 0.014)))
            self._ellipses.append(
                scene.add_icosphere(
                    f"/modules/ellipse{number}",
                    radius=1.0,
                    color=palette.HALO,
                    opacity=0.35,
                    cast_shadow=False,
                    receive_shadow=False,
                    visible=False,
                )
            )
            self._labels.append(
                scene.add_label(
                    f"/modules/name{number}",
                    "",
                    visible=False,
                    font_screen_scale=_LABEL_SCALE,
                    anchor="bottom-center",
                )
            )
            self._links.append(
                scene.add_box(
                    f"/modules/link{number}",
                    color=_LINK,
                    dimensions=(1.0, _LINK_M, _LINK_M),
                    cast_shadow=False,
                    visible=False,
                )
            )

    def show(self, track: ModuleTrack, tick: int) -> None:
        """Show one tick."""
        place, turn = track.place_m[tick], track.wxyz[tick]
        self._source.position, self._source.wxyz = place[0], turn[0]
        self._name.position = place[0] - _UP * _LABEL_BELOW_M
        coil = int(track.coil[tick])
        if coil != self._coil_on:
            for number, ring in enumerate(self._coils):
                ring.colors = np.array(_COIL_ON if number + 1 == coil else COILS[number], dtype=np.uint8)
            self._coil_on = coil
        for i, sensor in enumerate(self._sensors):
            known = bool(np.isfinite(place[i + 1]).all())
            lone = bool(track.lone[tick, i])
            ellipse, link, label = self._ellipses[i], self._links[i], self._labels[i]
            axes = np.clip(track.ellipse_m[tick, i], 0.0, _ELLIPSE_MOST_M)
            is_wide = bool(axes.max() > _ELLIPSE_LEAST_M)
            for node, on in ((sensor, known), (link, known), (label, known), (ellipse, known and is_wide)):
                if node.visible != on:
                    node.visible = on
            if not known:
                continue
            sensor.position, sensor.wxyz = place[i + 1], turn[i + 1]
            colour = palette.LOST if lone else _SENSOR
            if tuple(self._cases[i].color) != colour:
                self._cases[i].color = colour
            way = place[i + 1] - place[0]
            distance_m = float(np.linalg.norm(way))
            words = self._words(distance_words(self.names[i + 1], distance_m, is_lone=lone))
            if label.text != words:
                label.text = words
            label.position = place[i + 1] + _UP * _LABEL_ABOVE_M
            link.position, link.scale = place[0] + 0.5 * way, (max(distance_m, 1e-3), 1.0, 1.0)
            link.wxyz = rotation.shortest(_ALONG, way.astype(np.float64))
            if ellipse.visible:
                ellipse.position, ellipse.wxyz = place[i + 1], track.ellipse_wxyz[tick, i]
                x, y, z = np.maximum(axes, 1e-3).tolist()
                ellipse.scale = (x, y, z)


def _add_coil(server: viser.ViserServer, number: int) -> Any:
    """Draw a coil as a thick ring, its axis along x, y or z of the source, out where it is worn."""
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    ring = np.zeros((49, 3), dtype=np.float32)
    ring[:, (number + 1) % 3] = _COIL_RADIUS_M * np.cos(angle)
    ring[:, (number + 2) % 3] = _COIL_RADIUS_M * np.sin(angle)
    ring[:, number] = _COIL_OFFSET_M
    return server.scene.add_line_segments(
        f"/modules/source/coil{number}",
        np.stack([ring[:-1], ring[1:]], axis=1),
        colors=COILS[number],
        thickness=6.0,
        thickness_units="screen",
    )
