"""Files that hold a whole recording, read into `Recording`: our packet log, tables, research formats and makers' own.

A format is a class in a module of `app.readers.formats`. What is asked for by name here is imported at its first use:
what is no recording is refused without the libraries that reading needs.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from app.readers.contract import TEXT, Reader, Source
    from app.readers.formats.instrumented_shoe import write_instrumented_shoe
    from app.readers.formats.qmt_mat import PLACEMENT_OF
    from app.readers.log import LogReader, read_ticks
    from app.readers.markers.c3d import C3dPoints, read_c3d
    from app.readers.markers.tracks import METRES, MarkerTracks, read_markers
    from app.readers.packets import RecordingPackets, as_feet, packets_of, stamped
    from app.readers.registry import format_of, guess, read, reader_of, readers
    from app.readers.tables.guess import SINGLE, Guess, PipelineName, pipeline_for
    from app.readers.tables.preview import Preview, preview_text, preview_zip
    from app.readers.tables.text import HEAD_BYTES, later_of, start_of
    from app.readers.units import accepting

_NAMES: Final = {
    "contract": ("TEXT", "Reader", "Source"),
    "formats.instrumented_shoe": ("write_instrumented_shoe",),
    "formats.qmt_mat": ("PLACEMENT_OF",),
    "log": ("LogReader", "read_ticks"),
    "markers.c3d": ("C3dPoints", "read_c3d"),
    "markers.tracks": ("METRES", "MarkerTracks", "read_markers"),
    "packets": ("RecordingPackets", "as_feet", "packets_of", "stamped"),
    "registry": ("format_of", "guess", "read", "reader_of", "readers"),
    "tables.guess": ("SINGLE", "Guess", "PipelineName", "pipeline_for"),
    "tables.preview": ("Preview", "preview_text", "preview_zip"),
    "tables.text": ("HEAD_BYTES", "later_of", "start_of"),
    "units": ("accepting",),
}
_MODULE_OF: Final = {name: module for module, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Import what is asked for by name at its first use."""
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)


__all__ = [
    "HEAD_BYTES",
    "METRES",
    "PLACEMENT_OF",
    "SINGLE",
    "TEXT",
    "C3dPoints",
    "Guess",
    "LogReader",
    "MarkerTracks",
    "PipelineName",
    "Preview",
    "Reader",
    "RecordingPackets",
    "Source",
    "accepting",
    "as_feet",
    "format_of",
    "guess",
    "later_of",
    "packets_of",
    "pipeline_for",
    "preview_text",
    "preview_zip",
    "read",
    "read_c3d",
    "read_markers",
    "read_ticks",
    "reader_of",
    "readers",
    "stamped",
    "start_of",
    "write_instrumented_shoe",
]
