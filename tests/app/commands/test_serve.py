"""The start of the service."""

import gc

import pytest

from app.commands.serve import imported_for_good


def test_imports_are_not_looked_through_and_the_collector_works_afterwards():
    frozen = gc.get_freeze_count()
    try:
        with imported_for_good():
            assert not gc.isenabled()
        assert gc.isenabled()
        assert gc.get_freeze_count() > frozen
        with pytest.raises(ImportError), imported_for_good():
            raise ImportError
        assert gc.isenabled()
    finally:
        gc.unfreeze()
