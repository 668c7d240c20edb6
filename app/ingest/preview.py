"""Which formats are read, and what a table seems to be, before anything of it is uploaded or stored."""

from typing import Any

from fastapi import APIRouter, Request

from app import readers
from app.accounts.dependencies import CurrentSubject
from app.ingest.preview_schemas import PreviewIn, TablePreview
from app.readers.tables.look import Look, SensorLook, look_at
from app.readers.tables.schemas import GuessedMapping
from app.recordings.schemas import FormatOut
from app.services import services_of
from app.settings import Settings
from estimators.recording import Float

router = APIRouter(prefix="/api", tags=["sessions"])
_SHOWN_COLUMNS = 300
_NOTHING = Look((), (), (), ())
_DIGITS = 4


@router.post("/uploads/preview")
def preview_upload(wanted: PreviewIn, request: Request, _: CurrentSubject) -> TablePreview:
    """Say how a table is read, as guessed or as a person has changed it, with its first seconds; nothing is stored."""
    return previewed(wanted, services_of(request).settings)


def previewed(wanted: PreviewIn, settings: Settings) -> TablePreview:
    """Return what a service with these settings says of the beginning of a file."""
    found = readers.preview_text(
        wanted.file_name, wanted.beginning, wanted.pipeline, wanted.rate_hz, wanted.later
    )
    head, guess = found.head, found.guess
    look = _NOTHING
    if head is not None and guess is not None:
        look = look_at(head, guess, wanted.mapping, wanted.hemisphere or settings.hemisphere)
    guessed = GuessedMapping.model_validate(guess.mapping) if guess else None
    return TablePreview.model_validate(
        {
            "format": found.format,
            "pipeline": found.pipeline,
            "columns": list(head.columns[:_SHOWN_COLUMNS]) if head else [],
            "rows": [list(row[:_SHOWN_COLUMNS]) for row in head.rows] if head else [],
            "skipped_lines": head.skipped_lines if head else 0,
            "mapping": wanted.mapping if guess and wanted.mapping else guessed,
            "sensors": [_sensor(one) for one in look.sensors],
            "notes": list(look.assumed),
            "missing": list(look.missing),
            "doubts": list(look.doubts),
        }
    )


def _sensor(one: SensorLook) -> dict[str, Any]:
    seen = one.signals
    return {
        "where": one.where,
        "sentence": one.sentence,
        "time_s": [] if seen is None else [round(at, 5) for at in seen.time_s.tolist()],
        "gyroscope_radps": [] if seen is None else _axes(seen.gyroscope_radps),
        "accelerometer_mps2": [] if seen is None else _axes(seen.accelerometer_mps2),
        "magnetometer_t": [] if seen is None or seen.magnetometer_t is None else _axes(seen.magnetometer_t),
    }


def _axes(values: Float) -> list[list[float | None]]:
    """Return x, y and z as JSON has them: with few digits, for a curve, and null where there is no number."""
    return [
        [float(f"{one:.{_DIGITS}g}") if one - one == 0.0 else None for one in values[:, axis].tolist()]
        for axis in range(3)
    ]


@router.get("/uploads/formats")
def list_formats(_: CurrentSubject) -> list[FormatOut]:
    """Return every file format that is read, those that hold any sensors first."""
    return [
        FormatOut.model_validate(
            {
                "name": one.name,
                "title": one.title,
                "description": one.description,
                "endings": sorted(one.endings),
                "pipeline": one.pipeline or None,
                "asks_pipeline": one.asks_pipeline,
                "needs_mapping": one.needs_mapping,
            }
        )
        for one in readers.readers().values()
    ]
