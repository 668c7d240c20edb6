"""Sensor-to-segment orientation from movements of the arm, made by the patient or by someone else."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.calibration._contract import UNUSABLE_SCORE, Calibration
from estimators.calibration._mounting import OUTWARD_HEADING_RAD
from estimators.calibration._n_pose import n_pose
from estimators.calibration._placement import MisplacedError, check_sides
from estimators.calibration._rest import Verdict, mean_orientation, wrapped
from estimators.calibration._static import static_bias
from estimators.calibration.movement.functional_arm import ArmFrames, ArmMovements, arm_frames
from estimators.calibration.movement.functional_verdicts import JudgedSession, limb_of, upper_arm_of
from estimators.calibration.movement.joint_axes import AxisEstimate, heading_between, principal_axis
from estimators.conventions import SIDES, Placement, Side
from estimators.errors import CalibrationError, SetupError
from estimators.recording import Float
from estimators.sentences import say

KINDS: Final = ("elbow_flexion", "pronation", "raise_forward", "raise_sideways")
"""The movements; each with `_left` or `_right` appended, and `rest` beside them."""
_PERSON_RAD: Final = math.radians(5.0)
_PLACED_RAD: Final = math.radians(8.0)
"""How far a sensor put on by hand faces off the mounting rule."""
_BY_THE_RULE_RAD: Final = math.radians(20.0)
_FLAT: Final = math.sin(math.radians(55.0))
_UPRIGHT: Final = ("sternum", "pelvis", "head")
"""What is upright also on a chair."""
_SWUNG_RAD: Final = math.radians(25.0)
_COMPASS_RAD: Final = math.radians(10.0)
_CONTRADICTION_RAD: Final = math.radians(12.0)


@dataclass(frozen=True)
class FunctionalResult:
    """What movements showed.

    Attributes
    ----------
    calibration : Calibration
        Method `functional` or `assisted`.
    axes : tuple of AxisEstimate
        Every movement with its axis, range and uncertainty, to be shown.
    sigma_rad : dict of Placement to float
        Expected error of a segment's frame about the axis that is known least.
    facing_sigma_rad : float
        Of where the patient faces; NaN if only the mounting rule gives it.
    """

    calibration: Calibration
    axes: tuple[AxisEstimate, ...]
    sigma_rad: dict[Placement, float]
    facing_sigma_rad: float


def functional(
    q_earth_sensor: Float,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    placements: Sequence[Placement],
    movements: Mapping[str, tuple[int, int]],
    flags: NDArray[np.uint8] | None = None,
    *,
    time_step_s: float = 0.01,
    assisted: bool = False,
    rest_pronation_rad: float = 0.5 * math.pi,
) -> FunctionalResult:
    """Find how every sensor sits on its segment from movements and a moment of rest.

    Parameters
    ----------
    q_earth_sensor : ndarray, shape (S, K, 4)
        Orientations from the running filter at every tick.
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (S, K, 3)
    placements : sequence of Placement, length S
    movements : mapping of str to (start, stop)
        Ticks `[start, stop)` of `rest` and of movements, named `elbow_flexion_right`, `pronation_right`,
        `raise_forward_right`, `raise_sideways_right` and alike on the left; both sides may share a stretch.
        Each begins at its starting posture: straight elbow, hanging arm. The palm may be turned either way first.
    flags : ndarray of uint8, shape (S, K), optional
        `OrientationFlag` bits; absent means sound and with a shared heading.
    assisted : bool
        The arm is moved by someone else, seated: smaller movements are taken, and the rest need not be an
        N-pose (the trunk upright, the upper arm roughly hanging). Less is known, and the result says how much.
    rest_pronation_rad : float
        Pronation of the forearm at rest: +90 degrees with the thumb forward or up, as in the N-pose.

    Raises
    ------
    CalibrationError
        If something is missing or too small, with what to redo.
    SetupError
        For an unknown movement.

    Notes
    -----
    Facing: the arms' axes when raised forward (the lateral axis) and sideways (the forward axis). Raising both
    arms alike cancels what either deviates outward; sensors near the mounting rule are weighed in. Humerus:
    flexion axis of the elbow and gravity at rest (its long axis); Wu et al. (2005), option 2. Forearm: pronation
    axis, gravity, and the angle of the palm at rest. Hand: in line with the forearm at rest. Everything else
    worn: as in the N-pose, with this facing.
    Without a common heading (no magnetometer) the raised arm also tells the headings of its sensors against
    the patient and each other; the trunk's is by the mounting rule.
    """
    session = _Session(q_earth_sensor, gyroscope_radps, accelerometer_mps2, placements, flags, time_step_s)
    _check(movements, q_earth_sensor.shape[1])
    return session.calibrate(movements, assisted, rest_pronation_rad)


def _check(movements: Mapping[str, tuple[int, int]], ticks: int) -> None:
    known = {f"{kind}_{side}" for kind in KINDS for side in SIDES} | {"rest"}
    if unknown := sorted(set(movements) - known):
        raise SetupError(f"no movement {', '.join(unknown)}; known are {', '.join(sorted(known))}")
    if "rest" not in movements:
        raise CalibrationError(say("calibration.rest_missing"), redo=["rest"])
    for name, (start, stop) in movements.items():
        if not 0 <= start < stop <= ticks:
            raise SetupError(f"{name} is [{start}, {stop}); the samples are [0, {ticks})")


class _Session(JudgedSession):
    """What is found from the samples of a calibration."""

    def calibrate(
        self, movements: Mapping[str, tuple[int, int]], assisted: bool, rest_pronation_rad: float
    ) -> FunctionalResult:
        rest = slice(*movements["rest"])
        gyroscope, accelerometer = self.gyroscope[:, rest], self.accelerometer[:, rest]
        found = static_bias(gyroscope, accelerometer, self.step_s, require_still=False, names=self.placements)
        self.bias = found.gyroscope_bias_radps
        sides = [side for side in SIDES if self._can(side, movements)]
        if not sides:
            raise CalibrationError(say("calibration.no_arm_moved"))
        rests = [
            mean_orientation(self.q[s, rest], self.flags[s, rest], p, Verdict(), seated=assisted)
            for s, p in enumerate(self.placements)
        ]
        self.q_rest = np.stack(rests)
        self.check_segments(sides, movements)
        raises = self._raises(sides, movements, assisted)
        stated, facing_sigma = self._facing(raises, assisted)
        facing_known = 0.0 if math.isnan(facing_sigma) else facing_sigma
        moved = {p for side in sides for p in limb_of(side)} & set(self.placements)
        base = self._others(moved, rest, stated, facing_known, assisted)
        facing = base.facing_rad
        offsets = self._limb_headings(sides, movements, raises, facing)
        q_sensor_segment = dict(base.q_sensor_segment)
        sigma: dict[Placement, float] = {}
        mounting_sigma = dict(base.mounting_sigma_rad)
        for side in sides:
            arm = self._arm(side, movements, offsets)
            frames = arm_frames(arm, assisted=assisted, rest_pronation_rad=rest_pronation_rad)
            self._judge_arm(side, frames, assisted)
            for placement, (q, s) in frames.segments.items():
                w, x, y, z = (float(v) for v in q)
                q_sensor_segment[placement] = (w, x, y, z)
                sigma[placement] = s
                about_x, about_y, about_z = (float(v) for v in frames.sigma_rad[placement])
                mounting_sigma[placement] = (about_x, about_y, about_z)
        self.judge_sigma(sigma, facing_sigma)
        self.judge_trunk(facing, facing_sigma)
        score = self.verdict.score * base.score
        reasons = (*self.verdict.reasons, *base.reasons)
        if score < UNUSABLE_SCORE and not assisted:
            raise CalibrationError(say("calibration.movements_unusable", reasons=reasons))
        calibration = Calibration(
            q_sensor_segment=q_sensor_segment,
            gyroscope_bias_radps={
                p: (float(b[0]), float(b[1]), float(b[2]))
                for p, b in zip(self.placements, self.bias, strict=True)
            },
            facing_rad=facing,
            heading_offset_rad={**base.heading_offset_rad, **offsets},
            method="assisted" if assisted else "functional",
            score=score,
            reasons=reasons,
            mounting_sigma_rad=mounting_sigma,
        )
        return FunctionalResult(calibration, tuple(self.axes), sigma, facing_sigma)

    def _judge_arm(self, side: Side, frames: ArmFrames, assisted: bool) -> None:
        self.axes += [frames.flexion, frames.pronation]
        self.judge_ranges((frames.flexion, frames.pronation), assisted)
        if frames.disagreement_rad > _CONTRADICTION_RAD:
            self.verdict.lower(
                _CONTRADICTION_RAD / frames.disagreement_rad,
                say("calibration.contradiction", side=side, angle_rad=frames.disagreement_rad),
            )

    def _can(self, side: Side, movements: Mapping[str, tuple[int, int]]) -> bool:
        worn = {f"upper_arm_{side}", f"forearm_{side}"} <= set(self.placements)
        made = [kind for kind in ("elbow_flexion", "pronation") if f"{kind}_{side}" in movements]
        if worn and len(made) == 1:
            missing = "pronation" if made == ["elbow_flexion"] else "elbow_flexion"
            raise CalibrationError(
                say("calibration.movement_missing", side=side, kind=missing), redo=[missing]
            )
        return worn and bool(made)

    def _raises(
        self, sides: Sequence[Side], movements: Mapping[str, tuple[int, int]], assisted: bool
    ) -> dict[str, AxisEstimate]:
        """Axes about which the arms were raised, in the upper arm's earth frame, by name of the movement."""
        found = {}
        for side in sides:
            upper = self.placements.index(upper_arm_of(side))
            for kind in ("raise_forward", "raise_sideways"):
                name = f"{kind}_{side}"
                if name in movements:
                    rates = self.rate_earth(upper, movements[name])
                    found[name] = principal_axis(name, rates, self.step_s)
                    tilt = abs(math.asin(min(1.0, abs(float(found[name].axis[2])))))
                    if tilt > _SWUNG_RAD:
                        self.verdict.lower(
                            _SWUNG_RAD / tilt,
                            say("calibration.swung", side=side, kind=kind),
                        )
        self.axes += found.values()
        self.judge_ranges(found.values(), assisted)
        both = {
            side: (found[f"raise_forward_{side}"].axis, found[f"raise_sideways_{side}"].axis)
            for side in sides
            if f"raise_forward_{side}" in found and f"raise_sideways_{side}" in found
        }
        if swapped := check_sides(both):
            raise MisplacedError(swapped)
        return found

    def _facing(self, raises: Mapping[str, AxisEstimate], assisted: bool) -> tuple[float | None, float]:
        """Where the patient faces, in the common earth frame; None where the mounting rule must tell.

        Sensors that sit nearly as the mounting rule says are witnesses beside the arms that were raised.
        """
        total, weight = complex(0.0), 0.0
        for name, axis in raises.items():
            side: Side = "left" if name.endswith("left") else "right"
            if self._is_own(side):
                continue
            sigma = math.hypot(axis.sigma_rad, _PERSON_RAD)
            total += complex(math.cos(a := _implied_facing(name, axis)), math.sin(a)) / sigma**2
            weight += 1.0 / sigma**2
        if weight == 0.0:
            return None, float("nan")
        if abs(total) / weight < math.cos(math.radians(35.0)):
            raise CalibrationError(say("calibration.raises_apart"))
        stated = math.atan2(total.imag, total.real)
        for s, placement in enumerate(self.placements):
            outward = rotation.rotate(self.q_rest[s], [0.0, 0.0, 1.0])
            if self.own_heading[s] or abs(outward[2]) > _FLAT or (assisted and placement not in _UPRIGHT):
                continue
            implied = math.atan2(outward[1], outward[0]) - OUTWARD_HEADING_RAD[placement]
            if abs(wrapped(implied - stated)) < _BY_THE_RULE_RAD:
                total += complex(math.cos(implied), math.sin(implied)) / _PLACED_RAD**2
                weight += 1.0 / _PLACED_RAD**2
        return math.atan2(total.imag, total.real), 1.0 / math.sqrt(weight)

    def _is_own(self, side: Side) -> bool:
        """Whether a sensor of this arm has no common heading, so that the arm must find its own."""
        return any(self.own_heading[self.placements.index(p)] for p in limb_of(side) if p in self.placements)

    def _limb_headings(
        self,
        sides: Sequence[Side],
        movements: Mapping[str, tuple[int, int]],
        raises: Mapping[str, AxisEstimate],
        facing: float,
    ) -> dict[Placement, float]:
        """Offsets of sensors of moved arms that have no common heading; checks those that have one."""
        offsets: dict[Placement, float] = {}
        for side in sides:
            upper = upper_arm_of(side)
            own = self._is_own(side)
            names = [name for name in raises if name.endswith(side)]
            if own:
                if not names:
                    raise CalibrationError(say("calibration.arm_no_compass", side=side))
                total = sum(complex(math.cos(a := _implied_facing(n, raises[n])), math.sin(a)) for n in names)
                offsets[upper] = wrapped(facing - math.atan2(total.imag, total.real))
            for placement in limb_of(side)[1:]:
                if placement not in self.placements or not names:
                    continue
                s = self.placements.index(placement)
                pair = [
                    np.concatenate([self.rate_earth(k, movements[n]) for n in names])
                    for k in (self.placements.index(upper), s)
                ]
                turn, coherence = heading_between(pair[0], pair[1])
                if own:
                    offsets[placement] = wrapped(offsets[upper] + turn)
                elif coherence > 0.8 and abs(turn) > _COMPASS_RAD:
                    self.verdict.lower(
                        0.7,
                        say("calibration.compasses_apart", where=[placement, upper], angle_rad=abs(turn)),
                    )
        return offsets

    def _others(
        self, moved: set[Placement], rest: slice, facing: float | None, facing_sigma: float, assisted: bool
    ) -> Calibration:
        """Everything that did not move: as in the N-pose, with the facing that the arms showed."""
        others = [s for s, p in enumerate(self.placements) if p not in moved]
        if assisted:
            others = [s for s in others if self.placements[s] in _UPRIGHT]
        if not others:
            # Without compass and trunk sensor the frame is free: the patient faces its x axis.
            return Calibration({}, {}, facing_rad=facing or 0.0)
        return n_pose(
            self.q[others, rest],
            self.gyroscope[others, rest],
            self.accelerometer[others, rest],
            [self.placements[s] for s in others],
            self.flags[others, rest],
            time_step_s=self.step_s,
            facing_rad=facing,
            facing_sigma_rad=facing_sigma,
        )

    def _arm(
        self,
        side: Side,
        movements: Mapping[str, tuple[int, int]],
        offsets: Mapping[Placement, float],
    ) -> ArmMovements:
        """Gather one arm's orientations and rates in one common earth frame."""
        limb = [p for p in limb_of(side) if p in self.placements]
        q, rates = {}, {}
        ticks = {kind: movements.get(f"{kind}_{side}") for kind in KINDS}
        for p in limb:
            s = self.placements.index(p)
            turn = rotation.about_z(offsets.get(p, 0.0))
            for kind, part in ticks.items():
                if part is not None:
                    q[p, kind] = rotation.multiply(turn, self.q[s, slice(*part)])
                    rates[p, kind] = rotation.rotate(turn, self.rate_earth(s, part))
            q[p, "rest"] = rotation.multiply(turn, self.q_rest[s])
        return ArmMovements(side, tuple(limb), q, rates, self.step_s)


def _implied_facing(name: str, axis: AxisEstimate) -> float:
    """Heading of the patient that a raised arm implies, in the earth frame of its axis.

    Raised forward both arms turn about -y of the room, sideways the right about -x and the left about +x.
    """
    heading = math.atan2(float(axis.axis[1]), float(axis.axis[0]))
    if name.startswith("raise_forward"):
        return wrapped(heading + 0.5 * math.pi)
    return wrapped(heading if name.endswith("left") else heading + math.pi)
