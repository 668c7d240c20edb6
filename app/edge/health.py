"""Alive: whether the process answers. Whether anything can be stored is another question (`app.edge.readiness`)."""

from fastapi import APIRouter

from app.version import service_version

router = APIRouter(prefix="/api", tags=["service"])


@router.get("/health")
async def health() -> dict[str, str]:
    """Return that the service answers; no sign-in needed. `/api/ready` says whether it can store."""
    return {"status": "ok", "version": service_version()}
