"""Walks: what a gait result keeps beside its frames, and how it is read back.

Footholds, strides and numbers are stored as one row of the signal table, stream `gait/<result id>`: they belong to
the result, are erased with it, and are small (a ten-minute walk about 100 kB).
"""

import zlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import Conflict
from app.exercises.models import Exercise
from app.kinds.walk.balance import balance_of
from app.kinds.walk.curves import cycle_curves, force_curves, peak_measures
from app.kinds.walk.followed import followed_of
from app.kinds.walk.paging import beginning, page_of, thinned
from app.kinds.walk.schemas import (
    FootholdOut,
    FootOut,
    FootStride,
    GaitOut,
    StrideOut,
    WalkContent,
    WalkMeasure,
    WalkTestOut,
)
from app.pages import Page
from app.recordings import repository, service
from app.recordings.models import WALK_STREAM, Result, SignalChunk
from app.recordings.signals.chunks import EncodedChunk
from app.recordings.signals.codecs import DamagedChunkError, checksum
from app.recordings.signals.rows import insert_chunk
from estimators.gait import GUIDED_KINDS, GuidedKind, Measure, Strides, guided_test, steady
from estimators.pipelines import GaitPipeline, RelativePosePipeline, SessionSetup, ShoeWalk, Walk
from estimators.recording import Float, ImuChunk, Recording, SampleQuality, SensorSignals
from estimators.sentences import say

PIPELINE: Final = GaitPipeline.name
_CODEC: Final = "json.zlib"
_PATH_HZ: Final = 20.0


def recording_of(
    pieces: Iterable[ImuChunk], setup: SessionSetup, hello: Mapping[str, Any] | None = None
) -> Recording:
    """Put the pieces of a session together; ticks that were not measured are left out.

    Parameters
    ----------
    pieces : iterable of ImuChunk
        Consecutive, sensors in the order of the setup.
    hello : mapping, optional
        Of the gateway; may tell where the devices clip.
    """
    parts = list(pieces)
    time_s = np.concatenate([part.time_s for part in parts]) if parts else np.zeros(0)
    sensors = {}
    for row, name in enumerate(setup.placements):
        quality = np.concatenate([part.quality[row] for part in parts]) if parts else np.zeros(0, np.uint8)
        measured = (quality & (SampleQuality.MISSING | SampleQuality.BRIDGED)) == 0
        columns = [
            _column(parts, field, row, measured)
            for field in ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t")
        ]
        field = columns[2] if np.isfinite(columns[2]).any() else None
        sensors[str(name)] = SensorSignals(time_s[measured], columns[0], columns[1], field)
    declared = {key: (hello or {}).get(f"clip_{key}") for key in ("gyroscope_radps", "accelerometer_mps2")}
    known = {
        f"{key.replace('_', '_clip_')}": str(value) for key, value in declared.items() if value is not None
    }
    return Recording(sensors, setup.rate_hz, origin="session", metadata=known)


def _column(parts: list[ImuChunk], field: str, row: int, measured: NDArray[np.bool_]) -> Float:
    """Return one sensor's samples of a signal, shape (N, 3); NaN where the network does not have it."""
    pieces = [
        np.full((part.tick_count, 3), np.nan) if getattr(part, field) is None else getattr(part, field)[row]
        for part in parts
    ]
    return np.concatenate(pieces)[measured] if pieces else np.zeros((0, 3))


def content_of(
    walk: Walk, shoes: ShoeWalk | None = None, test: GuidedKind = "walk", notes: Sequence[str] = ()
) -> WalkContent:
    """Return what is stored of a walk besides its frames.

    Parameters
    ----------
    walk : Walk
        In the room of the shoes where there are any.
    test : str
        Which walking test it was.
    notes : sequence of str
        What else to tell after the walk's own reasons.

    Returns
    -------
    WalkContent
        Places are those of the frames: x along the walk, feet drawn apart.
    """
    feet = []
    for side, strides in walk.strides.items():
        name = f"foot_{side}"
        column, time_s = walk.frames.layout.points.index(name), walk.frames.time_s
        place, turn = walk.frames.point_room_m[:, column], walk.frames.q_room_segment[:, column]
        # A path is drawn, not measured from: 20 places a second are enough.
        thin = max(1, round(1.0 / (walk.frames.time_step_s * _PATH_HZ)))
        counted = steady(strides)
        curves = cycle_curves(walk.trajectories[side], strides, counted)
        measures = dict(walk.summary.feet[side])
        if shoes is not None:
            curves += force_curves(shoes, side, strides, counted)
            measures |= peak_measures(shoes, side, strides, counted)
        feet.append(
            FootOut(
                side=side,
                measures=_measures(measures),
                footholds=_footholds(strides, time_s, place, turn),
                strides=[_stride(strides, k, bool(counted[k])) for k in range(strides.count)],
                path_m=thinned([[round(float(x), 4), round(float(y), 4)] for x, y in place[::thin, :2]]),
                curves=curves,
                turning=_measures(
                    {name: one for name, one in walk.summary.turning.get(side, {}).items() if one.count}
                ),
            )
        )
    return WalkContent(
        feet=feet,
        both=_measures({**walk.summary.both, **(walk.steps or {})}),
        asymmetry=_measures(walk.summary.asymmetry),
        turn_count=walk.summary.turn_count,
        bout_count=walk.summary.bout_count,
        reasons=[*reasons_of(walk, shoes), *notes],
        has_step_width=walk.steps is not None,
        test=_test(walk, test),
        balance=None if shoes is None else balance_of(shoes),
    )


def reasons_of(walk: Walk, shoes: ShoeWalk | None) -> list[str]:
    """Return what a reader of a walk's numbers must know."""
    return [*walk.summary.reasons, *(() if shoes is None else shoes.reasons)]


def store_walk(session: Session, session_id: str, result_id: str, content: WalkContent) -> None:
    """Keep the walk of a result, and with the result what progress follows of it."""
    data = zlib.compress(content.model_dump_json().encode(), 6)
    chunk = EncodedChunk(0, len(content.feet), _CODEC, {"version": 1}, checksum(data), data)
    insert_chunk(session, session_id, walk_stream(result_id), 0, chunk)
    session.get_one(Result, result_id).followed = followed_of(content)


def gait(session: Session, subject: Subject, session_id: str, result_id: str | None) -> GaitOut:
    """Return the walk of a result, by default of the main one; of a long walk its beginning, see `beginning`.

    Raises
    ------
    NotFound
        No such session or result.
    Conflict
        The session holds no walk, or it is not analysed yet.
    """
    result, content = _read(session, subject, session_id, result_id, "session.gait")
    shown = beginning(content)
    return GaitOut(session_id=session_id, result=service.result_out(result), **dict(shown))


def strides_page(
    session: Session, subject: Subject, session_id: str, result_id: str | None, page: Page
) -> list[FootStride]:
    """Return a page of the strides of a walk, both feet's in the order of time.

    Raises
    ------
    NotFound, Conflict
        As `gait`.
    """
    return page_of(_read(session, subject, session_id, result_id, "session.gait")[1], page)


def _read(
    session: Session, subject: Subject, session_id: str, result_id: str | None, action: str
) -> tuple[Result, WalkContent]:
    found = repository.get_session(
        session, subject, session_id, action=action, details={"result": result_id or "main"}
    )
    if result_id is None and found.setup["pipeline"] == RelativePosePipeline.name:
        # A source on one shoe: the walk is beside the main result.
        walked = [one for one in repository.results_of(session, found.id) if one.pipeline == PIPELINE]
        result_id = walked[-1].id if walked else None
    if found.setup["pipeline"] != PIPELINE and result_id is None:
        raise Conflict(say("walk.no_walk"))
    result = repository.result_of(session, found, result_id)
    row = session.scalar(
        select(SignalChunk).where(
            SignalChunk.session_id == session_id, SignalChunk.stream == walk_stream(result.id)
        )
    )
    if row is None:
        raise Conflict(say("walk.no_strides"))
    if checksum(row.data) != row.crc:
        raise DamagedChunkError(say("stored.checksum"))
    return result, WalkContent.model_validate_json(zlib.decompress(row.data))


def walk_stream(result_id: str) -> str:
    """Return the name of the stream that holds the walk of a result."""
    return WALK_STREAM + result_id


def _measures(found: Mapping[str, Measure]) -> list[WalkMeasure]:
    return [
        WalkMeasure(
            measure=name,
            value=_plain(one.value),
            sigma=_plain(one.sigma),
            spread=_plain(one.spread),
            count=one.count,
            unit=one.unit,
        )
        for name, one in found.items()
    ]


def _test(walk: Walk, kind: GuidedKind) -> WalkTestOut | None:
    found = guided_test(walk.strides, kind)
    if found is None:
        return None
    return WalkTestOut(
        kind=found.kind,
        start_s=round(found.start_s, 3),
        end_s=round(found.end_s, 3),
        time_s=round(found.time_s, 3),
        distance_m=round(found.distance_m, 3),
        distance_sigma_m=round(found.distance_sigma_m, 3),
        speed_mps=_plain(found.speed_mps),
        step_count=found.step_count,
        turn_count=found.turn_count,
        pause_count=found.pause_count,
        turn_s=_plain(found.turn_s),
        minutes_m=[round(float(way), 2) for way in found.minutes_m],
        reasons=list(found.reasons),
    )


def guided_kind_of(session: Session, exercise_id: str | None) -> GuidedKind:
    """Return which walking test an exercise is; any other is a walk."""
    exercise = session.get(Exercise, exercise_id) if exercise_id is not None else None
    found: dict[str, GuidedKind] = {kind: kind for kind in GUIDED_KINDS}
    return "walk" if exercise is None else found.get(exercise.movement, "walk")


def _footholds(strides: Strides, time_s: Float, place: Float, turn: Float) -> list[FootholdOut]:
    holds = strides.footholds
    rows = np.clip(np.searchsorted(time_s, holds.quietest_s), 0, len(time_s) - 1)
    w, x, y, z = turn[rows].T
    heading = np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
    sigma = np.sqrt(holds.variance_m2[:, :2].max(axis=1))
    return [
        FootholdOut(
            start_s=round(float(holds.start_s[k]), 3),
            stop_s=round(float(holds.stop_s[k]), 3),
            x_m=round(float(place[row, 0]), 4),
            y_m=round(float(place[row, 1]), 4),
            z_m=round(float(place[row, 2]), 4),
            heading_rad=round(float(heading[k]), 4),
            sigma_m=round(float(sigma[k]), 4),
        )
        for k, row in enumerate(rows.tolist())
    ]


def _stride(strides: Strides, k: int, is_counted: bool) -> StrideOut:
    plain: dict[str, Any] = {
        name: _plain(getattr(strides, name)[k])
        for name in StrideOut.model_fields
        if name not in {"number", "is_counted", "is_initiation", "is_termination", "bout", "flags"}
    }
    return StrideOut(
        number=k + 1,
        bout=int(strides.bout[k]) + 1,
        is_counted=is_counted,
        is_initiation=bool(strides.is_initiation[k]),
        is_termination=bool(strides.is_termination[k]),
        flags=int(strides.flags[k]),
        **plain,
    )


def _plain(value: Any) -> float | None:
    return round(float(value), 5) if np.isfinite(value) else None
