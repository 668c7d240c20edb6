"""Stored sessions estimated by an off-line smoother: all pieces are read, then given again with orientation."""

from collections.abc import Iterable, Iterator, Mapping

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.network.declaration import Declaration
from app.patients.models import SensorDevice
from app.recordings.models import MotionSession
from estimators import orientation, pipelines
from estimators.conventions import Placement
from estimators.orientation import DeviceConstants, OrientationResult, SmoothedChunk
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk


class SmoothedSession:
    """A whole session with the orientation of every sensor.

    Sensors are smoothed one after the other, so an hour of 17 at 100 Hz takes about a gigabyte.

    Parameters
    ----------
    pieces : iterable of ImuChunk
        Consecutive ticks as measured, sensors in the order of the setup.
    setup : SessionSetup
        Names a smoother.
    """

    def __init__(self, pieces: Iterable[ImuChunk], setup: SessionSetup) -> None:
        self._pieces = list(pieces)
        self._found: OrientationResult | None = None
        self.constants: tuple[DeviceConstants, ...] = ()
        if self._pieces:
            self._found, self.constants = pipelines.smooth_network(self._pieces, setup)
        self.learnt = dict(zip(setup.placements, self.constants, strict=False))
        """What the session taught about each sensor, by placement."""

    def __iter__(self) -> Iterator[ImuChunk]:
        """Yield the pieces as they came, with orientation."""
        start = 0
        for piece in self._pieces:
            stop = start + piece.tick_count
            yield self._with_orientation(piece, start, stop)
            start = stop

    def _with_orientation(self, piece: ImuChunk, start: int, stop: int) -> SmoothedChunk:
        if self._found is None:
            raise ValueError("a session without pieces has no orientation")
        found = self._found.ticks(start, stop)
        return orientation.with_orientation(piece, found, self.constants)


def remember(session: Session, found: MotionSession, learnt: Mapping[Placement, DeviceConstants]) -> None:
    """Keep what a closed session, smoothed, taught about its sensors; better than what was known while it ran.

    A sensor that another session has taught since, or that tells no serial number, is left alone.
    """
    if not found.hello or not learnt:
        return
    serials = Declaration.from_dict(found.hello).serial_of
    rows = session.scalars(
        select(SensorDevice).where(
            SensorDevice.clinic_id == found.clinic_id, SensorDevice.session_id == found.id
        )
    )
    by_serial = {row.serial: row for row in rows}
    for placement, constants in learnt.items():
        row = by_serial.get(serials.get(placement, ""))
        if row is not None and row.constants and constants != DeviceConstants():
            row.constants = constants.to_dict()


def smoother_for(filter_name: str) -> str | None:
    """Return the smoother of the same method as a live filter, if there is one."""
    return next((name for name, kind in orientation.smoothers().items() if kind.follows == filter_name), None)
