"""Signals of instrumented shoes: from the packets of a session, or stored as one row with an uploaded one."""

import zlib
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from app.kinds.walk.shoe_arrays import packed, unpacked
from app.recordings.models import SignalChunk
from app.recordings.signals.chunks import EncodedChunk
from app.recordings.signals.codecs import DamagedChunkError, checksum
from app.recordings.signals.rows import insert_chunk
from estimators.conventions import SHOE_PLACEMENTS
from estimators.kinetics import stretches
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk, Recording, SensorSignals
from estimators.sentences import say

SHOES_STREAM: Final = "shoes"
_CODEC: Final = "npz.zlib"
_LONGEST_HOLE_S: Final = 0.2


def store_shoes(session: Session, session_id: str, recording: Recording) -> None:
    """Keep the shoes' signals; an earlier attempt is replaced.

    Parameters
    ----------
    recording : Recording
        Sensors on one time base, see `read_instrumented_shoe`.
    """
    data = zlib.compress(packed(recording), 6)
    session.execute(
        delete(SignalChunk).where(SignalChunk.session_id == session_id, SignalChunk.stream == SHOES_STREAM)
    )
    ticks = max(sensor.time_s.size for sensor in recording.sensors.values())
    scale = {"version": 1, "rate_hz": recording.nominal_rate_hz}
    insert_chunk(
        session, session_id, SHOES_STREAM, 0, EncodedChunk(0, ticks, _CODEC, scale, checksum(data), data)
    )


def load_shoes(session: Session, session_id: str) -> Recording | None:
    """Return the shoes' signals of a session; None where there are none."""
    row = session.scalar(
        select(SignalChunk).where(SignalChunk.session_id == session_id, SignalChunk.stream == SHOES_STREAM)
    )
    if row is None:
        return None
    if checksum(row.data) != row.crc:
        raise DamagedChunkError(say("stored.checksum"))
    return unpacked(zlib.decompress(row.data), float(row.scale["rate_hz"]))


def shoes_of(pieces: Sequence[ImuChunk], setup: SessionSetup) -> tuple[Recording | None, float, str]:
    """Return the shoes' signals of a session whose packets hold forces.

    Parameters
    ----------
    pieces : sequence of ImuChunk
        The whole session, sensors in the order of the setup.

    Returns
    -------
    recording : Recording or None
        The longest stretch in which all four cells measured, on one time base; holes of up to 0.2 s are filled.
    lost_s : float
        How much of the session came before it.
    note : str
        What is missing, for people; empty when nothing is.
    """
    names: list[str] = list(setup.placements)
    if not pieces or not set(SHOE_PLACEMENTS) <= set(names):
        return None, 0.0, ""
    rows = [names.index(name) for name in SHOE_PLACEMENTS]
    time_s = np.concatenate([piece.time_s for piece in pieces])
    columns = np.concatenate([_signals(piece, rows) for piece in pieces], axis=1)
    known = np.isfinite(columns).all(axis=2)
    silent = [name for name, one in zip(SHOE_PLACEMENTS, known, strict=True) if not one.any()]
    if silent:
        return None, 0.0, say("walk.no_forces_from", places=silent)
    step_s = pieces[0].time_step_s
    whole = known.all(axis=0)
    holes = [hole for hole in stretches(~whole) if (hole[1] - hole[0]) * step_s > _LONGEST_HOLE_S]
    edges = [0, *(int(edge) for hole in holes for edge in hole), len(whole)]
    first, stop = max(zip(edges[::2], edges[1::2], strict=True), key=lambda part: part[1] - part[0])
    measured = np.flatnonzero(whole[first:stop]) + first
    if not len(measured):
        return None, 0.0, say("walk.no_forces_together")
    first, stop = int(measured[0]), int(measured[-1]) + 1
    note = ""
    if holes:
        worst = max(holes, key=lambda hole: int(hole[1] - hole[0]))
        missing = [
            name
            for name, one in zip(SHOE_PLACEMENTS, known, strict=True)
            if not one[worst[0] : worst[1]].all()
        ]
        note = say(
            "walk.forces_partly",
            start_s=time_s[first],
            end_s=time_s[stop - 1],
            lost_s=time_s[worst[0]],
            places=missing,
        )
    sensors = {}
    for number, name in enumerate(SHOE_PLACEMENTS):
        filled = np.column_stack(
            [np.interp(time_s[first:stop], time_s[measured], part[measured]) for part in columns[number].T]
        )
        parts = np.split(filled, 4, axis=1)
        sensors[str(name)] = SensorSignals(time_s[first:stop], parts[0], parts[1], None, parts[2], parts[3])
    return Recording(sensors, setup.rate_hz, origin="session"), float(time_s[first] - time_s[0]), note


def _signals(piece: ImuChunk, rows: list[int]) -> NDArray[np.float64]:
    """Return rate, specific force, force and moment side by side, shape (4, K, 12); NaN where not measured."""
    nothing = np.full((len(rows), piece.tick_count, 3), np.nan)
    loads = [nothing if part is None else part[rows] for part in (piece.force_n, piece.moment_nm)]
    return np.concatenate([piece.gyroscope_radps[rows], piece.accelerometer_mps2[rows], *loads], axis=2)
