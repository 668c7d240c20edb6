"""Wire types of sessions, results, jobs and views."""

from datetime import datetime
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from pydantic import Field

from app.readers.tables.schemas import CsvMapping
from app.schemas import Flag, Moment, Schema, SessionState, Spoken
from estimators.calibration import Calibration
from estimators.conventions import Placement
from estimators.orientation import DEFAULT
from estimators.pipelines import available

if TYPE_CHECKING:
    StreamedKind: TypeAlias = str
    UploadedKind: TypeAlias = str
else:
    StreamedKind = Literal[tuple(name for name, kind in available().items() if kind.is_streamed)]
    UploadedKind = Literal[tuple(name for name, kind in available().items() if kind.is_uploaded)]


class SessionIn(Schema):
    """A new session; the rate and placements are confirmed by the gateway's hello."""

    patient_id: str
    exercise_id: str | None = None
    prescription_id: str | None = None
    purpose: Literal["exercise", "template"] = "exercise"
    pipeline: StreamedKind = "arm"
    """`gait` follows sensors on the feet, `relative_pose` a worn magnetic source and the sensors around it: neither
    is to be calibrated. `balance` is a test of standing."""
    placements: list[Placement] = Field(min_length=1, max_length=17)
    feet_apart_m: float | None = Field(default=None, ge=0.0, le=0.6)
    """Of a walk: distance of the feet side by side at its start, where somebody measured it."""
    rate_hz: float = Field(default=100.0, ge=10, le=1000)
    orientation: str = DEFAULT
    orientation_parameters: dict[str, Any] = Field(default_factory=dict)
    magnetic_source_id: str | None = None
    """Of a magnetic session: the source of the clinic that is worn; its measured coils take the place of typed ones."""
    constrain_joint_headings: Flag = False
    """Let elbows and wrists bound heading drift: for sensors without magnetometers or near iron."""
    use_mounting: Flag = True
    """Start with how the sensors sat on this patient last time, if that is known for these placements; headings are
    set by a pose or a heading reset before the session is ready."""


class ResultOut(Spoken):
    """One run of a pipeline over the session."""

    id: str
    kind: Literal["live", "offline"]
    pipeline: str
    pipeline_version: str
    orientation: str
    orientation_version: str
    orientation_parameters: dict[str, Any]
    status: Literal["running", "complete", "failed"]
    progress: float
    message: str
    created_at: datetime


class SessionOut(Spoken):
    """A session in a list."""

    id: str
    patient_id: str
    exercise_id: str | None
    exercise_name: str | None
    pipeline: str
    """As in `SessionIn`, or `orientation`: single sensors of an upload. It names a session without an exercise."""
    prescription_id: str | None
    purpose: Literal["exercise", "template"]
    source: Literal["stream", "upload"]
    state: SessionState
    state_reason: str
    created_at: datetime
    started_at: datetime | None
    ended_at: datetime | None
    duration_s: float
    packets_stored: int
    packets_missing: int
    main_result_id: str | None


class SessionEventOut(Spoken):
    """Something on the time line: state, gap, sensor_lost, sensor_back, sensor_slipped, mark, calibration, error."""

    kind: str
    time_s: float
    duration_s: float
    placement: str | None
    text: str
    label: str | None = None
    """Of a mark that an analysis reads: see `MarkIn`."""


class FrameLayoutOut(Schema):
    """Columns of the frames."""

    segments: list[str]
    points: list[str]
    angles: list[str]
    scalars: list[str]


class CalibrationOut(Spoken):
    """Result of a calibration step."""

    method: str
    score: float
    reasons: list[str]
    needs_headings: bool = False
    """The mounting is remembered from an earlier session; a pose or a heading reset must tell the headings first."""

    @classmethod
    def of(cls, found: Calibration) -> "CalibrationOut":
        """Return a calibration as clients see it."""
        return cls(
            method=found.method,
            score=found.score,
            reasons=list(found.reasons),
            needs_headings=bool(found.unknown_headings),
        )


class SessionDetail(SessionOut):
    """A session with what was done with it."""

    placements: list[str]
    """A `Placement` each; of the pipeline `orientation` any name."""
    rate_hz: float
    orientation: str
    orientation_parameters: dict[str, Any]
    constrain_joint_headings: bool
    calibration: CalibrationOut | None
    recording_start_s: float | None
    recording_end_s: float | None
    results: list[ResultOut]
    events: list[SessionEventOut]
    layout: FrameLayoutOut
    may_treat: bool


class ReprocessIn(Schema):
    """Estimate a stored session again; the earlier results stay."""

    orientation: str
    orientation_parameters: dict[str, Any] = Field(default_factory=dict)


class MarkIn(Schema):
    """A note on the time line, at the present session time."""

    text: str = Field(default="", max_length=200)
    label: str | None = Field(default=None, max_length=40)
    """A mark that the analysis of this kind of session reads, such as the condition that begins; `text` is then what
    the service says of it."""


class JobOut(Spoken):
    """A long task with its progress from 0 to 1."""

    id: str
    session_id: str
    kind: Literal["upload", "reprocess", "compare", "markers"]
    status: Literal["queued", "running", "complete", "failed"]
    progress: float
    message: str
    is_implausible: bool
    """Failed because the readings of an upload cannot be right; see `accept_implausible`."""


class FormatOut(Schema):
    """A file format that is read."""

    name: str
    title: str
    description: str
    endings: list[str]
    """With the point; a file with another is looked into as well."""
    pipeline: UploadedKind | None
    """The only kind of session that such a file can be; None: it depends."""
    asks_pipeline: bool
    """Whether a person says what kind it is."""
    needs_mapping: bool
    """Whether a person says which column is what."""


class UploadIn(Schema):
    """The JSON part `declaration` of an upload; the file is the other part."""

    patient_id: str
    exercise_id: str | None = None
    prescription_id: str | None = None
    purpose: Literal["exercise", "template"] = "exercise"
    format: str | None = Field(default=None, max_length=40)
    """One of `GET /api/uploads/formats`; None: found from its name and beginning."""
    file_name: str = Field(default="", max_length=200)
    """What the file is called: says its format, and the side of a foot, where the file does not."""
    pipeline: UploadedKind | None = None
    """What the file holds, where its format leaves that open; None: what its sensors are worn for."""
    with_legs: Flag = False
    """Also estimate sensors on the legs, for the centre of mass: they must be still and straight in the pose too."""
    csv: CsvMapping | None = None
    orientation: str = DEFAULT
    calibration_pose_s: tuple[float, float] | None = None
    """Half-open interval in which the patient stands in N-pose; None looks for stillness at the start."""
    hemisphere: Literal["north", "south", "unknown"] | None = None
    """Where it was recorded: the magnetic field tells a reversed accelerometer. None: where the service is."""
    feet_apart_m: float | None = Field(default=None, ge=0.0, le=0.6)
    feet_apart_end_m: float | None = Field(default=None, ge=0.0, le=0.6)
    """Of a walk: distance of the feet side by side at its start and its end, where somebody measured it."""
    recorded_at: Moment | None = None
    """When it was recorded: the session counts for that day. None: as the file says, else the day of the upload, and
    the session says so."""
    accept_implausible: Flag = False
    """Estimate although units, axes or signs cannot be right; a first attempt says what was found."""


class ParameterOut(Schema):
    """One parameter of an estimator."""

    name: str
    """Key in `orientation_parameters`."""
    label: str
    unit: str
    """Empty for switches and plain numbers."""
    default: bool | float | int | str


class EstimatorOut(Schema):
    """A choice of orientation estimator."""

    name: str
    version: str
    title: str
    description: str
    """One plain sentence."""
    parameters: dict[str, Any]
    """Defaults by name."""
    parameter_list: list[ParameterOut]
    is_offline: bool
    """Needs the whole session: for uploads and to estimate again, not for a live session."""


class AngleDifference(Schema):
    """How far a column of two results is apart; None where nothing could be compared."""

    name: str
    rms_deg: float | None
    mean_deg: float | None
    """First result minus second; of segments the mean angle."""
    maximum_deg: float | None
    maximum_at_s: float | None
    compared_s: float
    """Both results sound: no gap, not starting, not near a singular position."""


class CurvePair(Schema):
    """One joint angle of both results at the times of `DifferencesOut.time_s`; None where there is nothing."""

    name: str
    a_deg: list[float | None]
    b_deg: list[float | None]


class DifferencesOut(Schema):
    """Two results of one session beside each other."""

    result_a: ResultOut
    result_b: ResultOut
    angles: list[AngleDifference]
    segments: list[AngleDifference]
    """Angle between the orientations of a segment."""
    time_s: list[float]
    curves: list[CurvePair]


class SequenceOut(Schema):
    """A joint in a rotation sequence; None where there is nothing."""

    names: list[str]
    """Joint, side, sequence and meaning of the three angles, e.g. `thorax_humerus_left_xzy_abduction`."""
    time_s: list[float]
    angles_deg: list[list[float | None]]
    """One list an angle, unwrapped in time."""
    singular_distance_deg: list[float | None]
    """Smallest turn that would make first and last angle inseparable; an error grows by 1/sin of it."""


class ReprocessAllIn(Schema):
    """Estimate a stored session with several estimators, a task each."""

    orientations: list[str] = Field(default_factory=list, max_length=20)
    """Names; empty means every estimator."""
    skip_present: Flag = True
    """Leave out what a complete result of the same version with default parameters exists of."""


ViewLanguage = Literal["en", "de"]
"""Languages of the words within a picture."""


class ViewIn(Schema):
    """Open a 3D view."""

    mode: Literal["live", "replay"]
    result_id: str | None = None
    template_version_id: str | None = None
    markers_id: str | None = None
    """In a replay: the fused motion of these markers instead of the body."""
    language: ViewLanguage = "en"
    """Of the words within the picture."""


class ViewOut(Schema):
    """A 3D view: the page for the frame element and the socket that steers it."""

    id: str
    page_path: str
    """`/viewer/{view}/`"""
    control_path: str
    """`/ws/views/{view}`; see `app.live.messages`."""
    expires_at: datetime
