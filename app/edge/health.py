"""Alive: whether the process answers. Whether anything can be stored is another question (`app.edge.readiness`)."""

from importlib.metadata import PackageNotFoundError, version

from fastapi import APIRouter

router = APIRouter(prefix="/api", tags=["service"])


def service_version() -> str:
    """Return the installed version, or `unknown` when run from a tree that was not installed."""
    try:
        return version("telemotion")
    except PackageNotFoundError:
        return "unknown"


@router.get("/health")
async def health() -> dict[str, str]:
    """Return that the service answers; no sign-in needed. `/api/ready` says whether it can store."""
    return {"status": "ok", "version": service_version()}


__all__ = ["router", "service_version"]
