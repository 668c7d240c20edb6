"""The OpenAPI description with every answer that a route may give, errors included.

What a route can refuse follows from what it is made of, so it is derived and not written at each route: a
signed-in subject (401, 403), something named (404) and its state (409), input (422) with a body (413), a budget
(429), and storage that does not answer (503). A route adds what only it refuses by `responses={401: {}}`.
The header of a list in pages is derived in the same way.
"""

from collections.abc import Iterator
from copy import deepcopy
from typing import Any, Final

from fastapi import FastAPI
from fastapi.dependencies.models import Dependant
from fastapi.openapi.utils import get_openapi
from fastapi.routing import iter_route_contexts

from app.accounts.credentials.sign_in import COOKIE
from app.accounts.dependencies import (
    CSRF_HEADER,
    SAFE_METHODS,
    current_account,
    current_sign_in,
    current_subject,
)
from app.edge.error_answers import ErrorOut
from app.pages import wanted_page

_MEANING: Final = {
    401: "Nobody is signed in, or the session, token or ticket has ended.",
    403: "Known, but not allowed: the role or grant does not cover it, or the CSRF token or Origin is wrong.",
    404: "There is no such thing, or nothing that the subject may see.",
    408: "The body stopped, or came too slowly for too long; the connection is closed.",
    409: "The thing is in another state than the request needs, or exists already.",
    413: "The body is larger than the limit.",
    422: "The input cannot be understood or used; the details name the fields.",
    429: "Too many attempts or too much at once; `Retry-After` says when to try again.",
    503: "Storage does not answer, or the service is shutting down; `Retry-After` says when to try again.",
}
_WITH_RETRY: Final = frozenset({429, 503})
_COOKIE_SET: Final = "Set by /api/sign-in; its name begins with `__Host-` over https."
_SECURITY: Final = {
    "browser": {"type": "apiKey", "in": "cookie", "name": COOKIE, "description": _COOKIE_SET},
    "device": {
        "type": "http",
        "scheme": "bearer",
        "bearerFormat": "JWT",
        "description": "Device token, registered on the patient's page.",
    },
}

_CSRF: Final = {
    "name": CSRF_HEADER,
    "in": "header",
    "required": False,
    "schema": {"type": "string"},
    "description": "From /api/me; browsers send it with every change, devices do not.",
}


_LINK: Final = {
    "description": 'The address of the next page, `<...>; rel="next"` (RFC 8288); absent on the last page.',
    "schema": {"type": "string"},
}


_NO_NUL: Final = r"^[^\u0000]*$"


def describe(app: FastAPI) -> dict[str, Any]:
    """Return the description of an application's routes; made once.

    Returns
    -------
    dict
        OpenAPI 3.1.
    """
    if app.openapi_schema is None:
        found = get_openapi(
            title=app.title,
            version=app.version,
            description=app.description,
            routes=app.routes,
            separate_input_output_schemas=app.separate_input_output_schemas,
        )
        app.openapi_schema = with_errors(found, app)
    return app.openapi_schema


def with_errors(description: dict[str, Any], app: FastAPI) -> dict[str, Any]:
    """Add who may call each operation and what it answers when it refuses.

    Parameters
    ----------
    description : dict
        As FastAPI makes it.
    app : FastAPI
        Whose routes it describes.
    """
    description = deepcopy(description)
    components = description.setdefault("components", {})
    components["securitySchemes"] = _SECURITY
    schemas = components.setdefault("schemas", {})
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    schemas[ErrorOut.__name__] = ErrorOut.model_json_schema(ref_template="#/components/schemas/{model}")
    components["responses"] = {f"Error{status}": _response(status) for status in _MEANING}
    for context in iter_route_contexts(app.routes):
        operations = description["paths"].get(context.path, {})
        for method in context.methods or ():
            if method.lower() in operations:
                _complete(operations[method.lower()], method, context.dependant)
    return description


def _without_nul(schema: dict[str, Any]) -> None:
    """Say of a query's texts what `app.edge.middleware` asks of every query."""
    for one in (schema, *schema.get("anyOf", ())):
        if one.get("type") == "string" and not {"enum", "const", "format"} & one.keys():
            one.setdefault("pattern", _NO_NUL)


def _complete(operation: dict[str, Any], method: str, dependant: Dependant) -> None:
    calls = {one.call for one in _all(dependant)}
    signed_in = bool(calls & {current_subject, current_sign_in})
    changes = method not in SAFE_METHODS
    statuses = {503}
    if signed_in:
        statuses |= {401, 403}
        only_browsers = current_subject not in calls or current_account in calls
        operation["security"] = [{"browser": []}] if only_browsers else [{"browser": []}, {"device": []}]
        if changes:
            operation.setdefault("parameters", []).append(deepcopy(_CSRF))
    for parameter in operation.get("parameters", ()):
        if parameter["in"] == "query":
            _without_nul(parameter["schema"])
    names = [parameter["name"] for parameter in operation.get("parameters", ())]
    if signed_in and (operation.get("requestBody") or any(name.endswith("_id") for name in names)):
        # A body may name anything by its identifier, as a path or query does.
        statuses.add(404)
    if changes or any(one.path_params for one in _all(dependant)):
        statuses.add(409)
    if changes:
        statuses.add(429)
    if operation.get("requestBody"):
        statuses |= {408, 413, 422}
    if names:
        statuses.add(422)
    responses = operation["responses"]
    if wanted_page in calls:
        responses["200"]["headers"] = {"Link": deepcopy(_LINK)}
    responses.pop("422", None)
    statuses |= {status for status in _MEANING if str(status) in responses}
    for status in sorted(statuses):
        responses[str(status)] = {"$ref": f"#/components/responses/Error{status}"}


def _all(dependant: Dependant) -> Iterator[Dependant]:
    yield dependant
    for one in dependant.dependencies:
        yield from _all(one)


def _response(status: int) -> dict[str, Any]:
    found: dict[str, Any] = {
        "description": _MEANING[status],
        "content": {"application/json": {"schema": {"$ref": "#/components/schemas/ErrorOut"}}},
    }
    if status in _WITH_RETRY:
        found["headers"] = {"Retry-After": {"description": "Seconds.", "schema": {"type": "integer"}}}
    return found
