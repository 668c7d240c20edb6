"""What is no bench, and no source, is refused in words."""

from datetime import datetime

import pytest
from pydantic import ValidationError

from app.kinds.magnetic.source_schemas import (
    WORST_GAIN_SIGMA,
    MagneticSourceIn,
    SourceCalibrationIn,
    SourceFindings,
)
from estimators.magnetic import Coil

COIL = Coil().to_dict()


def source(**changes: object) -> dict[str, object]:
    return {"name": "belt", "serial": "S-1", "coils": [COIL] * 3, "gain_sigma": 0.01} | changes


def test_a_sound_source_is_taken():
    assert MagneticSourceIn.model_validate(source(calibrated_at="2026-11-21T10:00:00Z")).gain_sigma == 0.01


@pytest.mark.parametrize(
    "changes",
    [
        {"calibrated_at": "2026-11-21T10:00:00"},
        {"calibrated_at": "0001-01-01T00:00:00+14:00"},
        {"calibrated_at": "9999-12-31T23:59:59-14:00"},
        {"coils": [COIL | {"centre_m": (1e307, 0.0, 0.0)}] * 3},
        {"coils": [COIL | {"turns": 1e300}] * 3},
        {"gain_sigma": 1.01 * WORST_GAIN_SIGMA},
    ],
)
def test_what_no_source_can_be_is_refused(changes):
    with pytest.raises(ValidationError):
        MagneticSourceIn.model_validate(source(**changes))


def test_findings_are_numbers():
    with pytest.raises(ValidationError):
        SourceFindings.model_validate({"moment_sigma": [float("nan")] * 3})


def test_places_are_on_a_bench():
    with pytest.raises(ValidationError):
        SourceCalibrationIn(name="belt", serial="S-1", positions_m=[(1e200, 0.0, 0.0)])


def test_dates_are_kept_with_their_zone():
    kept = MagneticSourceIn.model_validate(source(calibrated_at="2026-11-21T10:00:00+01:00")).calibrated_at
    assert kept == datetime.fromisoformat("2026-11-21T09:00:00+00:00")
