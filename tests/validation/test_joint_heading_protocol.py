"""Ten minutes without magnetometers, two seeds; twenty are run by `telemotion validate`."""

import numpy as np
import pytest

from validation import run_protocol
from validation.arm.joint_headings import JOINT_HEADINGS


@pytest.mark.slow
def test_the_elbow_bounds_what_drifts_without_it():
    found = run_protocol(JOINT_HEADINGS, 2, {})
    bounded = found.figure("after a minute, with the joint's rule").values
    free = found.figure("after a minute, without it").values
    assert (free > 10.0).any(), "offsets that walk must show"
    np.testing.assert_allclose(found.figure("share that is left").values, bounded / free)
    assert (bounded < free / 2.0).all(), (bounded, free)
