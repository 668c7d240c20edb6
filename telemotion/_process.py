"""Estimation of a recording that was read."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from app.commands.processing.estimate import Asked, Estimated, estimated, table_of
from estimators.pipelines import Frames, SessionSetup, ShoeWalk, Walk
from telemotion._read import Read

if TYPE_CHECKING:
    import pyarrow as pa

_SMOOTHER = "telemotion_smoother"


@dataclass(frozen=True)
class Processed:
    """What was estimated of a recording.

    Attributes
    ----------
    frames : Frames
        Orientations, joint angles, points and their uncertainty at common ticks.
    setup : SessionSetup
        As it was used, with the calibration that was found.
    walk : Walk or None
        Of a walk its strides and measures.
    forces : ShoeWalk or None
        Of instrumented shoes ground reaction, moments and centre of mass.
    notes : tuple of str
        What was assumed or doubted, in reading and since.
    """

    frames: Frames
    setup: SessionSetup
    walk: Walk | None
    forces: ShoeWalk | None
    notes: tuple[str, ...]

    def table(self) -> "pa.Table":
        """Return the frames as a table of pyarrow, with unit and meaning of each column in its metadata.

        `table.to_pandas()` needs pandas, which is not installed with this package.
        """
        return table_of(Estimated(self.frames, self.setup, self.walk, self.forces))


def process(
    read: Read,
    *,
    kind: str | None = None,
    orientation: str | None = None,
    rate_hz: float | None = None,
    pose_s: tuple[float, float] | None = None,
    parameters: Mapping[str, Any] | None = None,
    force: bool = False,
) -> Processed:
    """Estimate a recording as the service does live: each tick from what came before it.

    Parameters
    ----------
    read : Read
        By `telemotion.read`.
    kind : str, optional
        Of session; what its sensors are worn for without.
    orientation : str, optional
        Filter, a key of `estimators.orientation.available(with_offline=True)`; our own without.
    rate_hz : float, optional
        Of the common ticks, Hz; that of the recording without.
    pose_s : (float, float), optional
        Begin and end of the N-pose in recording time, s; the first stillness without.
    parameters : mapping, optional
        Of the filter.
    force : bool
        Estimate although the readings are implausible; `notes` then says what they are.

    Raises
    ------
    app.errors.InvalidInput
        An unknown name, or readings that cannot be right; the message says why and what to correct.
    estimators.errors.EstimationError
        The recording has not what the kind needs, for instance no stillness.
    """
    notes = list(read.notes)
    asked = Asked(
        read.format,
        kind or read.kind,
        orientation or "",
        rate_hz,
        pose_s,
        dict(parameters or {}),
        force,
        read.hemisphere,
    )
    found = estimated(read.recording, asked, notes.append)
    return Processed(found.frames, found.setup, found.walk, found.forces, tuple(notes))


def smooth(
    read: Read,
    *,
    kind: str | None = None,
    rate_hz: float | None = None,
    pose_s: tuple[float, float] | None = None,
    parameters: Mapping[str, Any] | None = None,
    force: bool = False,
) -> Processed:
    """Estimate a recording with each tick from what came before and after it; otherwise as `process`.

    Parameters
    ----------
    parameters : mapping, optional
        Of the smoother, see `estimators.orientation.SmootherParameters`.
    """
    return process(
        read,
        kind=kind,
        orientation=_SMOOTHER,
        rate_hz=rate_hz,
        pose_s=pose_s,
        parameters=parameters,
        force=force,
    )
