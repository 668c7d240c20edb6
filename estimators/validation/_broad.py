"""BROAD: orientation of a single sensor against optical truth, and VQF against its own package."""

from collections.abc import Sequence

import numpy as np
from vqf import VQF

from estimators import rotation
from estimators.errors import SetupError
from estimators.orientation import OrientationErrors, orientation_errors
from estimators.pipelines import SessionSetup, run
from estimators.recording import Float, Recording
from estimators.validation._protocol import Data, Figure, Protocol, Values

_TITLES = {
    "vqf": "VQF",
    "marzouk_error_state_ekf": "error-state filter",
    "marzouk_quaternion_ekf": "quaternion filter",
}
_PUBLISHED = {"total": 2.43, "heading": 2.27, "inclination": 0.72}
"""VQF online with default parameters, mean of the 30 trials of BROAD that its authors score."""
_DEGREES_PER_RADIAN = 180.0 / np.pi


def _sensor(recording: Recording) -> str:
    if len(recording.sensors) != 1 or not {"q_earth_sensor", "is_movement"} <= set(recording.reference):
        raise SetupError("a BROAD trial has one sensor and a reference of q_earth_sensor and is_movement")
    return next(iter(recording.sensors))


def _estimate(recording: Recording, name: str) -> Float:
    """Run the product's off-line chain, at the trial's own rate."""
    placement = _sensor(recording)
    setup = SessionSetup("orientation", (placement,), recording.nominal_rate_hz, orientation=name)  # type: ignore[arg-type]
    return run(recording, setup)[0].q_room_segment[:, 0]


def _package(recording: Recording) -> Float:
    """Run the `vqf` package itself."""
    signals = recording.sensors[_sensor(recording)]
    field = None if signals.magnetometer_t is None else np.ascontiguousarray(signals.magnetometer_t * 1e6)
    batch = VQF(1.0 / recording.nominal_rate_hz).updateBatch(
        np.ascontiguousarray(signals.gyroscope_radps), np.ascontiguousarray(signals.accelerometer_mps2), field
    )
    return np.asarray(batch["quat9D"] if field is not None else batch["quat6D"])


def _score(recording: Recording, q_earth_sensor: Float) -> OrientationErrors:
    truth = recording.reference
    return orientation_errors(q_earth_sensor, truth["q_earth_sensor"], truth["is_movement"].astype(bool))


def _broad(seeds: Sequence[int], data: Data) -> Values:
    """One value a recording; the seeds have nothing to vary."""
    values: dict[str, list[float]] = {}
    means: dict[str, list[float]] = {}
    for recording in data.values():
        for name, title in _TITLES.items():
            found = _estimate(recording, name)
            if name == "vqf":
                apart = rotation.angle_between(found, _package(recording)).max()
                values.setdefault("VQF, largest difference from its package", []).append(float(apart))
            score = _score(recording, found)
            for kind in _PUBLISHED:
                error = _DEGREES_PER_RADIAN * getattr(score, f"{kind}_rad")
                means.setdefault(f"{title}, {kind}, mean of the trials", []).append(error)
    return {name: np.array(found) for name, found in values.items()} | {
        name: np.array([np.mean(found)]) for name, found in means.items()
    }


BROAD = Protocol(
    name="broad_orientation",
    title="Orientation of a sensor moved and disturbed (BROAD)",
    source="Laidig et al. 2021, Data 6(7):72; VQF: Laidig and Seel 2023, Information Fusion 91",
    what="Each trial given runs through the orientation pipeline; root mean square error over the movement, without "
    "alignment, averaged over the trials. The published figures are VQF's mean over the authors' 30 trials; VQF here "
    "must equal its own package on every sample of the same trials.",
    figures=(
        Figure("VQF, largest difference from its package", "rad", 1e-6),
        *(
            Figure(
                f"{title}, {kind}, mean of the trials",
                "deg",
                published=_PUBLISHED[kind] if title == "VQF" else None,
            )
            for title in _TITLES.values()
            for kind in _PUBLISHED
        ),
    ),
    measure=_broad,
    needs_data="broad",
)
