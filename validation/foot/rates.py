"""Foot-mounted sensors at other rates, on bad links, and begun in the middle of a walk: recordings made by others."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.gait import smooth
from estimators.recording import Float, SensorSignals
from validation.foot.recordings import followed, parameters_of, rigid_rmse
from validation.protocol import Data, Figure, Protocol, Values

_LOST = 0.05
_LINKS = 3
"""So many times each walk goes over a bad link."""
_CUTS = (0.2, 0.35, 0.5)
_ALLOWED = 1.3
_WAYS = ("off-line", "live")
_AVERAGED = {f"{hz} Hz, averaged by the device": hz for hz in (100, 50)}
_PICKED = {f"{hz} Hz, single samples of a fast one": hz for hz in (100, 50)}
_BURSTS = {
    "5 % lost, one by one": 0.0,
    "5 % lost in bursts of 20 ms": 0.02,
    "5 % lost in bursts of 50 ms": 0.05,
}
_BEGUN = "started while walking"
_UNTIL_KNOWN = f"{_BEGUN}, live, seconds until the place is known, longest of the walks"
_KNOWN_S = 4.0
"""A few strides."""


def averaged(signals: SensorSignals, factor: int) -> SensorSignals:
    """Return what a slow device gives that averages over its interval, as nearly all do; N // factor samples."""
    whole = len(signals.time_s) // factor * factor

    def mean(values: Float) -> Float:
        return np.asarray(values[:whole].reshape(-1, factor, *values.shape[1:]).mean(axis=1))

    return SensorSignals(
        mean(signals.time_s), mean(signals.gyroscope_radps), mean(signals.accelerometer_mps2)
    )


def picked(signals: SensorSignals, which: slice | NDArray[np.intp]) -> SensorSignals:
    """Return some of the samples."""
    return SensorSignals(
        signals.time_s[which], signals.gyroscope_radps[which], signals.accelerometer_mps2[which]
    )


def lossy(signals: SensorSignals, burst_s: float, seed: Sequence[int]) -> SensorSignals:
    """Lose a twentieth of the samples, never the first or last, in bursts that begin at random."""
    samples = len(signals.time_s)
    burst = max(1, round(burst_s / float(np.median(np.diff(signals.time_s)))))
    begins = np.random.default_rng(seed).random(samples) < _LOST / burst
    is_lost = np.convolve(begins, np.ones(burst))[:samples] > 0.0
    is_lost[[0, -1]] = False
    return picked(signals, np.flatnonzero(~is_lost))


def _variants(signals: SensorSignals, rate_hz: float, seed: Sequence[int]) -> dict[str, list[SensorSignals]]:
    """Return what each condition makes of a walk."""
    variants = {"full rate": [signals]}
    for name, hz in _AVERAGED.items():
        variants[name] = [averaged(signals, round(rate_hz / hz))]
    for name, hz in _PICKED.items():
        variants[name] = [picked(signals, slice(None, None, round(rate_hz / hz)))]
    for name, burst_s in _BURSTS.items():
        variants[name] = [lossy(signals, burst_s, [*seed, link]) for link in range(_LINKS)]
    begins = [round(cut * len(signals.time_s)) for cut in _CUTS]
    variants[_BEGUN] = [picked(signals, slice(begin, None)) for begin in begins]
    return variants


def _rates_and_links(seeds: Sequence[int], data: Data) -> Values:
    errors: dict[tuple[str, str], list[float]] = {}
    unknown_s: list[float] = []
    for number, recording in enumerate(data.values()):
        signals, parameters = next(iter(recording.sensors.values())), parameters_of(recording)
        truth = recording.reference["position_xy_m"]
        for name, variants in _variants(signals, recording.nominal_rate_hz, [seeds[0], number]).items():
            for one in variants:
                rate_hz = round(1.0 / float(np.median(np.diff(one.time_s))))
                path = smooth(one, parameters)
                at_truth = _at(one.time_s, signals.time_s, truth)
                off_line = _at(one.time_s, path.time_s, path.position_m[:, :2])
                live, is_known = followed(one, rate_hz, parameters)
                errors.setdefault((name, _WAYS[0]), []).append(rigid_rmse(off_line, at_truth))
                since = int(np.argmax(is_known)) if name == _BEGUN else 0
                if name == _BEGUN:
                    unknown_s.append(float(one.time_s[since] - one.time_s[0]) if is_known.any() else np.inf)
                errors.setdefault((name, _WAYS[1]), []).append(rigid_rmse(live[since:, :2], at_truth[since:]))
    mean = {key: float(np.mean(values)) for key, values in errors.items()}
    values = {_full(way): np.array([mean["full rate", way]]) for way in _WAYS}
    for name, way in mean:
        if name != "full rate":
            values[_share(name, way)] = np.array([mean[name, way] / mean["full rate", way]])
    return values | {_UNTIL_KNOWN: np.array([max(unknown_s)])}


def _full(way: str) -> str:
    return f"planar RMSE at full rate, {way}, mean of the walks"


def _share(name: str, way: str) -> str:
    return f"{name}, {way}, over full rate"


def _at(wanted_s: Float, time_s: Float, values: Float) -> Float:
    return np.stack([np.interp(wanted_s, time_s, values[:, i]) for i in range(values.shape[1])], axis=1)


FOOT_RATES_AND_LINKS = Protocol(
    name="foot_rates_and_links",
    title="Feet at other rates and on bad links (PyShoe motion capture)",
    source="recordings of mtahakoroglu/LLIO-aided-iPyShoe, made slower and worse; the aim is our own",
    what="The walks of `foot_walks` as a slower sensor gives them, averaged over its interval as devices do and by "
    "single samples, which let shocks pass unseen; over links that lose a twentieth of the samples, three times "
    "each; and without their first 20, 35 and 50 %: live this counts from where the flags no longer say that speed "
    "and place are not known. Mean planar RMSE over that of the same walks at full rate.",
    figures=(
        *(Figure(_full(way), "m") for way in _WAYS),
        *(
            Figure(_share(name, way), "1", _ALLOWED)
            for name in (*_AVERAGED, *_PICKED, *_BURSTS, _BEGUN)
            for way in _WAYS
        ),
        Figure(_UNTIL_KNOWN, "s", _KNOWN_S),
    ),
    measure=_rates_and_links,
    needs_data="pyshoe",
)
