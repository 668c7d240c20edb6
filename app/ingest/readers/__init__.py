"""Files that hold a whole recording, read into `Recording`: our packet log, CSV, and research formats.

Every reader takes a path and raises `RecordingFormatError` that says what is wrong and what to do. A format's reader is
imported when a file of that format is read: what is no recording is refused without the libraries that readers need.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from app.errors import InvalidInput, RecordingFormatError
from app.ingest.readers._formats import FORMATS, TEXT, WALKS
from app.ingest.readers._text import HEAD_BYTES, start_of
from app.ingest.readers._units import accepting
from app.sentences import say
from estimators.recording import Recording

if TYPE_CHECKING:
    from app.ingest.readers._broad import read_broad
    from app.ingest.readers._c3d import C3dPoints, read_c3d
    from app.ingest.readers._csv import read_csv
    from app.ingest.readers._csv_guess import SINGLE, Guess, PipelineName, pipeline_for
    from app.ingest.readers._gait_tracking import read_gait_tracking
    from app.ingest.readers._gaitmap import read_gaitmap
    from app.ingest.readers._instrumented_shoe import read_instrumented_shoe, write_instrumented_shoe
    from app.ingest.readers._markers import METRES, MarkerTracks, read_markers
    from app.ingest.readers._packet_log import LogReader, read_packet_log, read_ticks
    from app.ingest.readers._packets import RecordingPackets, as_feet, packets_of, stamped
    from app.ingest.readers._preview import Preview, preview_text, text_format
    from app.ingest.readers._pyshoe import read_pyshoe
    from app.ingest.readers._qmt import PLACEMENT_OF, read_qmt
    from app.recordings.table_schemas import CsvMapping

_NAMES: Final = {
    "_broad": ("read_broad",),
    "_c3d": ("C3dPoints", "read_c3d"),
    "_csv": ("read_csv",),
    "_csv_guess": ("SINGLE", "Guess", "PipelineName", "pipeline_for"),
    "_gait_tracking": ("read_gait_tracking",),
    "_gaitmap": ("read_gaitmap",),
    "_instrumented_shoe": ("read_instrumented_shoe", "write_instrumented_shoe"),
    "_markers": ("METRES", "MarkerTracks", "read_markers"),
    "_mat": ("mat_format",),
    "_packet_log": ("LogReader", "read_packet_log", "read_ticks"),
    "_packets": ("RecordingPackets", "as_feet", "packets_of", "stamped"),
    "_preview": ("Preview", "preview_text", "text_format"),
    "_pyshoe": ("read_pyshoe",),
    "_qmt": ("PLACEMENT_OF", "read_qmt"),
}
_MODULE_OF: Final = {name: module for module, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Import what is asked for by name at its first use."""
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)


def read(path: Path, format: str = "auto", csv: "CsvMapping | None" = None, name: str = "") -> Recording:
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
    if format not in FORMATS:
        raise InvalidInput(say("file.format_unknown", format=format, formats=list(FORMATS)), field="format")
    if format == "csv" and csv is None:
        raise InvalidInput(say("file.csv_needs_mapping"), field="csv")
    reader = __getattr__({"qmt_mat": "read_qmt"}.get(format, f"read_{format}"))
    more = {"csv": (csv,), "gaitmap": (name or path.name,)}.get(format, ())
    found: Recording = reader(path, *more)
    return found


def guess(path: Path, name: str = "") -> str:
    """Return the format that a file seems to have.

    Parameters
    ----------
    path : Path
    name : str
        What the file was called before it was uploaded. By default its name.

    Raises
    ------
    RecordingFormatError
        Nothing fits.
    """
    start = start_of(path)
    called = Path(name or path.name)
    ending = called.suffix.lower()
    if start.startswith(b"TML1"):
        return "packet_log"
    if start.startswith(b"\x89HDF"):
        return "broad"
    if ending == ".mat":
        return str(__getattr__("mat_format")(path))
    if ending in TEXT:
        return str(__getattr__("text_format")(called.stem, start))
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
    "text_format",
    "write_instrumented_shoe",
]
