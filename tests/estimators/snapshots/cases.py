"""What every pipeline makes of the recordings in `tests/data`, live and off-line, as a few hundred numbers a case.

The numbers are no truth: they say that a change which was to move code moved nothing else. One that is to change them
writes them anew and says in its commit what moved and why::

    python -m tests.estimators.snapshots.cases --compare     # the largest difference of each case
    python -m tests.estimators.snapshots.cases --write

Instrumented shoes and magnetic sources have no recording here; theirs are simulated, with seeds that stay.
"""

import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import orientation, pipelines, signals
from estimators.magnetic import coil_state, perpendicular_source
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.pose import RelativePoseFilter
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import ImuChunk, Recording, SensorSignals
from estimators.simulation import gait_preset, simulate_gait
from estimators.simulation.coils import SourceFaults, relative_motion, relative_scene, run_closed_loop

DATA = Path(__file__).parents[2] / "data"
SNAPSHOTS = DATA / "snapshots"
VALUES = 12
"""Values of each array, evenly spread."""
PACKET_TICKS = 5
BACKWARD = {"upper_back": "sternum", "hip": "pelvis"}


def _sensor(content: Any, side: str = "", rate_hz: float = 204.8) -> SensorSignals:
    tail = f"_{side}" if side else ""
    gyroscope = content[f"gyroscope{tail}_radps"].astype(float)
    time_s = content["time_s"] if "time_s" in content else np.arange(len(gyroscope)) / rate_hz
    return SensorSignals(time_s, gyroscope, content[f"accelerometer{tail}_mps2"].astype(float))


@cache
def trial() -> Recording:
    """One sensor with magnetometer, moved fast (BROAD)."""
    content = np.load(DATA / "broad" / "fast_combined_15s.npz")
    rate_hz = float(content["sampling_rate_hz"])
    gyroscope = content["gyroscope_radps"].astype(float)
    sensor = SensorSignals(
        np.arange(len(gyroscope)) / rate_hz,
        gyroscope,
        content["accelerometer_mps2"].astype(float),
        1e-6 * content["magnetometer_ut"].astype(float),
    )
    return Recording({"imu": sensor}, rate_hz)


@cache
def arms() -> Recording:
    """Trunk and both arms without magnetometer (qmt); two are worn on the back, half a turn about the long axis."""
    content = np.load(DATA / "qmt" / "arms_25s.npz")
    sensors = {}
    for key in content.files:
        if not key.endswith("_gyroscope_radps"):
            continue
        name = key.removesuffix("_gyroscope_radps")
        turn = np.array([1.0, -1.0, -1.0]) if name in BACKWARD else np.ones(3)
        sensors[BACKWARD.get(name, name)] = SensorSignals(
            content["time_s"],
            turn * content[key].astype(float),
            turn * content[f"{name}_accelerometer_mps2"].astype(float),
        )
    return Recording(sensors, 100.0)


@cache
def walk(name: str) -> Recording:
    """Feet: `pyshoe_walk`, `xio_short_walk` or `gaitmap_strides`."""
    content = np.load(DATA / "feet" / f"{name}.npz")
    if name == "gaitmap_strides":
        return Recording({f"foot_{side}": _sensor(content, side) for side in ("left", "right")}, 204.8)
    if name == "pyshoe_walk":
        return Recording({"foot_right": _sensor(content)}, 200.0, metadata={"gyroscope_clip_radps": "9.09"})
    return Recording({"foot_right": _sensor(content)}, 398.0)


@cache
def shoes() -> Recording:
    """Two instrumented shoes, walking after a stroke (simulated)."""
    found = simulate_gait(replace(gait_preset("stroke", 1), rate_hz=100.0)).recording
    names = [f"{part}_{side}" for side in ("left", "right") for part in ("heel", "forefoot", "shank")]
    return replace(found, sensors={name: found.sensors[name] for name in names})


@cache
def source_session() -> ImuChunk:
    """A coil source at the pelvis and a sensor on the chest, bending forward (simulated)."""
    source = perpendicular_source(0.06)
    scene = relative_scene(source, relative_motion("flexion", 12.0, 1), 12.0, seed=1)
    one = RelativePoseFilter(source, 0.01, {"mounting_direction": (0.05, 0.0, 1.0), "response_s": 0.5})
    _, table = run_closed_loop(scene, one, SourceFaults(), 1)
    both = [
        [table[:, first : first + 3] for first in pair]
        for pair in ((at.SOURCE_GYROSCOPE, at.GYROSCOPE), (at.SOURCE_ACCELEROMETER, at.ACCELEROMETER))
    ]
    field = np.stack([scene.source_ambient_t, table[:, at.FIELD : at.FIELD + 3]])
    state = np.zeros((2, len(table)))
    state[0] = coil_state(table[:, at.COIL].astype(int), table[:, at.CURRENT])
    quality = np.zeros((2, len(table)), dtype=np.uint8)
    return ImuChunk(0, 0.01, np.stack(both[0]), np.stack(both[1]), field, quality, coil_state=state)


def live(chunk: ImuChunk, setup: SessionSetup, pose: tuple[int, int] | None = None) -> Frames:
    """Step through a session as packets bring it, calibrating where the pose ends."""
    pipeline = pipelines.create(setup)
    parts = []
    for first in range(0, chunk.tick_count, PACKET_TICKS):
        stop = min(first + PACKET_TICKS, chunk.tick_count)
        parts.append(pipeline.step(chunk.ticks(first, stop)))
        if pose is not None and first < pose[1] <= stop:
            pipeline.calibrate(chunk.ticks(*pose))
    return pipelines.concatenate(parts)


def _arm(orientation_name: str) -> SessionSetup:
    return SessionSetup("arm", arms().placements, 100.0, orientation=orientation_name)


def _single(orientation_name: str) -> SessionSetup:
    return SessionSetup("orientation", ("imu",), trial().nominal_rate_hz, orientation=orientation_name)


def _walking(recording: Recording) -> SessionSetup:
    return SessionSetup("gait", recording.placements, 100.0)


def _shoe_walk() -> list[object]:
    setup = SessionSetup("gait", ("heel_left", "heel_right"), 100.0, feet_apart_m=0.18)
    followed = pipelines.analyse_walk(shoes(), setup)
    return [followed, pipelines.analyse_shoes(shoes(), setup, followed)]


def _live_walk(recording: Recording) -> Frames:
    return live(signals.to_common_ticks(recording, 100.0), _walking(recording))


RELATIVE = SessionSetup(
    "relative_pose", ("pelvis", "sternum"), 100.0, orientation_parameters={"gain_sigma": 0.002}
)

CASES: dict[str, Callable[[], object]] = {
    **{
        f"single-{name}": lambda name=name: live(  # type: ignore[misc]
            signals.to_common_ticks(trial(), trial().nominal_rate_hz), _single(name)
        )
        for name in orientation.available()
    },
    "single-offline": lambda: pipelines.run(trial(), _single("telemotion_smoother"))[0],
    "arm-live": lambda: live(signals.to_common_ticks(arms(), 100.0), _arm("telemotion"), (95, 200)),
    "arm-offline": lambda: pipelines.run(
        arms(), _arm("telemotion_smoother"), (0.95, 2.0), elbows_from_movement=True
    )[0],
    "walk-live": lambda: _live_walk(walk("gaitmap_strides")),
    **{
        f"walk-{name}": lambda name=name: pipelines.analyse_walk(walk(name), _walking(walk(name)))  # type: ignore[misc]
        for name in ("pyshoe_walk", "xio_short_walk", "gaitmap_strides")
    },
    "shoes-offline": _shoe_walk,
    "source-live": lambda: live(source_session(), RELATIVE),
    "source-offline": lambda: pipelines.smooth_modules([source_session()], RELATIVE),
}


def arrays(found: object, path: str = "") -> Iterator[tuple[str, NDArray[np.generic]]]:
    """Yield every array and number of a result by its path."""
    if isinstance(found, np.ndarray):
        yield path, found
    elif isinstance(found, bool | int | float):
        yield path, np.array(found)
    elif is_dataclass(found):
        for field in fields(found):
            yield from arrays(getattr(found, field.name), f"{path}.{field.name}")
    elif isinstance(found, dict):
        for key in sorted(found):
            yield from arrays(found[key], f"{path}.{key}")
    elif isinstance(found, list | tuple):
        for index, one in enumerate(found):
            yield from arrays(one, f"{path}.{index}")


def snapshot(found: object) -> dict[str, dict[str, Any]]:
    """Return of every array its shape, how many of its values are finite, and some of them."""
    picture = {}
    for path, array in arrays(found):
        if array.dtype.kind not in "biuf" or not array.size:
            continue
        flat = array.reshape(-1).astype(float)
        values = flat[np.unique(np.linspace(0, flat.size - 1, VALUES).astype(int))]
        picture[path] = {
            "shape": list(array.shape),
            "finite": int(np.isfinite(flat).sum()),
            "scale": float(np.max(np.abs(flat), where=np.isfinite(flat), initial=0.0)),
            "values": [None if np.isnan(value) else value for value in values.tolist()],
        }
    return picture


def stored(name: str) -> dict[str, dict[str, Any]]:
    """Return the numbers of a case as they were written."""
    content: dict[str, dict[str, Any]] = json.loads((SNAPSHOTS / f"{name}.json").read_text())
    return content


def differences(found: dict[str, dict[str, Any]], name: str) -> dict[str, float]:
    """Return by array how far its values are from those stored, as a share of its largest; infinite where it cannot be
    compared."""
    before = stored(name)
    result = {}
    for path in sorted(found.keys() | before.keys()):
        one, other = found.get(path), before.get(path)
        if one is None or other is None or one["shape"] != other["shape"] or one["finite"] != other["finite"]:
            result[path] = np.inf
            continue
        a, b = (np.array(side["values"], dtype=float) for side in (one, other))
        if not np.array_equal(np.isnan(a), np.isnan(b)):
            result[path] = np.inf
            continue
        scale = max(other["scale"], 1e-300)
        same = np.isnan(a) | (a == b)
        result[path] = float(np.max(np.abs(a - b)[~same], initial=0.0)) / scale
    return result


def main(wanted: str, names: list[str]) -> None:
    """Write snapshots or compare with them: of the named cases, of all when none is named."""
    for name in names or CASES:
        found = snapshot(CASES[name]())
        if wanted == "--write":
            SNAPSHOTS.mkdir(exist_ok=True)
            lines = [f"{json.dumps(path)}: {json.dumps(one)}" for path, one in found.items()]
            (SNAPSHOTS / f"{name}.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")
            print(f"{name:<28} {len(found)} arrays written")
        elif not (SNAPSHOTS / f"{name}.json").exists():
            print(f"{name:<28} new: `--write {name}` writes it")
        else:
            worst = max(differences(found, name).items(), key=lambda item: item[1])
            print(f"{name:<28} {worst[1]:.3g} {worst[0]}")


if __name__ == "__main__":
    main((sys.argv[1:] or ["--compare"])[0], sys.argv[2:])
