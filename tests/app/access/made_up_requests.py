"""Hook of the made-up requests: most name things that exist, so that they come further than `not found`."""

import json
import os
import zlib
from pathlib import Path
from typing import Any

import schemathesis

KNOWN: dict[str, str] = json.loads(Path(os.environ["TELEMOTION_TEST_KNOWN"]).read_text())


@schemathesis.hook
def map_path_parameters(context: Any, path_parameters: dict[str, Any] | None) -> dict[str, Any] | None:
    """Replace three of four identifiers by that of a thing in the seed, except where it would be erased."""
    if path_parameters and context.operation.method.upper() != "DELETE":
        for name, value in path_parameters.items():
            if name in KNOWN and zlib.crc32(repr(value).encode()) % 4:
                path_parameters[name] = KNOWN[name]
    return path_parameters
