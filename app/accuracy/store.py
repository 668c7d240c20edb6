"""The report that is shipped with the package, read once."""

from functools import cache
from importlib.resources import files

from app.accuracy.schemas import AccuracyReport
from app.errors import NotFound
from estimators.sentences import say

FILE = "report.json"
"""Written by `telemotion validate --out app/accuracy/report.json`, so that every number has its command."""


@cache
def stored_report() -> AccuracyReport:
    """Return the report that was shipped with this version.

    Raises
    ------
    NotFound
        It was left out of this build.
    """
    file = files("app.accuracy") / FILE
    if not file.is_file():
        raise NotFound(say("edge.no_accuracy"))
    return AccuracyReport.model_validate_json(file.read_text(encoding="utf-8"))
