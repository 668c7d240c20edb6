"""How accurate this version is: the published experiments as `telemotion validate` last measured them.

`report` makes a report and loads every protocol for it; the service only reads the stored one.
"""

from app.accuracy.endpoints import router
from app.accuracy.schemas import AccuracyReport
from app.accuracy.store import stored_report

__all__ = ["AccuracyReport", "router", "stored_report"]
