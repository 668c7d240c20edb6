"""Statistics of one sensor's readings, gathered by stretches, to judge whether they can be right."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators._clipping import LEAST_FORCE_RANGE_MPS2, LEAST_RATE_RANGE_RADPS, ClipWatch
from estimators.calibration.field.dip import Dip
from estimators.calibration.force.evidence import ForceEvidence
from estimators.calibration.plausibility.contradiction import Evidence, gather
from estimators.calibration.plausibility.even_sample import EvenSample
from estimators.calibration.plausibility.joined import Joined
from estimators.calibration.plausibility.mistakes import SIGNED_PERMUTATIONS
from estimators.conventions import GRAVITY_MPS2
from estimators.gravity import calm_size
from estimators.recording import Float

_ENOUGH_WINDOWS: Final = 48
"""With so many windows of movement the axes and the unit of a sensor are known."""
_RESTING_S, _RESTING_SPREAD = 0.5, 0.02
_LYING_RADPS, _LYING_SHARE = 0.15, 0.1
"""What a gyroscope reads at most while it lies still: an offset, or in another unit a small share of its movement."""
_EVEN_RADPS, _EVEN_SHARE = 0.05, 0.05
_USUAL_IRON: Final = 0.35
"""Of the field: that much iron may sit on a device that is sound; more of it is worth a word."""
_FEWEST: Final = 3
_WHITE: Final = 0.6
"""Noise of a device is less alike from sample to sample than this; a tremor goes on."""
_SQUARE: Final = 0.05
"""Of a turn: the axes of a device are at right angles to a hundredth, and to each other's, on one that is sold cheaply;
signs of what is seen on the others double it."""
_APART: Final = SIGNED_PERMUTATIONS - np.eye(3)
_APART_PRODUCTS: Final = _APART.transpose(0, 2, 1) @ _APART


class Readings:
    """What is known of the readings of one sensor; feed it stretch by stretch.

    Parameters
    ----------
    name : str
        What to call it.
    clip_levels : ndarray, shape (2, 2, 3), optional
        Of gyroscope and accelerometer, as found before: positive and negative side, axis.
    is_corrected : bool
        Of a whole recording, whose accelerometer will be corrected by what is found; not of a session that goes on.
    """

    def __init__(self, name: str, clip_levels: Float | None = None, *, is_corrected: bool = False) -> None:
        self.name = name
        self.ticks = self.sound_ticks = 0
        self.is_marked_clipped = False
        self.freeze_s = self.longest_freeze_s = 0.0
        """How long the magnetometer has stood still in movement, and the longest that it did without a break."""
        self.time_s = 0.0
        self.step_s = np.nan
        """Between two samples."""
        self.evidence = Evidence.nothing()
        self.joined = Joined()
        self.force = ForceEvidence(keeps_readings=is_corrected)
        self.dip = Dip()
        # A live session goes on for hours: of its stretches nothing is held that grows.
        self.calm = EvenSample()
        self.shaken_mps2 = self.fastest_radps = 0.0
        """The most of any stretch: of the force beside gravity, and of the turn."""
        self._moved = np.zeros(len(SIGNED_PERMUTATIONS))
        self.resting_radps = EvenSample(2)
        """Of each stretch what the gyroscope reads where the force stands still, and its noise there."""
        self.resting_mps2 = EvenSample()
        """Of each stretch the size of the force where the sensor lies still."""
        self.field_t = EvenSample()
        self.field_spread = EvenSample()
        self._still_products, self._still_count = np.zeros((3, 3)), 0
        rate, force = (None, None) if clip_levels is None else clip_levels
        self.rate_clips = ClipWatch(LEAST_RATE_RANGE_RADPS, is_rate=True, known=rate)
        self.force_clips = ClipWatch(LEAST_FORCE_RANGE_MPS2, is_rate=False, known=force)
        self.first: dict[str, Float] = {}
        self.changing: dict[str, NDArray[np.bool_]] = {}

    def add(
        self,
        rate: Float,
        force: Float,
        field: Float | None,
        step_s: float,
        is_bridged: NDArray[np.bool_] | None = None,
    ) -> None:
        """Take a stretch, each shape (N, 3); a sample that is not three finite numbers is missing.

        `is_bridged`, shape (N,), says which samples were interpolated across a gap.
        """
        rate, force = _whole(rate), _whole(force)
        field = None if field is None else _whole(field)
        sound = np.array(np.isfinite(rate).all(axis=1) & np.isfinite(force).all(axis=1))
        self.ticks += len(rate)
        self.sound_ticks += int(sound.sum())
        self.time_s += len(rate) * step_s
        self.step_s = step_s
        if field is not None and not np.isfinite(field).any():
            field = None
        for triad, values in (("gyroscope", rate), ("accelerometer", force), ("magnetometer", field)):
            if values is not None:
                self._watch(triad, values)
        self.rate_clips.add(rate, step_s)
        self.force_clips.add(force, step_s)
        if sound.any() and self.evidence.windows[0 if field is None else 1] < _ENOUGH_WINDOWS:
            self._gather(rate, force, field, step_s)
        else:
            # What comes next does not adjoin it.
            self.joined.forget()
        if not sound.any():
            return
        self.force.add(rate, force, step_s, is_bridged)
        size = np.linalg.norm(force[sound], axis=1)
        turning = np.abs(rate[sound]).max(axis=1)
        about = rate[sound].T @ rate[sound] / int(sound.sum())
        moved = np.einsum("kij,ij->k", _APART_PRODUCTS, about) - _SQUARE**2 * float(np.trace(about))
        np.maximum(self._moved, moved, out=self._moved)
        calm = calm_size(force, step_s)
        if not math.isfinite(calm):
            return
        self.calm.add(calm)
        # Over gravity as the device reads it: its unit may be wrong.
        shaken = float(np.percentile(np.abs(size - np.median(size)), 99.0)) / max(calm, 1e-300)
        self.shaken_mps2 = max(self.shaken_mps2, shaken * GRAVITY_MPS2)
        fastest = float(np.percentile(turning, 99.0))
        self.fastest_radps = max(self.fastest_radps, fastest)
        self._rest(rate, force, field, step_s, fastest)
        if field is not None:
            self._strength(field[np.isfinite(field).all(axis=1)])

    def _strength(self, field: Float) -> None:
        """Note the size of the field, and how it varies beside what iron makes of it that moves with the sensor."""
        size = np.linalg.norm(field, axis=1)
        middle = float(np.median(size))
        iron = self.dip.iron()
        if float(np.linalg.norm(iron)) > _USUAL_IRON * middle:
            iron = np.zeros(3)
        spread = min(float(np.std(size)), float(np.std(np.linalg.norm(field - iron, axis=1))))
        self.field_t.add(middle)
        self.field_spread.add(spread / max(middle, 1e-300))

    @property
    def still_product(self) -> Float | None:
        """Mean of up times the field where the sensor lay still, as directions, shape (3, 3); None if it never did."""
        return self._still_products / self._still_count if self._still_count else None

    def moved(self, mapping: Float) -> float:
        """Return how much a signed permutation changes the rate: the largest mean square of a stretch, (rad/s)^2.

        Less what it changes of a turn about one axis alone, of which a device shows some on the others.
        """
        return float(self._moved[(mapping == SIGNED_PERMUTATIONS).all(axis=(1, 2))][0])

    @property
    def dip_rad(self) -> float:
        """How steeply the field points down, zero without a field; NaN while that is not known."""
        if not self.field_t:
            return 0.0
        sine, _ = self.dip_sine()
        return math.nan if math.isnan(sine) else math.asin(min(max(sine, -1.0), 1.0))

    def dip_sine(self) -> tuple[float, bool]:
        """Return the sine of the angle by which the field points down, NaN while unknown, and whether movement says it.

        At rest nothing separates the field of the room from that of iron on the sensor. Where movement finds that iron
        in the room bends the field, rest beside it says no more.
        """
        sine, product = self.dip.sine(), self.still_product
        if not math.isnan(sine) or product is None or self.dip.is_bent:
            return sine, not math.isnan(sine)
        return -float(np.trace(product)), False

    def add_freezes(self, lost: NDArray[np.bool_] | None, step_s: float) -> None:
        """Take which samples of a stretch lost their field alone, None for none; one freeze may go on from the last."""
        if lost is None:
            self.freeze_s = 0.0
            return
        ends = np.concatenate(([-1], np.flatnonzero(~lost), [len(lost)]))
        lasts_s = (np.diff(ends) - 1) * step_s
        lasts_s[0] += self.freeze_s
        self.freeze_s = float(lasts_s[-1])
        self.longest_freeze_s = max(self.longest_freeze_s, float(lasts_s.max()))

    def _gather(self, rate: Float, force: Float, field: Float | None, step_s: float) -> None:
        """Weigh the movement, with windows that began in the stretch before."""
        nothing = np.full_like(rate, np.nan)
        stretch = np.stack((rate, force, nothing if field is None else field))
        (rate, force, joined), step_s = self.joined.add(stretch, step_s)
        self.evidence += gather(rate, force, None if field is None else joined, step_s, self.evidence.pace)
        if field is not None:
            self.dip.add(rate, force, joined, step_s)

    def _watch(self, triad: str, values: Float) -> None:
        finite = values[np.asarray(np.isfinite(values)).all(axis=1)]
        if len(finite):
            first = self.first.setdefault(triad, finite[0])
            changing = self.changing.setdefault(triad, np.zeros(3, dtype=np.bool_))
            changing |= (finite != first).any(axis=0)

    def _rest(self, rate: Float, force: Float, field: Float | None, step_s: float, fastest: float) -> None:
        """Note what is read where the force stands still."""
        width = max(2, round(_RESTING_S / step_s))
        parts = len(force) // width
        if not parts:
            return
        pieces = force[: parts * width].reshape(parts, width, 3)
        size = np.linalg.norm(pieces.mean(axis=1), axis=1)
        still = np.linalg.norm(pieces.std(axis=1), axis=1) < _RESTING_SPREAD * size
        turning = rate[: parts * width].reshape(parts, width, 3)
        still &= np.isfinite(turning).all(axis=(1, 2))
        if not still.any():
            return
        self.resting_radps.add(*_at_rest(turning[still]))
        # On a circle at even pace the force stands still in the sensor as well, and is not gravity.
        most = max(_LYING_RADPS, _LYING_SHARE * fastest)
        still &= np.linalg.norm(turning.mean(axis=1), axis=1) < most
        if still.any():
            self.resting_mps2.add(float(np.median(size[still])))
        if field is None:
            return
        means = field[: parts * width].reshape(parts, width, 3).mean(axis=1)[still]
        sound = np.isfinite(means).all(axis=1) & (np.linalg.norm(means, axis=1) > 0.0)
        if sound.any():
            up = pieces.mean(axis=1)[still][sound]
            up, means = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (up, means[sound]))
            self._still_products += np.einsum("ni,nj->ij", up, means) / len(up)
            self._still_count += 1


def _whole(values: Float) -> Float:
    """Return samples, shape (N, 3), with NaN in all axes where one is not finite."""
    return np.asarray(np.where(np.isfinite(values).all(axis=1, keepdims=True), values, np.nan))


def _at_rest(turning: Float) -> tuple[float, float]:
    """Return what a gyroscope reads in pieces in which the force stands still, and its noise there.

    Zero where a person may turn or tremble: about the vertical, at a pace that is not even, or smoothly.
    """
    means = turning.mean(axis=1)
    middle = np.median(means, axis=0)
    rest = float(np.linalg.norm(middle))
    apart_from_it = np.median(np.linalg.norm(means - middle, axis=1))
    is_even = len(means) >= _FEWEST and apart_from_it < _EVEN_RADPS + _EVEN_SHARE * rest
    apart = turning - means[:, None]
    square = (apart**2).sum(axis=(1, 2))
    alike = (apart[:, 1:] * apart[:, :-1]).sum(axis=(1, 2)) / np.maximum(square, 1e-300)
    noise = float(np.median(np.sqrt(square / turning.shape[1])))
    return rest if is_even else 0.0, noise if np.median(alike) < _WHITE else 0.0
