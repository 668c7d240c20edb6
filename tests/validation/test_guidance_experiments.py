"""The experiments of live guidance measure what they name; what may never happen does not, whatever the seed."""

import numpy as np
import pytest

from validation.guidance import COST, COUNT, CUES, PHASE
from validation.protocol import measured

NEVER = {
    "wrong ones counted as valid, in a batch",
    "cues where the estimate is less certain than any deviation",
}


@pytest.mark.slow
@pytest.mark.parametrize("protocol", [PHASE, COUNT, CUES, COST], ids=lambda one: one.name)
def test_an_experiment_measures_its_figures(protocol):
    values, _ = measured(protocol, [2], {})
    for name, value in values.items():
        assert value.shape == (1,)
        # One seed may bring no cue whose lateness is known.
        assert np.isfinite(value).all() or name.startswith("cue after")
        if name in NEVER:
            assert value[0] == 0.0
