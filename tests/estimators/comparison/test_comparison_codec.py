"""Stored templates and comparisons come back equal, and damage is told."""

import zlib

import numpy as np
import pytest

from estimators.comparison import (
    build_template,
    compare,
    comparison_from_bytes,
    comparison_to_bytes,
    template_from_bytes,
    template_to_bytes,
)
from estimators.errors import ComparisonError
from tests.said import refuses


def same(one, two):
    if isinstance(one, np.ndarray):
        return np.array_equal(one, two, equal_nan=True)
    if isinstance(one, float):
        return one == two or (np.isnan(one) and np.isnan(two))
    if isinstance(one, dict):
        return one.keys() == two.keys() and all(same(one[k], two[k]) for k in one)
    if hasattr(one, "__dataclass_fields__"):
        return all(same(getattr(one, f), getattr(two, f)) for f in one.__dataclass_fields__)
    if isinstance(one, (tuple, list)):
        return type(one) is type(two) and len(one) == len(two) and all(map(same, one, two))
    return one == two


@pytest.fixture
def template(planar):
    made = planar(noise_rad=0.002)
    return build_template(made.trajectory, made.truth, "right", 0.55, made.primary)


def test_template_round_trip(template):
    data = template_to_bytes(template)
    assert same(template_from_bytes(data), template)
    assert template_to_bytes(template_from_bytes(data)) == data
    assert len(data) < 50_000


def test_comparison_round_trip(planar, template):
    result = compare(planar(sizes=[1, 0.6, 1, 0.5, 1.0]).trajectory, template, "right", 0.5)
    data = comparison_to_bytes(result)
    assert same(comparison_from_bytes(data), result)
    empty = compare(planar(sizes=0.0).trajectory, template, "right", 0.5)
    assert same(comparison_from_bytes(comparison_to_bytes(empty)), empty)


def test_damage_is_told(template):
    data = template_to_bytes(template)
    with refuses("compare.not_stored", error=ComparisonError, kind="comparison"):
        comparison_from_bytes(data)
    for broken in (b"", data[:3], data[:8], data[:200], data[:-40], data[:50] + b"\0" * 20 + data[70:]):
        with pytest.raises(ComparisonError):
            template_from_bytes(broken)
    newer = data[:4] + (99).to_bytes(2, "little") + data[6:]
    with refuses("compare.other_version", error=ComparisonError, version="99"):
        template_from_bytes(newer)
    bomb = data[:10] + zlib.compress(b" " * (300 * 2**20), 1)
    with pytest.raises(ComparisonError):
        template_from_bytes(bomb)
