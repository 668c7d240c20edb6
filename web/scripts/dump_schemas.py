"""Write what the browser shares with the service: the wire types as one OpenAPI document, or the measures.

Run from the root of the tree: `python web/scripts/dump_schemas.py > web/src/api/openapi.json`, with `measures` for
`web/src/api/measures.json`. The REST part is the application's own OpenAPI; the messages of the sockets, which OpenAPI
does not cover, are added to its components.
"""

import json
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from app.edge.description import describe
from app.live.calibration.messages import CalibrationMessage
from app.live.guidance.messages import GuidanceMessage
from app.live.messages import (
    CameraCommand,
    EventMessage,
    HealthMessage,
    LayoutMessage,
    PlayerCommand,
    PlayerState,
    PulseMessage,
    StateMessage,
)
from app.main import create_app
from app.network.messages import PROTOCOL_VERSION, ErrorMessage
from app.readers.markers.schemas import MarkerUploadIn
from app.recordings import schemas as recordings
from app.settings import Settings
from estimators.measures import MEASURES, measures_of

SENT_BY_BROWSERS = (PlayerCommand, CameraCommand)
FORM_PARTS = (recordings.UploadIn, MarkerUploadIn)
"""JSON parts of multipart forms, which OpenAPI shows as plain text."""
SENT_TO_BROWSERS = (
    LayoutMessage,
    StateMessage,
    HealthMessage,
    GuidanceMessage,
    EventMessage,
    ErrorMessage,
    PlayerState,
    PulseMessage,
    CalibrationMessage,
)


def socket_schemas() -> dict[str, Any]:
    """Return the schemas of the messages; what browsers send has its optional fields optional."""
    models: list[tuple[type[BaseModel], Any]] = [
        *((one, "validation") for one in SENT_BY_BROWSERS),
        *((part, "validation") for part in FORM_PARTS),
        *((one, "serialization") for one in SENT_TO_BROWSERS),
    ]
    _, schema = models_json_schema(models, ref_template="#/components/schemas/{model}")
    return dict(schema["$defs"])


def document() -> dict[str, Any]:
    """Return the OpenAPI document with the messages among its components."""
    openapi = describe(create_app(Settings(demo=True, _env_file=None)))
    info = {
        "title": openapi["info"]["title"],
        "version": str(PROTOCOL_VERSION),
        "x-protocol-version": PROTOCOL_VERSION,
    }
    components = openapi["components"]
    components["schemas"] = {**socket_schemas(), **components["schemas"]}
    return {"openapi": openapi["openapi"], "info": info, "paths": openapi["paths"], "components": components}


def measures() -> dict[str, Any]:
    """Return the names of measures by their part, in the order in which they are shown.

    The main ones, then all others; `indices` are those of a repetition that only who studies movement reads.
    """
    parts = dict.fromkeys(one.part for one in MEASURES)
    return {"indices": [one.name for one in MEASURES if one.is_index]} | {
        part: {"main": measures_of(part, is_main=True), "more": measures_of(part, is_main=False)}
        for part in parts
    }


if __name__ == "__main__":
    shared = measures() if sys.argv[1:] == ["measures"] else document()
    json.dump(shared, sys.stdout, indent=1, sort_keys=True, ensure_ascii=False)
    sys.stdout.write("\n")
