"""The API's description: OpenAPI as JSON and a page without scripts, for people who have signed in or in a
demonstration.
"""

import json
import re
from html import escape
from typing import Any

from fastapi import APIRouter, Depends
from fastapi.responses import HTMLResponse
from starlette.requests import Request

from app.accounts.dependencies import current_subject
from app.edge.description import describe
from app.edge.examples import example
from app.services import services_of

_STYLE = (
    "body{font:16px/1.5 system-ui;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#1b1f24}"
    "code,pre{background:#eef1f4;padding:.1em .3em;border-radius:4px}pre{padding:.6em;overflow:auto}"
    "dt{margin-top:1rem}dd{margin-left:1.5rem}"
)


def _insider(request: Request) -> None:
    """Let everybody in a demonstration read; elsewhere only who is signed in."""
    if not services_of(request).settings.demo:
        current_subject(request)


router = APIRouter(prefix="/api", include_in_schema=False, dependencies=[Depends(_insider)])


@router.get("/openapi.json")
def openapi(request: Request) -> dict[str, Any]:
    """Return the OpenAPI description."""
    return describe(request.app)


@router.get("/docs", response_class=HTMLResponse)
def docs(request: Request) -> HTMLResponse:
    """Return the description as one readable page."""
    return HTMLResponse(render(describe(request.app)))


def render(description: dict[str, Any]) -> str:
    """Return an OpenAPI description as an HTML page without scripts.

    Parameters
    ----------
    description : dict
        OpenAPI 3.1, with `components`.
    """
    components = description.get("components", {})
    groups: dict[str, list[str]] = {}
    for path, operations in description.get("paths", {}).items():
        for method, operation in operations.items():
            tag = (operation.get("tags") or ["service"])[0]
            groups.setdefault(tag, []).append(_operation(method, path, operation, components))
    body = "".join(f"<h2>{escape(tag)}</h2><dl>{''.join(rows)}</dl>" for tag, rows in sorted(groups.items()))
    title = escape(description["info"]["title"])
    return (
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{title}: interface</title>"
        f"<style>{_STYLE}</style>"
        f"<h1>{title}: interface</h1><p>Machine-readable: <a href=openapi.json>openapi.json</a>. "
        "Browsers sign in with a cookie and send <code>X-CSRF-Token</code> with every change; gateways send "
        "<code>Authorization: Bearer</code> with a device token. Every refusal has the same shape: "
        f"<code>code</code> for programs, <code>message</code> for people, <code>details</code>.</p>{body}</html>"
    )


def _operation(method: str, path: str, operation: dict[str, Any], components: dict[str, Any]) -> str:
    parameters = "".join(
        f"<li><code>{escape(p['name'])}</code> ({escape(p['in'])})</li>"
        for p in operation.get("parameters", [])
    )
    content = operation.get("requestBody", {}).get("content", {})
    responses = operation.get("responses", {})
    gives = "".join(
        f"<li><code>{status}</code> {_marked(_answer(response, components))}</li>"
        for status, response in sorted(responses.items())
    )
    return (
        f"<dt><code>{escape(method.upper())} {escape(path)}</code></dt><dd>{_prose(operation.get('description', ''))}"
        f"<ul>{parameters}</ul>{_body(content, components)}<p>Answers</p><ul>{gives}</ul></dd>"
    )


def _prose(text: str) -> str:
    """Return paragraphs in which what stands between back-ticks is code."""
    return f"<p>{_marked(text)}</p>".replace("\n\n", "</p><p>")


def _marked(text: str) -> str:
    return re.sub(r"`+([^`]+)`+", r"<code>\1</code>", escape(text))


def _body(content: dict[str, Any], components: dict[str, Any]) -> str:
    for kind, media in content.items():
        shown = json.dumps(example(media.get("schema", {}), components.get("schemas", {})), indent=1)
        return f"<p>Takes <code>{escape(kind)}</code>, for example</p><pre>{escape(shown)}</pre>"
    return ""


def _answer(response: dict[str, Any], components: dict[str, Any]) -> str:
    if "$ref" in response:
        response = components["responses"][response["$ref"].rsplit("/", 1)[-1]]
        return str(response["description"])
    return _schema_name(response.get("content", {})) or str(response.get("description", ""))


def _schema_name(content: dict[str, Any]) -> str:
    for kind, media in content.items():
        schema = media.get("schema", {})
        reference = schema.get("$ref") or schema.get("items", {}).get("$ref", "")
        return reference.rsplit("/", 1)[-1] or kind
    return ""
