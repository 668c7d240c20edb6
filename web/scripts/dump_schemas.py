"""Write the service's wire types as one OpenAPI document, from which the browser's types are made.

Run from the root of the tree: `python web/scripts/dump_schemas.py > web/src/api/openapi.json`. The REST types come from the
application's own OpenAPI; the messages of the sockets, which OpenAPI does not cover, are added to its components.
"""

import json
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from app import schemas as base
from app.accounts import schemas as accounts
from app.assessment import schemas as assessment
from app.exercises import schemas as exercises
from app.live import messages
from app.patients import schemas as patients
from app.recordings import schemas as recordings

ROOMS = (accounts, assessment, exercises, patients, recordings, messages)
SENT_BY_CLIENTS = ("In", "Request", "Patch", "Command", "Mapping", "Column")


def models() -> list[type[BaseModel]]:
    """Return every wire type, in a fixed order."""
    found: dict[str, type[BaseModel]] = {}
    for room in ROOMS:
        for name, value in vars(room).items():
            if isinstance(value, type) and issubclass(value, base.Schema) and value is not base.Schema:
                found[name] = value
    return [found[name] for name in sorted(found)]


def document() -> dict[str, Any]:
    """Return the OpenAPI document; what clients send has its optional fields optional."""
    both = [
        (model, "validation" if model.__name__.endswith(SENT_BY_CLIENTS) else "serialization")
        for model in models()
    ]
    _, schema = models_json_schema(both, ref_template="#/components/schemas/{model}")
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "Telemotion wire types",
            "version": str(messages.PROTOCOL_VERSION),
            "x-protocol-version": messages.PROTOCOL_VERSION,
        },
        "paths": {},
        "components": {"schemas": schema["$defs"]},
    }


if __name__ == "__main__":
    json.dump(document(), sys.stdout, indent=1, sort_keys=True, ensure_ascii=False)
    sys.stdout.write("\n")
