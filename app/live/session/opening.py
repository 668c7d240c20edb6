"""From a gateway's hello to a live session: what is stored of it, the declared network, a pipeline that runs."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final

from sqlalchemy import Engine

from app.errors import Conflict, InvalidInput, PacketError
from app.live import repository
from app.live.bus import Bus
from app.live.calibration.device_rows import with_known_devices
from app.live.checks.plausibility import CheckProcess
from app.live.guidance.opening import guide_session
from app.live.session.rebuild import rebuild
from app.live.session.runner import LiveSession
from app.live.session.states import OPEN
from app.live.session.streamed import Streamed
from app.network.declaration import Declaration
from app.recordings.analysis.kinds import kind_of
from app.recordings.signals.checkpoints import load_checkpoint
from app.recordings.signals.group_commit import GroupCommitWriter
from app.time_zones import UTC_NAME
from estimators import pipelines
from estimators.calibration import Hemisphere
from estimators.errors import SetupError
from estimators.pipelines import SessionSetup
from estimators.sentences import say


@dataclass(frozen=True)
class Place:
    """Where the service stands.

    Attributes
    ----------
    hemisphere : {"north", "south", "unknown"}
        See `FirstSeconds`.
    time_zone : str
        In which a day begins for clinics that have not set theirs.
    """

    hemisphere: Hemisphere = "north"
    time_zone: str = UTC_NAME


ANYWHERE: Final = Place()


@dataclass(frozen=True)
class Opener:
    """Makes live sessions of stored ones.

    Parameters
    ----------
    writer : GroupCommitWriter
        Started.
    check : CheckProcess
        Where the first seconds are checked.
    is_exact : bool
        Sessions move from another machine while somebody watches: see `rebuild`.
    rebuilding : Semaphore
        Of those of this process that are rebuilt together.
    """

    engine: Engine
    writer: GroupCommitWriter
    bus: Bus
    place: Place
    check: CheckProcess
    is_exact: bool = False
    rebuilding: asyncio.Semaphore = field(default_factory=partial(asyncio.Semaphore, 1))

    async def open(
        self,
        session_id: str,
        declaration: Declaration,
        prepared: Callable[[SessionSetup], Awaitable[None]],
        streamed: Streamed | None = None,
    ) -> LiveSession:
        """Return a session that goes on where its stored packets end.

        Parameters
        ----------
        session_id : str
            Not live; nobody else opens or closes it meanwhile.
        declaration : Declaration
            Of the gateway.
        prepared : async callable(setup)
            Returns when what the setup needs is compiled, or raises.
        streamed : Streamed, optional
            What is stored of it: then nothing is read but the guidance of a prescription, and nothing is written.

        Raises
        ------
        Conflict
            The session is closed.
        PacketError
            The network is not that of the session.
        InvalidInput
            No pipeline can be made of the setup.
        """
        if streamed is None:
            stored = await asyncio.to_thread(repository.load, self.engine, session_id)
        else:
            stored = streamed.stored
        if stored.state not in OPEN or stored.is_ended:
            raise Conflict(say("live.closed"), state=stored.state)
        known = None if stored.hello is None else Declaration.from_dict(stored.hello)
        if known is not None:
            check_network(known, declaration)
            declaration = known
        setup = setup_for(SessionSetup.from_dict(stored.setup), declaration)
        if known is None:
            setup = await asyncio.to_thread(
                with_known_devices, self.engine, stored.clinic_id, setup, declaration
            )
        await prepared(setup)
        try:
            pipeline = pipelines.create(setup)
        except SetupError as error:
            raise InvalidInput(error.message) from error
        if streamed is None:
            result_id, first_unstored = await asyncio.to_thread(
                repository.begin_stream, self.engine, session_id, declaration.to_dict(), pipeline
            )
        else:
            # Hello, setup and result were stored when it began.
            result_id, first_unstored = streamed.result_id, streamed.first_unstored_tick
        session = LiveSession(
            stored,
            declaration,
            pipeline,
            engine=self.engine,
            writer=self.writer,
            bus=self.bus,
            result_id=result_id,
            first_unstored_tick=first_unstored,
            hemisphere=self.place.hemisphere,
            check=self.check,
        )
        await asyncio.to_thread(self._open_at_writer, session, streamed)
        if len(session.ledger.durable):
            async with self.rebuilding:
                trouble = await asyncio.to_thread(self._rebuild, session, streamed)
            if trouble is not None:
                session.line.stop(trouble)
        await asyncio.to_thread(guide_session, session, self.engine, self.bus, self.place.time_zone, streamed)
        return session

    def _open_at_writer(self, session: LiveSession, streamed: Streamed | None) -> None:
        """Let a session be stored from now on, behind what is stored of it; blocks."""
        session.ledger.durable = self.writer.open_session(
            session.id,
            session.on_durable,
            session.on_store_failure,
            None if streamed is None else streamed.standing,
        )
        session.ledger.received = session.ledger.durable.copy()

    def _rebuild(self, session: LiveSession, streamed: Streamed | None) -> Exception | None:
        """Bring a session to where what is stored of it ends; blocks. Returns why its estimation cannot go on."""
        if streamed is not None:
            return rebuild(session, self.engine, streamed.checkpoint, streamed.chunks, is_exact=True)
        checkpoint = load_checkpoint(self.engine, session.id)
        return rebuild(session, self.engine, checkpoint, is_exact=self.is_exact)


def check_network(known: Declaration, declared: Declaration) -> None:
    """Raise when a gateway declares another network than the session began with.

    Raises
    ------
    PacketError
    """
    if not known.same_network(declared):
        raise PacketError(
            say("live.network_changed"),
            reason="network_changed",
        )


def setup_for(setup: SessionSetup, declaration: Declaration) -> SessionSetup:
    """Return the setup in the packet order and at the rate of the gateway.

    Raises
    ------
    PacketError
        The gateway has other sensors than the session.
    """
    if set(setup.placements) != set(declaration.placements):
        raise PacketError(
            say("live.other_placements", places=list(setup.placements)),
            reason="placements",
        )
    return replace(
        setup,
        placements=declaration.placements,
        rate_hz=declaration.rate_hz,
        orientation_parameters=kind_of(setup).declared(setup.orientation_parameters, declaration),
    )
