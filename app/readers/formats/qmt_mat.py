"""The whole-body recording of the qmt toolbox: a struct of `acc`, `gyr` and `quat` per sensor, and `t`."""

from pathlib import Path
from typing import Any, Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.contract import Reader, Source
from app.readers.mat import load_mat
from app.readers.tables.clocks.stamps import nominal_rate, seconds_of
from app.readers.units import check_accelerometer, check_gyroscope
from estimators.conventions import Placement
from estimators.recording import Float, Recording, SensorSignals
from estimators.sentences import say

PLACEMENT_OF: Final[dict[str, Placement]] = {
    "head": "head",
    "upper_back": "sternum",
    "hip": "pelvis",
    "upper_arm_left": "upper_arm_left",
    "upper_arm_right": "upper_arm_right",
    "forearm_left": "forearm_left",
    "forearm_right": "forearm_right",
    "hand_left": "hand_left",
    "hand_right": "hand_right",
    "upper_leg_left": "thigh_left",
    "upper_leg_right": "thigh_right",
    "lower_leg_left": "shank_left",
    "lower_leg_right": "shank_right",
    "foot_left": "foot_left",
    "foot_right": "foot_right",
}
"""`upper_back` moves with the thorax, which is what our `sternum` measures. `lower_back` lies between pelvis and
thorax, has no segment of ours and is left out."""

WORN_BEHIND: Final = ("upper_back", "hip")
"""Sensors on the back: their z axis points behind the person, where the mounting rule expects it in front. They are
given half a turn about their x axis, which points up: without a magnetometer the rule alone tells the heading."""
_HALF_TURN_ABOUT_X: Final = np.array([1.0, -1.0, -1.0])


def read_qmt(path: Path) -> Recording:
    """Read a whole-body `.mat` recording; there is no magnetometer.

    Raises
    ------
    RecordingFormatError
        No `.mat` file, or not with these sensors.
    """
    content = load_mat(path, ["t", *PLACEMENT_OF, "lower_back"], simplify=True)
    if "t" not in content:
        raise RecordingFormatError(say("file.not_this_kind", missing=["t"], kind="qmt"))
    present = [name for name in PLACEMENT_OF if isinstance(content.get(name), dict)]
    if not present:
        raise RecordingFormatError(say("file.none_of_sensors", names=list(PLACEMENT_OF), kind="qmt"))
    time_s = seconds_of(np.asarray(content["t"], dtype=np.float64).reshape(-1), "s", first_row=1)
    sensors: dict[str, SensorSignals] = {}
    for name in present:
        gyroscope = _signal(content[name], name, "gyr", time_s.size)
        accelerometer = _signal(content[name], name, "acc", time_s.size)
        check_gyroscope(gyroscope, "rad/s", name)
        check_accelerometer(accelerometer, 1.0 / nominal_rate(time_s), "m/s^2", name)
        if name in WORN_BEHIND:
            gyroscope, accelerometer = gyroscope * _HALF_TURN_ABOUT_X, accelerometer * _HALF_TURN_ABOUT_X
        sensors[PLACEMENT_OF[name]] = SensorSignals(time_s, gyroscope, accelerometer)
    metadata = {"format": "qmt_mat"}
    if "lower_back" in content:
        metadata["left_out"] = "lower_back"
    return Recording(sensors, nominal_rate(time_s), origin="qmt whole-body recording", metadata=metadata)


def _signal(sensor: dict[str, Any], name: str, key: str, samples: int) -> Float:
    try:
        values = np.asarray(sensor[key], dtype=np.float64)
    except (KeyError, TypeError, ValueError) as error:
        raise RecordingFormatError(say("file.sensor_not_numeric", name=name, key=key), sensor=name) from error
    if values.shape != (samples, 3):
        raise RecordingFormatError(
            say(
                "file.sensor_shape",
                name=name,
                key=key,
                shape=str(values.shape),
                samples=samples,
                expected=f"({samples}, 3)",
            ),
            sensor=name,
        )
    return values


class QmtReader(Reader):
    """The whole-body recording of the qmt toolbox."""

    title = "Whole-body recording (.mat)"
    description = "MATLAB file with 16 named sensors; the arms and the trunk are used"
    endings = frozenset({".mat"})
    # Those that any whole-body recording has; what the file holds takes their place.
    placements = tuple(PLACEMENT_OF.values())
    is_last = True

    def recognises(self, source: Source) -> bool:
        """By its ending: what no other format of such files claims."""
        return source.ending == ".mat"

    def read(self, source: Source) -> Recording:
        """Read it; there is no magnetometer."""
        return read_qmt(source.path)
