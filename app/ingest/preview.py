"""What a table seems to be, from its beginning, before anything of it is uploaded or stored."""

from fastapi import APIRouter

from app.accounts.dependencies import CurrentSubject
from app.ingest import readers
from app.recordings.schemas import PreviewIn, TablePreview
from app.recordings.table_schemas import GuessedMapping

router = APIRouter(prefix="/api", tags=["sessions"])
_SHOWN_COLUMNS = 300


@router.post("/uploads/preview")
def preview_upload(wanted: PreviewIn, _: CurrentSubject) -> TablePreview:
    """Guess how a table is to be read, as `telemotion mapping` does; nothing of it is stored."""
    found = readers.preview_text(wanted.file_name, wanted.beginning, wanted.pipeline)
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


__all__ = ["router"]
