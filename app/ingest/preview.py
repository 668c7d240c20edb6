"""Which formats are read, and what a table seems to be, before anything of it is uploaded or stored."""

from fastapi import APIRouter

from app import readers
from app.accounts.dependencies import CurrentSubject
from app.readers.tables.schemas import GuessedMapping
from app.recordings.schemas import FormatOut, PreviewIn, TablePreview

router = APIRouter(prefix="/api", tags=["sessions"])
_SHOWN_COLUMNS = 300


@router.post("/uploads/preview")
def preview_upload(wanted: PreviewIn, _: CurrentSubject) -> TablePreview:
    """Guess how a table is to be read, as `telemotion mapping` does; nothing of it is stored."""
    found = readers.preview_text(wanted.file_name, wanted.beginning, wanted.pipeline, wanted.rate_hz)
    head, guess = found.head, found.guess
    return TablePreview.model_validate(
        {
            "format": found.format,
            "pipeline": found.pipeline,
            "columns": list(head.columns[:_SHOWN_COLUMNS]) if head else [],
            "rows": [list(row[:_SHOWN_COLUMNS]) for row in head.rows] if head else [],
            "skipped_lines": head.skipped_lines if head else 0,
            "mapping": GuessedMapping.model_validate(guess.mapping) if guess else None,
            "notes": list(guess.notes) if guess else [],
            "missing": list(guess.missing) if guess else [],
        }
    )


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


__all__ = ["router"]
