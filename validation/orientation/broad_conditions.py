"""BROAD made harder: started late, samples lost; and whether the stated uncertainty is true."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimators import rotation
from estimators.orientation import OrientationResult, create
from estimators.recording import Float, Recording, SensorSignals
from estimators.signals import to_common_ticks
from validation.orientation.broad import DEGREES_PER_RADIAN, estimate, score, sensor_name
from validation.protocol import Data, Figure, Protocol, Values

_RESTS = {"whole rest": None, "10 s of rest": 10.0, "3 s of rest": 3.0, "no rest": 0.0}
_HONEST = ("10 s of rest", "3 s of rest")
_LOSS_TRIALS = ("01", "07", "11", "21", "28", "36")
"""The trials of the published loss figures; with none of them among the data, all are used."""
_LOST_SHARE, _BURST_S, _SOUND_START_S = 0.05, 0.05, 1.0
_MOST_LOSS_SEEDS = 5
_CHI_SQUARE_95 = 7.815
"""Three degrees of freedom."""
_OURS, _OTHER = "telemotion", "vqf"


def started_before_movement(recording: Recording, rest_s: float | None) -> Recording:
    """Cut a trial so that it begins `rest_s` before the movement does; None leaves it whole."""
    if rest_s is None:
        return recording
    signals = recording.sensors[sensor_name(recording)]
    begin_s = signals.time_s[np.argmax(recording.reference["is_movement"])] - rest_s
    return started_at(recording, int(np.searchsorted(signals.time_s, begin_s - 1e-9)))


def started_at(recording: Recording, first: int) -> Recording:
    """Leave out all samples before `first`; time begins again."""
    name = sensor_name(recording)
    signals = recording.sensors[name]
    field = signals.magnetometer_t
    cut = SensorSignals(
        signals.time_s[first:] - signals.time_s[first],
        signals.gyroscope_radps[first:],
        signals.accelerometer_mps2[first:],
        None if field is None else field[first:],
    )
    return replace(
        recording,
        sensors={name: cut},
        reference={key: values[first:] for key, values in recording.reference.items()},
    )


def with_bursts_lost(recording: Recording, seed: int) -> Recording:
    """Leave 5 % of the samples out, in bursts of 50 ms; the reference stays whole."""
    name = sensor_name(recording)
    signals = recording.sensors[name]
    count = signals.time_s.size
    burst = max(1, round(_BURST_S * recording.nominal_rate_hz))
    rng = np.random.default_rng([seed, count])
    retained = np.ones(count, dtype=np.bool_)
    sound = round(_SOUND_START_S * recording.nominal_rate_hz)
    for start in rng.integers(sound, count - burst, round(_LOST_SHARE * count / burst)):
        retained[start : start + burst] = False
    retained[-1] = True  # the same ticks as without loss
    field = signals.magnetometer_t
    left = SensorSignals(
        signals.time_s[retained],
        signals.gyroscope_radps[retained],
        signals.accelerometer_mps2[retained],
        None if field is None else field[retained],
    )
    return replace(recording, sensors={name: left})


def share_inside(recording: Recording, name: str) -> float:
    """Return the share of scored samples whose error lies in the 95 % region that the filter states."""
    chunk = to_common_ticks(recording, recording.nominal_rate_hz)
    return share_of_result_inside(recording, create(name, 1, chunk.time_step_s).update(chunk))


def share_of_result_inside(recording: Recording, result: OrientationResult) -> float:
    """Return the same of a result over all ticks of a trial."""
    truth = recording.reference["q_earth_sensor"]
    scored = recording.reference["is_movement"].astype(bool) & np.isfinite(truth).all(axis=1)
    if result.sigma_rad is None:
        return float("nan")
    found = result.q_earth_sensor[0, : len(truth)][scored]
    error = rotation.log(rotation.multiply(found, rotation.conjugate(rotation.normalize(truth[scored]))))
    squares = ((error / result.sigma_rad[0, : len(truth)][scored]) ** 2).sum(axis=1)
    return float(np.mean(squares < _CHI_SQUARE_95))


def _total(recording: Recording, name: str) -> float:
    return DEGREES_PER_RADIAN * score(recording, estimate(recording, name)).total_rad


def _late(data: Data) -> Values:
    values: Values = {}
    for title, rest_s in _RESTS.items():
        trials = [started_before_movement(trial, rest_s) for trial in data.values()]
        ours = np.array([_total(trial, _OURS) for trial in trials])
        other = np.array([_total(trial, _OTHER) for trial in trials])
        values[f"Telemotion, {title}"] = np.array([ours.mean()])
        values[f"VQF, {title}"] = np.array([other.mean()])
        values[f"Telemotion over VQF, {title}"] = np.array([ours.mean() / other.mean()])
        values[f"share of what a trial may have, {title}"] = ours / (1.5 * other + 0.5)
        if title in _HONEST:
            inside = np.array([np.mean([share_inside(trial, _OURS) for trial in trials])])
            values[f"inside the 95 % region at least, {title}"] = inside
            values[f"inside the 95 % region at most, {title}"] = inside
    return values


def chosen_for_loss(data: Data) -> list[Recording]:
    """Return the trials of the published loss figures, or all where none of them is given."""
    return [trial for name, trial in data.items() if name.startswith(_LOSS_TRIALS)] or list(data.values())


def _lossy(seeds: Sequence[int], data: Data) -> dict[str, Float]:
    chosen = chosen_for_loss(data)
    return {
        f"{title}, samples lost": np.array(
            [np.mean([_total(with_bursts_lost(trial, seed), name) for trial in chosen]) for seed in seeds]
        )
        for name, title in ((_OURS, "Telemotion"), (_OTHER, "VQF"))
    }


def _conditions(seeds: Sequence[int], data: Data) -> Values:
    return _late(data) | _lossy(seeds[:_MOST_LOSS_SEEDS], data)


def _figures() -> tuple[Figure, ...]:
    figures = []
    for title in _RESTS:
        figures += [
            Figure(f"Telemotion, {title}", "deg"),
            Figure(f"VQF, {title}", "deg"),
            Figure(f"Telemotion over VQF, {title}", "1", 1.0),
            Figure(f"share of what a trial may have, {title}", "1", 1.0),
        ]
    for title in _HONEST:
        figures += [
            Figure(f"inside the 95 % region at least, {title}", "1", 0.90, at_most=False),
            Figure(f"inside the 95 % region at most, {title}", "1", 0.99),
        ]
    return (
        *figures,
        Figure("Telemotion, samples lost", "deg", 2.1, judged_by="median"),
        Figure("VQF, samples lost", "deg"),
    )


BROAD_CONDITIONS = Protocol(
    name="broad_conditions",
    title="A sensor started late or losing samples (BROAD)",
    source="Laidig et al. 2021, Data 6(7):72; conditions ours",
    what="Total error as in broad_orientation, when a trial begins with less rest than it has, and when 5 % of its "
    "samples are lost in bursts of 50 ms. On no trial may ours exceed 1.5 times VQF's error plus half a degree. "
    "The error must lie inside the region that the filter states for 95 % with 90 to 99 % of all samples.",
    figures=_figures(),
    measure=_conditions,
    needs_data="broad",
)
