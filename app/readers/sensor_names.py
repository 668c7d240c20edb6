"""Allowed names of sensors: a name becomes a heading of tables that people open in a spreadsheet."""

import re
from collections.abc import Iterable
from typing import Final

from app.errors import RecordingFormatError
from estimators.sentences import say

PATTERN: Final = r"^(?:\w[\w .-]*)?$"
"""Letters, digits, blanks, `_`, `-` and `.`, a letter or digit first."""
_NAME: Final = re.compile(r"\w[\w .-]*")


def check_names(names: Iterable[str]) -> None:
    """Refuse names of sensors that hold anything else.

    Raises
    ------
    RecordingFormatError
    """
    wrong = [name for name in names if not _NAME.fullmatch(name)]
    if wrong:
        shown = ["".join(one if one.isprintable() else "?" for one in name[:40]) for name in wrong[:5]]
        raise RecordingFormatError(say("file.sensor_name", names=shown), names=shown)
