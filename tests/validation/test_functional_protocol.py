"""Joint angles after calibration by movement, on two seeds; twenty are run by `telemotion validate`."""

import numpy as np
import pytest

from validation import run_protocol
from validation.arm.functional import FUNCTIONAL_CALIBRATION


@pytest.mark.slow
def test_angles_keep_the_requirement_and_knowing_the_mounting_is_no_worse():
    found = run_protocol(FUNCTIONAL_CALIBRATION, 2, {})
    for joint in ("shoulder", "elbow"):
        angles = found.figure(f"{joint} angles").values
        assert (angles < 3.0).all(), angles
        assert np.median(angles) > 0.2, "skin and posture leave something"
        assert found.figure(f"{joint} angles, mounting known exactly").median < 3.0
    assert found.meets
