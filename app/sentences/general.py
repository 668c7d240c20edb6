"""English sentences of the service as a whole: addresses, requests, the database."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "edge.body_too_large": "The request is larger than the limit of {limit_bytes:mib~3}.",
    "edge.body_too_slow": "The request stopped or came too slowly for {patience_s:s}; send it again.",
    "edge.fields": "The request is not valid; check: {fields:and}.",
    "edge.database_busy": "The database is busy or cannot be reached; try again in a moment.",
    "edge.unexpected": "Something went wrong in the service; the error was recorded.",
    "edge.method": "This address accepts only {allowed}.",
    "edge.no_json": "The body cannot be read as JSON.",
    "edge.no_such_address": "There is nothing at this address.",
    "edge.no_such_page": "This is not a page of this list; read the list from its beginning.",
    "edge.host": "This service has another name; open it by its own address.",
    "edge.query_nul": "The query must not hold a NUL; remove %00.",
    "edge.metrics": "Metrics are for the operator of the service: set TELEMOTION_METRICS_TOKEN and send it as"
    " `Authorization: Bearer`.",
    "edge.no_accuracy": "This installation has no accuracy report; make one with `telemotion validate`.",
    "edge.no_such_file": "There is no such file.",
}
