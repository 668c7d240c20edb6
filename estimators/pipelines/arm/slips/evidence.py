"""Evidence for a sensor that turned on its segment, not with it: the neighbours did not go along.

About the long axis: a middle segment cannot turn alone, as elbow and wrist do not twist. Across it: a turn moves the
sensor itself and the joint at the segment's end, and accelerometers feel that.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators import rotation
from estimators.conventions import Placement
from estimators.pipelines.arm.slips.arm import Chain
from estimators.pipelines.arm.slips.chain import Link
from estimators.pipelines.arm.slips.posture import Shift
from estimators.recording import Float

_WINDOW_S: Final = 0.8
_REACH_S: Final = 1.5
"""How far from the moment looked at the turn is searched for."""
_SHARE: Final = 0.6
"""Of the shift that one quick turn must make."""
_LEAST_TWIST_RAD: Final = math.radians(12.0)
_NEARLY: Final = 0.95
_STRAIGHT: Final = math.cos(math.radians(25.0))
_STILL: Final = 0.35
_AROUND_S: Final = 0.9
_SMOOTH_S: Final = 0.7
_TRIED_S: Final = 1.2
_TRY_EVERY: Final = 3
_DURATIONS_S: Final = (0.1, 0.3, 0.6)
_EXPLAINS: Final = 0.35
"""Of what the movement leaves unexplained, the share that may be left once the slip is taken off."""
_LEAST_SHARE: Final = 0.5


@dataclass(frozen=True)
class Proof:
    """A slip that the movement proves: which tick, and the shift that it left."""

    tick: int
    shift: Shift


def twisted_alone(chain: Chain, link: Link, tick: int, shift: Shift) -> Proof | None:
    """Return the turn about the long axis that the neighbours did not share, if there is one as large as the shift.

    Parameters
    ----------
    link : Link
        A hand, or a segment between two worn ones.
    tick : int
        About when.
    shift : Shift
        About the long axis.
    """
    sign = math.copysign(1.0, float(shift.turn_rad[2]))
    half = chain.samples(0.5 * _WINDOW_S)
    first, stop = _around(chain, tick, _REACH_S)
    step = sign * steps(chain.twist(link, link.proximal if link.is_hand else link.distal), half)
    if link.name.startswith("upper_arm"):
        # A forearm that turns has a twist against the upper arm too, while that stays.
        step = np.minimum(step, sign * steps(chain.twist(link, link.proximal), half))
    best = float(step[first:stop].max())
    if best < _SHARE * shift.size_rad or abs(shift.turn_rad[2]) < _LEAST_TWIST_RAD:
        return None
    # All windows that hold the whole turn are the best, whether it lies early or late in them.
    found = first + int(np.median(np.flatnonzero(step[first:stop] >= _NEARLY * best)))
    if not chain.is_whole(link, found - 2 * half, found + 2 * half):
        return None
    if link.name.startswith("upper_arm") and not _is_bent_or_still(chain, link, found, shift, half):
        return None
    return Proof(found, shift)


def _is_bent_or_still(chain: Chain, link: Link, tick: int, shift: Shift, half: int) -> bool:
    """Say whether the forearm would have to swing along; the twist of a straight one could hide the upper arm's."""
    assert link.distal is not None
    axis = np.array([0.0, 0.0, 1.0])
    along = rotation.rotate(chain.between(link.name, link.distal)[tick], axis)[2]
    if along < _STRAIGHT:
        return True
    window = slice(max(tick - half, 0), tick + half)
    turned = np.linalg.norm(chain.rate(link.distal)[window].sum(axis=0)) * chain.step_s
    return bool(turned < _STILL * shift.size_rad)


def steps(values: Float, half: int) -> Float:
    """Return by how much values change from `half` ticks before each tick to `half` after; 0 at the ends."""
    found = np.zeros_like(values)
    if len(values) > 2 * half:
        found[half:-half] = values[2 * half :] - values[: -2 * half]
    return found


def jumped(chain: Chain, name: Placement, tick: int, turn_rad: float) -> float:
    """Return how much of a quick turn stands out of the pronation that a forearm or a hand shows.

    Parameters
    ----------
    name : Placement
        Of a forearm or a hand, both worn.
    tick : int
        About when.
    turn_rad : float
        About the forearm's axis.

    Returns
    -------
    float
        1 where all of it is in what that sensor measured, 0 where nothing is: people pronate smoothly.
    """
    link = chain.links[name]
    fore = chain.links[link.proximal] if link.is_hand and link.proximal else link
    axis = rotation.rotate(chain.posture(fore.name), np.array([0.0, 0.0, 1.0]))
    rate = np.nan_to_num(np.sum((chain.rate(name) - chain.rate(fore.proximal)) * axis, axis=1))
    around = chain.samples(_SMOOTH_S)
    line = np.linspace(-1.0, 1.0, 2 * around)
    basis, _ = np.linalg.qr(np.stack([line**power for power in range(4)], axis=1))
    first, stop = _around(chain, tick, 0.5 * _WINDOW_S)
    best = 0.0
    for duration_s in _DURATIONS_S:
        pulse = turn_rad * _bent(_pulse(duration_s, around, chain.step_s), basis)
        size = float(pulse @ pulse)
        for centre in range(max(first, around), min(stop, len(rate) - around)):
            seen = _bent(rate[centre - around : centre + around], basis)
            left = seen - pulse
            best = max(best, float(seen @ seen - left @ left) / size)
    return best


def turned_on_the_spot(chain: Chain, link: Link, tick: int, shift: Shift) -> Proof | None:
    """Return when the shift came by a turn that moved nothing, if taking it off explains what the sensors felt.

    Notes
    -----
    With the rate w of a segment against its neighbour, places with the levers r must move by w x r. If the shift came
    as a quick turn p of the sensor alone, (w - p) x r fits what the accelerometers felt and w x r does not; if it came
    by a movement it is the other way round. Speeds are compared within two seconds, each but for a straight line:
    neither the speed at their beginning is known nor gravity's direction to better than a degree.
    """
    rate = chain.rate(link.name) - chain.rate(link.proximal)
    posture = chain.posture(link.name)
    levers = chain.levers(link)
    around = chain.samples(_AROUND_S)
    first, stop = _around(chain, tick, _TRIED_S)
    best, proof = _EXPLAINS, None
    line = np.linspace(-1.0, 1.0, 2 * around)
    basis, _ = np.linalg.qr(np.stack([np.ones_like(line), line], axis=1))
    pulses = [_pulse(duration_s, around, chain.step_s) for duration_s in _DURATIONS_S]
    for centre in range(max(first, around), min(stop, len(rate) - around), _TRY_EVERY):
        window = slice(centre - around, centre + around)
        if not chain.is_whole(link, window.start, window.stop):
            continue
        turned = rotation.rotate(posture[window], shift.turn_rad)
        arms = [rotation.rotate(posture[window], lever.lever_m) for lever in levers]
        unexplained = [
            _bent(np.cross(rate[window], arm) - lever.velocity_mps[window], basis)
            for arm, lever in zip(arms, levers, strict=True)
        ]
        whole = sum(float((one**2).sum()) for one in unexplained)
        for pulse in pulses:
            slips = [_bent(np.cross(pulse[:, None] * turned, arm), basis) for arm in arms]
            sizes = [float((one**2).sum()) + 1e-12 for one in slips]
            left = sum(float(((a - b) ** 2).sum()) for a, b in zip(unexplained, slips, strict=True))
            shares = [float((a * b).sum()) / c for a, b, c in zip(unexplained, slips, sizes, strict=True)]
            is_needed = min(shares) > _SHARE and whole > _LEAST_SHARE * sum(sizes)
            if is_needed and left < best * whole:
                best, proof = left / whole, Proof(centre, shift)
    return proof


def _pulse(duration_s: float, around: int, step_s: float) -> Float:
    """Return the rate of a smooth turn of one radian in the middle of a window, shape (2 * around,), 1/s."""
    share = np.clip((np.arange(2 * around) - around) * step_s / duration_s + 0.5, 0.0, 1.0)
    return np.asarray(np.gradient(share**3 * (10.0 - 15.0 * share + 6.0 * share**2), step_s))


def _bent(values: Float, basis: Float) -> Float:
    """Return what no straight line explains."""
    return np.asarray(values - basis @ (basis.T @ values))


def _around(chain: Chain, tick: int, reach_s: float) -> tuple[int, int]:
    reach = chain.samples(reach_s)
    return max(tick - reach, 0), min(tick + reach, len(chain.motion.time_s))
