"""A two-segment foot over time: pitch by splines, contact by geometry, swing by a quintic; all exact."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from estimators.conventions import Side
from estimators.kinetics import ShoeGeometry
from estimators.simulation.arm.kinematics import (
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Path,
    Scalar,
    Turn,
    carried,
    compose,
    turn_about,
)
from estimators.simulation.arm.timeline import minimum_jerk, quintic
from estimators.simulation.gait.course import FootStyle, Stance

Float = NDArray[np.float64]
Motion = TypeVar("Motion", Turn, Path)
Knot = tuple[float, float, float, float]
"""Time in s, pitch in degrees, its rate and acceleration."""

REFERENCE_STRIDE_S = 1.3
"""Stride for which the rates of the splines are written; they scale with it."""
FLAT_AFTER = 0.10
HEEL_OFF_BEFORE = 0.20
TIPPING_BEFORE = 0.08
"""Parts of a stride: landing to flat; heel-off to lift; tipping over the toes to lift."""
_ROLL_RAD = float(np.radians(4.0))


@dataclass(frozen=True)
class FootMotion:
    """One foot over time.

    Attributes
    ----------
    heel, forefoot, shank : Turn
        In the room; the forefoot equals the heel while the foot is straight.
    flat, contact : ndarray of bool, shape (N,)
    cop_local_m : ndarray, shape (N,)
        Along the flat sole, from the heel sensor; meaningless in the air.
    sole_floor_m, sole_yaw_rad : ndarray, shape (N, 3) and (N,)
        Foothold of the stance at hand (of the next one in the air): below the heel sensor, on the floor.
    """

    heel: Turn
    forefoot: Turn
    shank: Turn
    heel_sensor: Path
    forefoot_sensor: Path
    hinge: Path
    ankle: Path
    flat: NDArray[np.bool_]
    contact: NDArray[np.bool_]
    cop_local_m: Float
    sole_floor_m: Float
    sole_yaw_rad: Float


class Foot:
    """One foot of a plan; `at` gives any increasing instants.

    Parameters
    ----------
    stride_s : float
        Nominal stride time, which scales the phases within a stance.
    """

    def __init__(
        self, side: Side, stances: list[Stance], style: FootStyle, shoe: ShoeGeometry, stride_s: float
    ) -> None:
        self._sign = 1.0 if side == "left" else -1.0
        self._stances, self._style, self._shoe, self._stride_s = stances, style, shoe, stride_s
        self._rate = REFERENCE_STRIDE_S / stride_s
        self._pitch = [
            _table(knots) for knots in (self._heel_knots(), self._forefoot_knots(), self._shank_knots())
        ]

    def flat_s(self, stance: Stance) -> tuple[float, float]:
        """Return when a stance is flat, from and to."""
        return (
            stance.land_s + FLAT_AFTER * self._stride_s,
            stance.lift_s - HEEL_OFF_BEFORE * self._stride_s,
        )

    def tipping_s(self, stance: Stance) -> float:
        """Return when a stance begins to tip over the toes."""
        return stance.lift_s - TIPPING_BEFORE * self._stride_s

    def at(self, time_s: Float) -> FootMotion:
        """Return the foot at `time_s`, shape (N,)."""
        count = len(self._stances)
        lands = np.array([stance.land_s for stance in self._stances])
        lifts = np.array([stance.lift_s for stance in self._stances])
        # The stance at hand, or in the air the one to come.
        index = np.clip(np.searchsorted(lifts, time_s, side="left"), 0, count - 1)
        contact = time_s >= lands[index]
        heel, forefoot, shank = self._turns(time_s, index, contact)
        hinge = Path(*(np.empty((time_s.size, 3)) for _ in range(3)))
        flat = np.zeros(time_s.size, dtype=np.bool_)
        cop = np.zeros(time_s.size)
        for number, stance in enumerate(self._stances):
            here = np.flatnonzero((index == number) & contact)
            flat_from, flat_to = self.flat_s(stance)
            flat[here] = (time_s[here] >= flat_from) & (time_s[here] <= flat_to)
            _put(hinge, here, self._contact(stance, time_s[here], _take(heel, here), _take(forefoot, here)))
            cop[here] = self._cop_local(stance, time_s[here])
            air = np.flatnonzero((index == number) & ~contact)
            if number and air.size:
                _put(hinge, air, self._swing(self._stances[number - 1], stance, time_s[air]))
        shoe = self._shoe
        heel_sensor = carried(hinge, heel, -shoe.hinge_point_m)
        return FootMotion(
            heel,
            forefoot,
            shank,
            heel_sensor,
            carried(hinge, forefoot, shoe.forefoot_sensor_point_m),
            hinge,
            carried(heel_sensor, heel, shoe.ankle_m),
            flat,
            contact,
            cop,
            np.array([stance.position_m for stance in self._stances])[index],
            np.array([stance.yaw_rad for stance in self._stances])[index],
        )

    def _turns(
        self, time_s: Float, index: NDArray[np.int64], contact: NDArray[np.bool_]
    ) -> tuple[Turn, Turn, Turn]:
        """Yaw and roll change in the air only; pitch follows the splines."""
        yaws = np.array([stance.yaw_rad for stance in self._stances])
        lifts = np.array([stance.lift_s for stance in self._stances])
        lands = np.array([stance.land_s for stance in self._stances])
        before = np.maximum(index - 1, 0)
        air = ~contact & (index > 0)
        start = np.where(air, lifts[before], 0.0)
        duration = np.where(air, lands[index] - start, 1.0)
        step = minimum_jerk(np.where(air, (time_s - start) / duration, 1.0))
        change = yaws[index] - yaws[before]
        yaw = Scalar(
            yaws[before] + change * step.value,
            change * step.rate / duration,
            change * step.acceleration / duration**2,
        )
        roll = _bump(np.where(air, (time_s - start) / duration, 0.0), duration).scaled(
            -self._sign * _ROLL_RAD
        )
        turns = []
        for knot_s, knots in self._pitch:
            pitch = quintic(knot_s, knots, time_s)
            turn = compose(turn_about(Z_AXIS, yaw), turn_about(Y_AXIS, pitch))
            turns.append(compose(turn, turn_about(X_AXIS, roll)))
        return turns[0], turns[1], turns[2]

    def _contact(self, stance: Stance, time_s: Float, heel: Turn, forefoot: Turn) -> Path:
        """Return the hinge of a foot on the ground: pivot on an edge, flat, pivot on the hinge, on the toes."""
        shoe = self._shoe
        flat_turn = turn_about(Z_AXIS, Scalar(np.full(time_s.size, stance.yaw_rad), *_zeros(time_s.size)))
        origin = np.broadcast_to(
            stance.position_m + np.array([0.0, 0.0, shoe.sensor_height_m]), (time_s.size, 3)
        ).copy()
        flat = carried(
            Path(origin, np.zeros_like(origin), np.zeros_like(origin)), flat_turn, shoe.hinge_point_m
        )
        rear = carried(
            Path(origin, np.zeros_like(origin), np.zeros_like(origin)), flat_turn, shoe.rear_point_m
        )
        toe = carried(flat, flat_turn, shoe.toe_point_m)
        result = Path(flat.position.copy(), flat.velocity.copy(), flat.acceleration.copy())
        landing = np.flatnonzero(time_s < self.flat_s(stance)[0])
        if stance.landing_pitch_rad <= 0.0:
            on_rear = carried(
                _take(rear, landing), _take(heel, landing), shoe.hinge_point_m - shoe.rear_point_m
            )
            _put(result, landing, on_rear)
        else:
            _put(result, landing, carried(_take(toe, landing), _take(heel, landing), -shoe.toe_point_m))
        tipping = np.flatnonzero(time_s > self.tipping_s(stance))
        _put(result, tipping, carried(_take(toe, tipping), _take(forefoot, tipping), -shoe.toe_point_m))
        return result

    def _swing(self, before: Stance, after: Stance, time_s: Float) -> Path:
        """Return the hinge in the air: a quintic between lift and landing with bumps up and outward."""
        ends = []
        for stance, at_s in ((before, before.lift_s), (after, after.land_s)):
            instant = np.array([at_s])
            index = np.array([self._stances.index(stance)])
            heel, forefoot, _ = self._turns(instant, index, np.array([True]))
            ends.append(self._contact(stance, instant, heel, forefoot))
        knots = np.array([[end.position[0], end.velocity[0], end.acceleration[0]] for end in ends])
        curve = quintic(np.array([before.lift_s, after.land_s]), knots, time_s)
        duration = after.land_s - before.lift_s
        bump = _bump((time_s - before.lift_s) / duration, np.full(time_s.size, duration))
        rise = abs(after.position_m[2] - before.position_m[2])
        up = self._style.clearance_m + 0.4 * rise
        outward = self._sign * self._style.circumduction_m
        heading = after.path_heading_rad
        direction = np.array([-outward * np.sin(heading), outward * np.cos(heading), up])
        return Path(*(base + part[:, None] * direction for base, part in zip(curve, bump, strict=True)))

    def _cop_local(self, stance: Stance, time_s: Float) -> Float:
        stride, shoe = self._stride_s, self._shoe
        # While the foot rolls on an edge the ground presses on that edge and so does no work.
        rear, front = shoe.rear_edge_m, shoe.hinge_m + shoe.toe_edge_m
        points: list[tuple[float, float]] = []
        if np.isfinite(stance.land_s):
            if stance.landing_pitch_rad <= 0.0:
                points = [(0.0, rear), (FLAT_AFTER, rear), (FLAT_AFTER + 0.06, 0.0)]
            else:
                points = [(0.0, front), (FLAT_AFTER, front), (FLAT_AFTER + 0.08, 0.09)]
            points = [(stance.land_s + part * stride, x) for part, x in points]
        if stance.rests_to_s > stance.rests_from_s:
            lift_off = stance.lift_s - HEEL_OFF_BEFORE * stride
            first = (
                points[-1][0] + 0.6 if points else min(stance.rests_to_s, time_s[0] if time_s.size else 0.0)
            )
            first = min(first, stance.rests_to_s)
            points.append((first if np.isfinite(first) else 0.0, 0.07))
            last = min(stance.rests_to_s, lift_off - 0.05)
            if np.isfinite(last) and last > points[-1][0] + 1e-3:
                points.append((last, 0.07))
        if np.isfinite(stance.lift_s):
            for part, x in ((HEEL_OFF_BEFORE, 0.16), (TIPPING_BEFORE, front), (0.0, front)):
                points.append((stance.lift_s - part * stride, x))
        times, values = np.array(points).T
        if times.size == 1:
            return np.full(time_s.size, values[0])
        curve = PchipInterpolator(times, values)
        return np.asarray(curve(np.clip(time_s, times[0], times[-1])))

    def _landing(self, stance: Stance) -> float:
        """Return the landing pitch as a part of a healthy one, which is -19 degrees."""
        return float(np.degrees(stance.landing_pitch_rad)) / -19.0

    def _heel_knots(self) -> list[Knot]:
        return self._pitch_knots(((22.0, 230.0), (48.0, 250.0), (58.0, -5000.0)))

    def _forefoot_knots(self) -> list[Knot]:
        return self._pitch_knots(((0.0, 0.0), (26.0, 340.0), (53.0, -5000.0)))

    def _pitch_knots(self, push: tuple[tuple[float, float], ...]) -> list[Knot]:
        """Return the knots of the pitch: flat, push-off, early swing, and the same landing for both."""
        stride, rate, scale = self._stride_s, self._rate, self._style.pitch_scale
        knots: list[Knot] = []
        for number, stance in enumerate(self._stances):
            if np.isfinite(stance.land_s):
                previous = self._stances[number - 1]
                swing = stance.land_s - previous.lift_s
                landing = self._landing(stance)
                middle = max(0.0, 1.5 * float(np.degrees(stance.landing_pitch_rad)))
                falling = -290.0 * max(0.5 * (scale + landing), 0.1)
                knots += [
                    (previous.lift_s + 0.60 * swing, middle, rate * falling, 0.0),
                    (previous.lift_s + 0.90 * swing, -21.0 * landing, 0.0, rate**2 * 600.0 * landing),
                    (stance.land_s, -19.0 * landing, rate * 80.0 * landing, 0.0),
                    (stance.land_s + FLAT_AFTER * stride, 0.0, 0.0, 0.0),
                ]
            if np.isfinite(stance.lift_s):
                following = self._stances[number + 1]
                swing = following.land_s - stance.lift_s
                (tip, tip_rate), (lift, lift_rate), (peak, peak_acceleration) = push
                knots += [
                    (stance.lift_s - HEEL_OFF_BEFORE * stride, 0.0, 0.0, 0.0),
                    (stance.lift_s - TIPPING_BEFORE * stride, scale * tip, scale * rate * tip_rate, 0.0),
                    (stance.lift_s, scale * lift, scale * rate * lift_rate, 0.0),
                    (stance.lift_s + 0.15 * swing, scale * peak, 0.0, scale * rate**2 * peak_acceleration),
                ]
        return knots

    def _shank_knots(self) -> list[Knot]:
        stride, rate, scale = self._stride_s, self._rate, self._style.pitch_scale
        knots: list[Knot] = []
        for number, stance in enumerate(self._stances):
            rests = stance.rests_to_s > stance.rests_from_s
            if np.isfinite(stance.land_s):
                land = stance.land_s
                swing = land - self._stances[number - 1].lift_s
                knots += [
                    (land - 0.25 * swing, 0.0, -240.0 * rate * scale, 0.0),
                    (land, -18.0 * scale, 60.0 * rate * scale, 0.0),
                    (land + 0.10 * stride, -9.0 * scale, 70.0 * rate * scale, 0.0),
                ]
                if rests:
                    knots.append((land + 0.55, 0.0, 0.0, 0.0))
                else:
                    knots.append((land + 0.30 * stride, 4.0 * scale, 50.0 * rate * scale, 0.0))
            if np.isfinite(stance.lift_s):
                lift = stance.lift_s
                swing = self._stances[number + 1].land_s - lift
                if rests:
                    knots.append((lift - 0.20 * stride - 0.3, 0.0, 0.0, 0.0))
                knots += [
                    (lift - 0.20 * stride, 12.0 * scale, 80.0 * rate * scale, 0.0),
                    (lift - 0.08 * stride, 24.0 * scale, 130.0 * rate * scale, 0.0),
                    (lift, 40.0 * scale, 120.0 * rate * scale, 0.0),
                    (lift + 0.25 * swing, 48.0 * scale, 0.0, 0.0),
                ]
        return knots


def _table(knots: list[Knot]) -> tuple[Float, Float]:
    """Return times and, in radians, value, rate and acceleration of knots."""
    table = np.array(knots)
    return table[:, 0], np.radians(table[:, 1:])


def _bump(phase: Float, duration_s: Float) -> Scalar:
    """Return 64 u^3 (1 - u)^3, which is 1 in the middle, with derivatives over time."""
    u = np.clip(phase, 0.0, 1.0)
    rest = 1.0 - u
    return Scalar(
        64.0 * (u * rest) ** 3,
        192.0 * (u * rest) ** 2 * (rest - u) / duration_s,
        384.0 * u * rest * ((rest - u) ** 2 - u * rest) / duration_s**2,
    )


def _zeros(count: int) -> tuple[Float, Float]:
    return np.zeros(count), np.zeros(count)


def _take(motion: Motion, index: NDArray[np.int64]) -> Motion:
    return type(motion)(*(part[index] for part in motion))


def _put(target: Path, index: NDArray[np.int64], source: Path) -> None:
    for whole, part in zip(target, source, strict=True):
        whole[index] = part
