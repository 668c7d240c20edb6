"""Files that hold a whole recording, read into `Recording`: our packet log, CSV, and research formats.

Every reader takes a path and raises `RecordingFormatError` that says what is wrong and what to do.
"""

from pathlib import Path

from app.errors import InvalidInput, RecordingFormatError
from app.ingest.readers import _pyshoe
from app.ingest.readers._broad import read_broad
from app.ingest.readers._c3d import C3dPoints, read_c3d
from app.ingest.readers._csv import read_csv
from app.ingest.readers._csv_guess import SINGLE, Guess, PipelineName
from app.ingest.readers._gait_tracking import read_gait_tracking
from app.ingest.readers._gaitmap import read_gaitmap
from app.ingest.readers._instrumented_shoe import read_instrumented_shoe, write_instrumented_shoe
from app.ingest.readers._markers import METRES, MarkerTracks, read_markers
from app.ingest.readers._mat import variables
from app.ingest.readers._packet_log import LogReader, read_packet_log, read_ticks
from app.ingest.readers._packets import RecordingPackets, as_feet, packets_of, stamped
from app.ingest.readers._preview import FORMATS, TEXT, WALKS, Preview, pipeline_for, preview_text, text_format
from app.ingest.readers._pyshoe import read_pyshoe
from app.ingest.readers._qmt import PLACEMENT_OF, read_qmt
from app.ingest.readers._text import HEAD_BYTES, start_of
from app.ingest.readers._units import accepting
from app.recordings.schemas import CsvMapping
from app.sentences import say
from estimators.recording import Recording


def read(path: Path, format: str = "auto", csv: CsvMapping | None = None, name: str = "") -> Recording:
    """Read a recording.

    Parameters
    ----------
    path : Path
    format : str
        One of `FORMATS`, or `auto`: by the file's ending and content.
    csv : CsvMapping, optional
        Needed for CSV: which column is what, in which unit.
    name : str
        What the file was called before it was uploaded: says the side of a foot. By default its name.

    Raises
    ------
    RecordingFormatError
        The file is not what it was declared to be; the message says what to do.
    InvalidInput
        The format is unknown, or a CSV comes without its mapping.
    """
    if format == "auto":
        format = guess(path)
        if csv is not None and path.suffix.lower() in TEXT:
            format = "csv"
    match format:
        case "packet_log":
            return read_packet_log(path)
        case "csv":
            if csv is None:
                raise InvalidInput(say("file.csv_needs_mapping"), field="csv")
            return read_csv(path, csv)
        case "qmt_mat":
            return read_qmt(path)
        case "broad":
            return read_broad(path)
        case "pyshoe":
            return read_pyshoe(path)
        case "gait_tracking":
            return read_gait_tracking(path)
        case "gaitmap":
            return read_gaitmap(path, name or path.name)
        case "instrumented_shoe":
            return read_instrumented_shoe(path)
    raise InvalidInput(say("file.format_unknown", format=format, formats=list(FORMATS)), field="format")


def guess(path: Path) -> str:
    """Return the format that a file seems to have.

    Raises
    ------
    RecordingFormatError
        Nothing fits.
    """
    start = start_of(path)
    if start.startswith(b"TML1"):
        return "packet_log"
    if start.startswith(b"\x89HDF"):
        return "broad"
    if path.suffix.lower() == ".mat":
        names = variables(path)
        if set(_pyshoe.MARKS) <= names:
            return "pyshoe"
        return "broad" if "imu_gyr" in names else "qmt_mat"
    if path.suffix.lower() in TEXT:
        return text_format(path.stem, start)
    raise RecordingFormatError(say("file.format_not_recognised", formats=list(FORMATS)))


__all__ = [
    "FORMATS",
    "HEAD_BYTES",
    "METRES",
    "PLACEMENT_OF",
    "SINGLE",
    "TEXT",
    "WALKS",
    "C3dPoints",
    "Guess",
    "LogReader",
    "MarkerTracks",
    "PipelineName",
    "Preview",
    "RecordingPackets",
    "accepting",
    "as_feet",
    "guess",
    "packets_of",
    "pipeline_for",
    "preview_text",
    "read",
    "read_broad",
    "read_c3d",
    "read_csv",
    "read_gait_tracking",
    "read_gaitmap",
    "read_instrumented_shoe",
    "read_markers",
    "read_packet_log",
    "read_pyshoe",
    "read_qmt",
    "read_ticks",
    "stamped",
    "start_of",
    "write_instrumented_shoe",
]
