"""In which order several processes compile: kernels that share parts in one process, each kernel in all orders."""

from collections.abc import Callable
from typing import Any

import pytest

from app.commands.compile_kernels import _orders
from estimators.compiling import compiled, goes_into


@compiled()
def doubled(x: Any) -> Any:
    return x + x


@compiled()
def quadrupled(x: Any) -> Any:
    return doubled(doubled(x))


def of_length(lines: int) -> Callable[..., Any]:
    found: dict[str, Any] = {}
    exec("def long(x):\n" + "    x = x + 1.0\n" * lines + "    return x\n", found)
    return found["long"]  # type: ignore[no-any-return]


def test_all_that_a_kernel_calls_goes_into_it():
    assert goes_into(quadrupled.py_func) == {quadrupled.py_func, doubled.py_func}
    assert goes_into(doubled.py_func) == {doubled.py_func}


@pytest.mark.parametrize("processes", [1, 2, 3])
def test_each_process_can_take_every_kernel_once(processes):
    parts = [{of_length(n)} for n in range(1, 8)]
    orders = _orders(parts, processes)
    assert len(orders) == processes
    assert all(sorted(order) == list(range(7)) for order in orders)
    assert {order[0] for order in orders} == set(range(7)[-processes:]), "each begins with a large one"


def test_a_kernel_goes_where_its_parts_are_lowered_already():
    one, other = of_length(40), of_length(41)
    parts = [{one, of_length(38)}, {other, of_length(37)}, {one, of_length(3)}, {other, of_length(4)}]
    assert sorted(sorted(order[:2]) for order in _orders(parts, 2)) == [[0, 2], [1, 3]]
