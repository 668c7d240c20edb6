"""The contract of a kind of session, and how the service finds it.

A kind is a folder of `app.kinds` with a `KIND` in its module `kind`. Nothing outside `app.kinds` asks which kind a
session is: it asks the kind. What all kinds share is the general way (`app.recordings.analysis.offline`), which needs
none of these.
"""

import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any, ClassVar, Literal

from fastapi import APIRouter
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.errors import InvalidInput
from app.network.declaration import Declaration
from app.recordings.analysis.curve import Series
from app.recordings.analysis.heading_line import HeadingReset
from app.recordings.analysis.jobs import JobContext
from app.recordings.analysis.offline import Analysis
from app.recordings.compared import Source, body_source
from app.recordings.models import MotionSession, Result
from app.recordings.schemas import SessionIn
from estimators.orientation import DEFAULT
from estimators.pipelines import Pipeline, SessionSetup
from estimators.recording import Recording
from estimators.sentences import say

View = Literal["body", "feet", "modules"]


@dataclass(frozen=True)
class Wanted:
    """An off-line analysis of a stored session.

    Attributes
    ----------
    setup : SessionSetup
        With its calibration, or without: then the pose is evaluated first and applied to the whole session.
    pose_s : (float, float) or None
        Half-open session time of the N-pose.
    search_pose : bool
        Without `pose_s`, take the first stillness of the first two minutes.
    progress_from : float
        Where on the task's scale of 0 to 1 this work begins.
    resets : sequence of HeadingReset
        Made again at their ticks.
    """

    context: JobContext
    setup: SessionSetup
    pose_s: tuple[float, float] | None = None
    search_pose: bool = False
    progress_from: float = 0.0
    resets: Sequence[HeadingReset] = ()


class SessionKind(ABC):
    """One kind of session: what differs from the general way."""

    pipeline: ClassVar[type[Pipeline]]
    view: ClassVar[View] = "body"
    """What stands in the middle of its 3D scene."""
    calibration_refused: ClassVar[str] = ""
    """Why a guided calibration makes no sense; empty where it does."""
    estimator_refused: ClassVar[str] = ""
    """Why it is not estimated with other orientation estimators; empty where it is."""
    guidance_refused: ClassVar[str] = ""
    """Why nobody can be guided by a template while it goes on; empty where somebody can."""
    live_frames_hz: ClassVar[float | None] = None
    """How many live frames a second are stored at least; None for all. Few are enough where the analysis finds
    everything again from the packets and no column tells of a single tick, as a pulse or a contact does."""
    series: ClassVar[tuple[Series, ...]] = ()
    """Curves over time that its results have."""
    marks: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """Labels of marks that its analysis reads, and what the time line says of each."""

    @abstractmethod
    def analyse(self, wanted: Wanted) -> Analysis:
        """Estimate a stored session as a new result."""

    def compared(self, session: Session, found: MotionSession, result: Result) -> Source:
        """Return what of a result is compared with a template; access was checked.

        Raises
        ------
        InvalidInput
            The result holds nothing to compare.
        """
        return body_source(session, found, result)

    def closed(self, context: JobContext, setup: SessionSetup) -> None:  # noqa: B027 - most kinds hold nothing else
        """Analyse what else a session holds that was closed and analysed; by default nothing."""

    def parameters(self, session: Session, subject: Subject, wanted: SessionIn) -> dict[str, Any]:
        """Return the estimator's parameters of a session that is started.

        Raises
        ------
        InvalidInput
            A magnetic source is named, and this kind has none.
        """
        if wanted.magnetic_source_id is not None:
            raise InvalidInput(say("magnetic.only_magnetic"), field="magnetic_source_id")
        return wanted.orientation_parameters

    def declared(self, parameters: Mapping[str, Any], network: Declaration) -> dict[str, Any]:
        """Return the estimator's parameters with what the gateway declared of its devices."""
        return dict(parameters)

    def live_stride(self, rate_hz: float) -> int:
        """Return of how many ticks one live frame is stored."""
        return 1 if self.live_frames_hz is None else max(1, int(rate_hz / self.live_frames_hz + 1e-6))

    def require_safe(self, session: Session, found: MotionSession, hours: float) -> None:  # noqa: B027 - as above
        """Refuse to stream a session that nobody has confirmed to be safe within `hours`.

        Raises
        ------
        SafetyUnconfirmed
            With the session and what to do.
        """

    def store_auxiliary(self, session: Session, session_id: str, recording: Recording) -> Recording:
        """Store what packets cannot carry of an uploaded recording; return what they can."""
        return recording

    @abstractmethod
    def warm_up(self, orientation: str = DEFAULT) -> None:
        """Run its pipeline over moments of stillness, so that all its kernels are loaded or compiled."""


@cache
def kinds() -> Mapping[str, SessionKind]:
    """Return the kinds of session by the name of their pipeline."""
    folders = [one.name for one in pkgutil.iter_modules(import_module("app.kinds").__path__) if one.ispkg]
    found: list[SessionKind] = [import_module(f"app.kinds.{name}.kind").KIND for name in folders]
    return {kind.pipeline.name: kind for kind in found}


def kind_routers() -> list[APIRouter]:
    """Return the routes of all kinds: `router` of every module of their folders that is named `...endpoints`."""
    return [
        import_module(module.name).router
        for module in pkgutil.walk_packages(import_module("app.kinds").__path__, "app.kinds.")
        if module.name.endswith("endpoints")
    ]


def kind_of(setup: SessionSetup | Mapping[str, Any]) -> SessionKind:
    """Return the kind of a session by its setup, as an object or as it is stored."""
    return kinds()[setup.pipeline if isinstance(setup, SessionSetup) else str(setup["pipeline"])]
