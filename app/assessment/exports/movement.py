"""One estimate of a movement in an archive: Parquet, CSV, and a dictionary of their columns, written piece by piece."""

import json
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Final

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
from sqlalchemy import Engine, func, select
from sqlalchemy.orm import Session

from app.database.unit_of_work import read_only
from app.recordings.columns import csv_cell, dictionary, frames_table
from app.recordings.models import Result, SignalChunk
from app.recordings.result_files import setup_record, software
from app.recordings.signals.chunks import MAX_CHUNK_TICKS, frames_stream
from app.recordings.signals.store import read_frames
from estimators.pipelines import SessionSetup
from estimators.recording import Float

_PIECE_S: Final = 60.0
"""Movement is read and written in pieces of so long."""


@contextmanager
def reading(engine: Engine) -> Iterator[Session]:
    """Read without a line in the trail for each item: the export is noted as a whole."""
    with read_only(engine) as session:
        yield session
        session.info.clear()


def write_movement(archive: zipfile.ZipFile, name: str, engine: Engine, result_id: str) -> None:
    """Write `NAME.parquet`, `NAME.csv` and `NAME.json`.

    Parameters
    ----------
    archive : zipfile.ZipFile
        Open for writing; need not be able to go back.
    name : str
        With its folder, without ending.
    """
    # The columns are compressed in the file itself.
    with archive.open(zipfile.ZipInfo(f"{name}.parquet"), "w", force_zip64=True) as target:
        pieces = _pieces(engine, result_id)
        first = next(pieces)
        with pyarrow.parquet.ParquetWriter(target, first.schema, compression="zstd") as writer:
            writer.write_table(first)
            for piece in pieces:
                writer.write_table(piece.cast(first.schema))
    with archive.open(f"{name}.csv", "w", force_zip64=True) as target:
        pieces = _pieces(engine, result_id)
        first = next(pieces)
        names = [csv_cell(name) for name in first.column_names]
        with pyarrow.csv.CSVWriter(target, first.rename_columns(names).schema) as writer:
            writer.write_table(first.rename_columns(names))
            for piece in pieces:
                writer.write_table(piece.cast(first.schema).rename_columns(names))
    content = {**json.loads(first.schema.metadata[b"telemotion"]), "columns": dictionary(first)}
    archive.writestr(f"{name}.json", json.dumps(content, indent=1, ensure_ascii=False))


def _pieces(engine: Engine, result_id: str) -> Iterator[pa.Table]:
    """Yield a result as tables of a minute each, at least one; each read in a short transaction of its own."""
    with reading(engine) as session:
        result = session.get_one(Result, result_id)
        about = {
            "software": software(),
            "made_at": None
            if result.completed_at is None
            else result.completed_at.isoformat(timespec="seconds"),
            "kind": result.kind,
            "pipeline_version": result.pipeline_version,
            "orientation_version": result.orientation_version,
            "setup": setup_record(SessionSetup.from_dict(result.setup)),
        }
        last = session.scalar(
            select(func.max(SignalChunk.sequence)).where(
                SignalChunk.session_id == result.session_id, SignalChunk.stream == frames_stream(result_id)
            )
        )
        pipeline, rate_hz = result.pipeline, float(result.setup["rate_hz"])
        scales = session.scalars(
            select(SignalChunk.scale).where(
                SignalChunk.session_id == result.session_id, SignalChunk.stream == frames_stream(result_id)
            )
        ).all()
    has_sigma = any(scale.get("segment_sigma") for scale in scales)
    has_point_sigma = any(scale.get("point_sigma") for scale in scales)
    end_s = 0.0 if last is None else (last + MAX_CHUNK_TICKS) / rate_hz
    start_s, is_first = 0.0, True
    while is_first or start_s < end_s:
        with reading(engine) as session:
            frames = read_frames(session, result_id, start_s, start_s + _PIECE_S)
        start_s += _PIECE_S
        if is_first or frames.tick_count:
            # The same columns in every piece, also where a minute has none of a sigma.
            frames = replace(
                frames,
                segment_sigma_rad=_or_unknown(frames.segment_sigma_rad, frames.q_room_segment)
                if has_sigma
                else None,
                point_sigma_m=_or_unknown(frames.point_sigma_m, frames.point_room_m)
                if has_point_sigma
                else None,
            )
            yield frames_table(frames, pipeline=pipeline, about=about)
        is_first = False


def _or_unknown(sigma: Float | None, values: Float) -> Float:
    return np.full((*values.shape[:2], 3), np.nan) if sigma is None else sigma
