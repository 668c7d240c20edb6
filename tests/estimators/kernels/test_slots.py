"""Rows that sessions share: small pages, and views that know which array they are of."""

from pathlib import Path

import numpy as np
import pytest

from estimators.kernels.slots import into_row, sparse_zeros


def flags_of(address: int) -> list[str]:
    """Flags of the memory at an address, as the system lists them."""
    is_it = False
    for line in Path("/proc/self/smaps").read_text().splitlines():
        first, _, rest = line.partition(" ")
        if "-" in first and not first.endswith(":"):
            start, stop = (int(one, 16) for one in first.split("-"))
            is_it = start <= address < stop
        elif is_it and first == "VmFlags:":
            return rest.split()
    raise AssertionError("no such memory")


@pytest.mark.skipif(not Path("/proc/self/smaps").exists(), reason="the system lists no memory")
@pytest.mark.skipif(not Path("/sys/kernel/mm/transparent_hugepage").exists(), reason="no huge pages")
def test_a_large_array_is_in_small_pages() -> None:
    rows = sparse_zeros((64, 1 << 17))
    assert "nh" in flags_of(rows.ctypes.data), "advised against huge pages"


@pytest.mark.parametrize("shape", [(3, 2, 5), (4, 0), (0,)])
def test_it_is_zeros_that_can_be_written(shape: tuple[int, ...]) -> None:
    rows = sparse_zeros(shape, np.uint8)
    assert (rows.shape, rows.dtype) == (shape, np.uint8)
    assert rows.flags.c_contiguous
    assert not rows.any()
    rows[...] = 7
    assert (rows == 7).all()


def test_a_row_is_known_as_one_and_outlives_its_array() -> None:
    rows = sparse_zeros((2, 3))
    row = into_row(np.arange(3.0), rows[1])
    assert into_row(row, rows[1]) is row
    assert into_row(row, rows[0]) is not row
    del rows
    assert row.tolist() == [0.0, 1.0, 2.0]
