"""Every table of the service in one metadata; importing this module is what makes foreign keys resolvable.

Rooms import only their own models. Whoever opens the database as a whole (the application, migrations,
backup, the command line, tests) imports `metadata` from here.
"""

from app.accounts import models as accounts
from app.assessment import models as assessment
from app.database.base import Base
from app.exercises import models as exercises
from app.patients import models as patients
from app.recordings import models as recordings
from app.scaled import models as scaled

__all__ = ["accounts", "assessment", "exercises", "metadata", "patients", "recordings", "scaled"]

metadata = Base.metadata
