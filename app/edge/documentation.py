"""The API's description: OpenAPI as JSON and a page without scripts, for people who have signed in or in a
demonstration.
"""

from html import escape
from typing import Any

from fastapi import APIRouter, Depends
from fastapi.responses import HTMLResponse
from starlette.requests import Request

from app.accounts.dependencies import current_subject
from app.edge.description import describe
from app.services import services_of

_STYLE = (
    "body{font:16px/1.5 system-ui;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#1b1f24}"
    "code{background:#eef1f4;padding:.1em .3em;border-radius:4px}dt{margin-top:1rem}dd{margin-left:1.5rem}"
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
        OpenAPI 3.1.
    """
    groups: dict[str, list[str]] = {}
    for path, operations in description.get("paths", {}).items():
        for method, operation in operations.items():
            tag = (operation.get("tags") or ["service"])[0]
            groups.setdefault(tag, []).append(_operation(method, path, operation))
    body = "".join(f"<h2>{escape(tag)}</h2><dl>{''.join(rows)}</dl>" for tag, rows in sorted(groups.items()))
    title = escape(description["info"]["title"])
    return (
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{title}: interface</title>"
        f"<style>{_STYLE}</style>"
        f"<h1>{title}: interface</h1><p>Machine-readable: <a href=openapi.json>openapi.json</a>. "
        "Browsers sign in with a cookie and send <code>X-CSRF-Token</code> with every change; gateways send "
        f"<code>Authorization: Bearer</code> with a device token.</p>{body}</html>"
    )


def _operation(method: str, path: str, operation: dict[str, Any]) -> str:
    parameters = "".join(
        f"<li><code>{escape(p['name'])}</code> ({escape(p['in'])})</li>"
        for p in operation.get("parameters", [])
    )
    takes = _schema_name(operation.get("requestBody", {}).get("content", {}))
    gives = _schema_name(operation.get("responses", {}).get("200", {}).get("content", {}))
    text = escape(operation.get("description", "")).replace("\n\n", "</p><p>")
    return (
        f"<dt><code>{escape(method.upper())} {escape(path)}</code></dt><dd><p>{text}</p>"
        f"<p>{_named('takes', takes)} {_named('gives', gives)}</p>"
        f"<ul>{parameters}</ul></dd>"
    )


def _named(verb: str, name: str) -> str:
    return f"{verb} <code>{escape(name)}</code>" if name else ""


def _schema_name(content: dict[str, Any]) -> str:
    for kind, media in content.items():
        schema = media.get("schema", {})
        reference = schema.get("$ref") or schema.get("items", {}).get("$ref", "")
        return reference.rsplit("/", 1)[-1] or kind
    return ""
