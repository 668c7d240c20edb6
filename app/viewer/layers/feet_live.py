"""Feet of a live walk brought onto one course: each foot's world begins with the heading of its own sensor."""

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.viewer.layers.feet import FeetTrack, Footprint, has_moved, heading_of
from estimators import rotation

_SEEN_M: Final = 0.5
"""So far a foot must have come before its way says where the walk goes."""
_CERTAIN_M: Final = 2.0
"""From here on the course is fixed: later turns are turns."""
_PRINTS: Final = 120
_TRAIL_EVERY: Final = 3
_TRAIL_POINTS: Final = 140
_FOLLOWED_SHARE: Final = 0.02
"""Of the way to the walker that the picture goes in a tick."""


@dataclass
class _Foot:
    """What is known of one foot so far; places and rotations as they come, before they are turned."""

    q_standing: NDArray[np.float64] | None = None
    places_m: list[NDArray[np.float64]] = field(default_factory=list)
    turns: list[NDArray[np.float64]] = field(default_factory=list)
    course_rad: float = 0.0
    is_certain: bool = False

    def notice(self, place_m: NDArray[np.float64], q: NDArray[np.float64]) -> None:
        """Take a tick at which the foot stands."""
        if self.q_standing is None:
            self.q_standing = q
        last = self.places_m[-1] if self.places_m else None
        before = None if last is None else Footprint(0, 0, (last[0], last[1], last[2]), 0.0)
        if not has_moved(before, place_m):
            return
        self.places_m.append(place_m)
        self.turns.append(q)
        way = self.places_m[-1][:2] - self.places_m[0][:2]
        gone_m = float(np.hypot(*way))
        if gone_m > _SEEN_M and not self.is_certain:
            self.course_rad = float(np.arctan2(way[1], way[0]))
            self.is_certain = gone_m > _CERTAIN_M
        del (
            self.places_m[1 : max(1, len(self.places_m) - _PRINTS)],
            self.turns[1 : max(1, len(self.turns) - _PRINTS)],
        )

    def placed(self, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return places, shape (..., 3), with x along the course."""
        if not self.places_m:
            return place_m
        start = self.places_m[0]
        return np.asarray(rotation.rotate(rotation.about_z(-self.course_rad), place_m - start) + start)

    def turned(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return rotations of the shoe, shape (..., 4): flat and along the course where it first stood."""
        if self.q_standing is None:
            return np.broadcast_to(rotation.identity(), q.shape).copy()
        course = rotation.about_z(self.course_rad)
        since = rotation.multiply(q, rotation.conjugate(self.q_standing))
        return rotation.multiply(rotation.multiply(rotation.conjugate(course), since), course)


class LiveCourse:
    """Turns the feet of a live walk onto a common course, and remembers their prints."""

    def __init__(self) -> None:
        self._feet: list[_Foot] = []
        self._followed: NDArray[np.float64] | None = None
        self._trails: tuple[deque[NDArray[np.float32]], ...] = (
            deque(maxlen=_TRAIL_POINTS),
            deque(maxlen=_TRAIL_POINTS),
        )
        self._ticks = 0

    def turned(self, track: FeetTrack) -> FeetTrack:
        """Return the newest ticks as they are drawn, with all prints so far.

        Parameters
        ----------
        track : FeetTrack
            The newest ticks, in the worlds of the sensors, or in a room of both feet: then nothing is turned.
        """
        if len(self._feet) != len(track.sides):
            self._feet = [_Foot() for _ in track.sides]
        place, wxyz = track.place_m.astype(np.float64), track.wxyz.astype(np.float64)
        prints = []
        for number, foot in enumerate(self._feet):
            for tick in np.flatnonzero(track.stands[:, number] & ~track.lost[:, number]).tolist():
                foot.notice(place[tick, number].copy(), wxyz[tick, number].copy())
            if track.is_in_room:
                prints += [
                    Footprint(0, number, (float(p[0]), float(p[1]), float(p[2])), heading_of(q))
                    for p, q in zip(foot.places_m, foot.turns, strict=True)
                ]
                continue
            place[:, number], wxyz[:, number] = foot.placed(place[:, number]), foot.turned(wxyz[:, number])
            for where, q in zip(foot.places_m, foot.turns, strict=True):
                x, y, z = (float(v) for v in foot.placed(where))
                prints.append(Footprint(0, number, (x, y, z), heading_of(foot.turned(q))))
        return replace(
            track,
            place_m=place.astype(np.float32),
            wxyz=wxyz.astype(np.float32),
            followed_m=self._follow(place[:, :, :2].mean(axis=1)),
            prints=tuple(prints),
            trails_m=self._remembered(track),
        )

    def _remembered(self, track: FeetTrack) -> tuple[NDArray[np.float32], NDArray[np.float32]] | None:
        """Add the newest mass and pressure to their trails; nothing while they are not known."""
        if track.mass_m is None or track.pressure_m is None:
            return None
        for tick in range(len(track.mass_m)):
            self._ticks += 1
            if self._ticks % _TRAIL_EVERY:
                continue
            for trail, points in zip(self._trails, (track.mass_m, track.pressure_m), strict=True):
                if np.isfinite(points[tick]).all():
                    trail.append(points[tick])
        mass, pressure = (np.array(trail, dtype=np.float32).reshape(-1, 3) for trail in self._trails)
        return mass, pressure

    def _follow(self, middle_m: NDArray[np.float64]) -> NDArray[np.float32]:
        followed = np.empty_like(middle_m)
        now = middle_m[0] if self._followed is None else self._followed
        for tick, wanted in enumerate(middle_m):
            now = now + _FOLLOWED_SHARE * (wanted - now)
            followed[tick] = now
        self._followed = now
        return followed.astype(np.float32)
