"""Which axes of a marked sample are cut off: those as large as they ever were."""

import numpy as np

from estimators.gait._stance_kernel import CUT_FORCE, CUT_RATE
from estimators.gait.foot.live.cut_off import CutOffAxes


def test_the_axis_at_its_largest_is_named_and_no_other() -> None:
    rate, force = np.zeros((3, 3)), np.zeros((3, 3))
    rate[:, 1] = (8.0, 8.0, 2.0)
    force[:, 2] = 9.8
    marked = np.array([False, True, True])
    assert CutOffAxes().find(rate, force, marked).tolist() == [0, 2 * CUT_RATE, 0]


def test_a_chunk_without_marks_is_remembered_as_one_with_marks_is() -> None:
    rng = np.random.default_rng(5)
    quick, whole = CutOffAxes(), CutOffAxes()
    for number in range(50):
        rate, force = rng.normal(0.0, 4.0, (5, 3)), rng.normal(0.0, 12.0, (5, 3))
        assert not quick.find(rate, force, np.zeros(5, dtype=np.bool_)).any()
        whole.find(rate, force, np.ones(5, dtype=np.bool_))
        assert quick.largest.tolist() == whole.largest.tolist(), number
    at_the_end = np.full((1, 3), 40.0), np.full((1, 3), 200.0)
    assert quick.find(*at_the_end, np.ones(1, dtype=np.bool_)).tolist() == [7 * CUT_RATE | CUT_FORCE]
