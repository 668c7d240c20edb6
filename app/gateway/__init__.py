"""The reference gateway: a recording as packets, sent so that nothing is lost or counted twice."""

from app.gateway.client import Delivery, GatewayClient, GatewayReport, Milestone
from app.gateway.encoding import FULL_SCALES, DeviceStream, stream_of
from app.gateway.service import ServiceClient

__all__ = [
    "FULL_SCALES",
    "Delivery",
    "DeviceStream",
    "GatewayClient",
    "GatewayReport",
    "Milestone",
    "ServiceClient",
    "stream_of",
]
