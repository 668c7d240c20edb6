"""The kind of a file that no reader takes, by its first bytes: a refusal says what to export instead."""

import re
from typing import Final

from estimators.sentences import Sentence, say

_LOOKED_AT: Final = 8192
_ZIP: Final = b"PK\x03\x04"
_MARKS: Final = (
    (b"%PDF", "document"),
    (b"{\\rtf", "document"),
    (b"\x89PNG", "picture"),
    (b"\xff\xd8\xff", "picture"),
    (b"GIF8", "picture"),
    (b"\x1aE\xdf\xa3", "video"),
    (b"RIFF", "video"),
    (b"ID3", "video"),
    (b"OggS", "video"),
    (b"\x1f\x8b", "packed"),
    (b"7z\xbc\xaf\x27\x1c", "packed"),
    (b"Rar!", "packed"),
    (b"BZh", "packed"),
    (b"\xfd7zXZ", "packed"),
    (b"SQLite format 3", "database"),
    (b"PAR1", "data_frame"),
    (b"ARROW1", "data_frame"),
    (b"\x93NUMPY", "data_frame"),
    (b"\x80\x04\x95", "data_frame"),
    (b"\x80\x05\x95", "data_frame"),
    (b"XDF:", "xdf"),
    (b"\x02\x50", "c3d"),
    (b"\xfa\xff", "mtb"),
    (b"MD\xfc\x03", "activity"),
)
_ENDINGS: Final = {
    ".ximu3": "ximu3",
    ".mtb": "mtb",
    ".cwa": "activity",
    ".gt3x": "activity",
    ".c3d": "c3d",
    ".xdf": "xdf",
}
_MEMBERS: Final = (
    (b"xl/", "workbook"),
    (b"opendocument.spreadsheet", "workbook"),
    (b"Index/Tables/", "workbook"),
    (b"word/", "document"),
    (b"ppt/", "document"),
    (b"opendocument.", "document"),
    (b".npy", "data_frame"),
    (b"log.bin", "activity"),
)
"""Names in what is a zip and is called otherwise."""
_WORKBOOK_WORDS: Final = (b"W\0o\0r\0k\0b\0o\0o\0k\0", b"B\0o\0o\0k\0")
_OLD_OFFICE: Final = b"\xd0\xcf\x11\xe0"


def what_it_is(start: bytes, ending: str = "") -> Sentence | None:
    """Return what a file is that is no recording here, and what to choose instead; None where that is not known.

    Parameters
    ----------
    start : bytes
        Its beginning.
    ending : str
        Of its name, in small letters with the point.
    """
    if start.startswith(_ZIP):
        kind = next((kind for mark, kind in _MEMBERS if mark in start), None)
    elif start.startswith(_OLD_OFFICE):
        kind = "workbook" if ending == ".xls" or _names_a_workbook(start) else "document"
    elif start[4:8] == b"ftyp":
        kind = "video"
    else:
        kind = next((kind for mark, kind in _MARKS if start.startswith(mark)), None) or _of_text(start)
    if kind in (None, "json", "xml"):
        # A maker's ending says more: a recording of x-IMU3 begins with a line of JSON.
        kind = _ENDINGS.get(ending, kind)
    return None if kind is None else say("file.foreign", kind=kind)


def _names_a_workbook(start: bytes) -> bool:
    return any(word in start for word in _WORKBOOK_WORDS)


def _of_text(start: bytes) -> str | None:
    """Return what a text is that is no table."""
    text = start[:_LOOKED_AT].removeprefix(b"\xef\xbb\xbf").lstrip()
    if text[:1] == b"<":
        if b"<mvnx" in text:
            return "mvnx"
        is_page = re.match(rb"<(!doctype html|html)", text, re.IGNORECASE)
        return "web_page" if is_page else "xml" if text.startswith(b"<?xml") else None
    if re.match(rb'\{\s*"|\[\s*[\[{]', text):
        return "json"
    if re.search(rb"^endheader\s*$", text, re.MULTILINE):
        return "opensim"
    return None
