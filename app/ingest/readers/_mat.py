"""MATLAB files of versions 4 to 7, from strangers."""

from pathlib import Path
from typing import Any, Final

import scipy

from app.errors import RecordingFormatError
from app.ingest.readers._unpacked import check_mat
from app.sentences import say

PYSHOE_MARKS: Final = ("imu_data", "timestamps_all")
"""Variables by which a walk of the PyShoe set is known."""


def load_mat(path: Path, names: list[str], *, simplify: bool = False) -> dict[str, Any]:
    """Return the named variables that the file holds.

    Raises
    ------
    RecordingFormatError
        The file cannot be read, or unpacks to too much.
    """
    check_mat(path)
    try:
        content: dict[str, Any] = scipy.io.loadmat(path, variable_names=names, simplify_cells=simplify)
    except NotImplementedError as error:
        raise RecordingFormatError(say("mat.version")) from error
    except MemoryError:
        raise
    except Exception as error:
        # The reader follows whatever the bytes say and fails with whatever error that leads to.
        raise RecordingFormatError(say("mat.unreadable")) from error
    return content


def mat_format(path: Path) -> str:
    """Return which of the formats stored in such files one seems to have, by the names in it.

    Raises
    ------
    RecordingFormatError
        The file cannot be read.
    """
    try:
        names = {name for name, _, _ in scipy.io.whosmat(path)}
    except Exception as error:
        raise RecordingFormatError(say("mat.unreadable")) from error
    if set(PYSHOE_MARKS) <= names:
        return "pyshoe"
    return "broad" if "imu_gyr" in names else "qmt_mat"


__all__ = ["PYSHOE_MARKS", "load_mat", "mat_format"]
