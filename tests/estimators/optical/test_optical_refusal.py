"""Markers that contradict their sensor are refused and why is told; sound ones, slow or with ghosts, are not."""

import numpy as np
import pytest

from estimators.errors import ContradictionError
from estimators.optical import fuse_markers
from estimators.optical._contradictions import check_result
from tests.said import codes, refuses, sentence
from validation.optical.refusal import OPTICAL_REFUSAL, cameras
from validation.optical.scenes import STEP_S, Scene, free_motion


@pytest.fixture(scope="module")
def scene() -> Scene:
    return free_motion(21, 18.0)


def refused(scene: Scene, time_s: np.ndarray, marker_m: np.ndarray) -> ContradictionError:
    chunk = scene.chunk
    with pytest.raises(ContradictionError) as caught:
        fuse_markers(time_s, marker_m, STEP_S, chunk.gyroscope_radps, chunk.accelerometer_mps2)
    return caught.value


def test_a_mirror_image_another_unit_and_another_axis_up_are_told_apart(scene: Scene) -> None:
    time_s, marker = cameras(scene, 21)
    inches = refused(scene, time_s, marker * 2.54)
    assert inches.scale == pytest.approx(2.54, rel=0.02)
    assert (inches.up, inches.is_mirrored) == ("z", False)
    assert codes(inches.message) == ["markers.contradict", "markers.scale"]
    exchanged = refused(scene, time_s, marker[:, [1, 0, 2]])
    assert (exchanged.up, exchanged.is_mirrored, exchanged.scale) == ("z", True, None)
    assert codes(exchanged.message) == ["markers.contradict", "markers.mirrored_columns"]
    high = refused(scene, time_s, marker[:, [0, 2, 1]])
    assert high.is_mirrored
    assert sentence([high.message], "markers.mirrored").parameters == {"one": "y"}
    turned = refused(scene, time_s, marker[:, [0, 2, 1]] * [1.0, 1.0, -1.0])
    assert (turned.up, turned.is_mirrored) == ("y", False)
    assert sentence([turned.message], "markers.up").parameters == {"up": "y"}


def test_what_only_seems_fused_is_refused() -> None:
    rng = np.random.default_rng(3)
    residual = rng.normal(0.0, 0.001, (1000, 3))
    good = np.full(1000, 2, dtype=np.uint8)
    check_result(residual, good, np.array([0.0, 0.1, 0.0]), is_lever_given=False)
    ghosts, far = good.copy(), residual.copy()
    ghosts[::40], far[::40] = 3, 0.4
    # A few ghosts, however far, are no contradiction.
    check_result(far, ghosts, np.zeros(3), is_lever_given=False)
    ghosts[::3] = 3
    with refuses("markers.shut_out", error=ContradictionError):
        check_result(residual, ghosts, np.zeros(3), is_lever_given=False)
    with refuses("markers.far", error=ContradictionError, distance_m=0.5):
        check_result(residual, good, np.array([0.5, 0.0, 0.0]), is_lever_given=False)
    check_result(residual, good, np.array([0.5, 0.0, 0.0]), is_lever_given=True)
    with refuses("markers.residual", error=ContradictionError):
        check_result(30.0 * residual, good, np.zeros(3), is_lever_given=False)


@pytest.mark.slow
def test_sound_recordings_pass_and_contradictory_ones_do_not() -> None:
    values = OPTICAL_REFUSAL.measure([3], {})
    assert values["sound recordings refused"] == 0.0
    assert values["contradictory files refused"] == 100.0
    assert values["markers of another movement refused"] == 100.0
