"""Kernels called by their address, or unchecked: what they return and raise, and that nobody's arrays are forgotten."""

import sys

import numpy as np
import pytest
from numba import types

from estimators.compiling import compiled, unchecked
from estimators.kernels.by_address import address_of, caller
from estimators.recording import Float


@compiled(types.float64(types.Array(types.float64, 2, "A", readonly=True), types.float64))
def _scaled_sum(values: Float, scale: float) -> float:
    if scale < 0.0:
        raise ValueError("scale must not be negative")
    total = 0.0
    for row in values:
        for value in row:
            total += scale * value
    return total


_call = caller(_scaled_sum)


@compiled(types.float64(types.int64, types.float64[:, ::1], types.int64))
def _called(address: int, values: Float, scale: int) -> float:
    return float(_call(address, (values[1:], scale)))


def test_the_result_is_that_of_the_kernel() -> None:
    values = np.arange(12.0).reshape(4, 3)
    users = sys.getrefcount(values)
    address = address_of(_scaled_sum)
    assert [_called(address, values, 2) for _ in range(100)] == [_scaled_sum(values[1:], 2.0)] * 100
    assert sys.getrefcount(values) == users


def test_a_kernel_that_is_not_asked_for_types_returns_the_same() -> None:
    values = np.arange(12.0).reshape(4, 3)
    users = sys.getrefcount(values)
    direct = unchecked(_scaled_sum)
    assert [direct(values[1:], 2.0) for _ in range(100)] == [_scaled_sum(values[1:], 2.0)] * 100
    assert sys.getrefcount(values) == users
    with pytest.raises(ValueError, match="must not be negative"):
        direct(values, -1.0)


def test_what_the_kernel_raises_comes_through() -> None:
    with pytest.raises(ValueError, match="must not be negative"):
        _called(address_of(_scaled_sum), np.ones((2, 2)), -1)
