"""Experiments with cameras, magnetic sources and relative poses: nothing is grossly wrong with one seed."""

import pytest

from tests.validation import one_seed

NAMES = [name for name in one_seed.SIMULATED if name.startswith(("optical", "magnetic", "relative"))]

pytestmark = pytest.mark.slow("experiments of minutes, skipped where they passed before")


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_grossly_wrong(name):
    one_seed.check(name)
