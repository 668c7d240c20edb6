"""Faults of devices (on recordings) and of links (on packet numbers), under one name."""

from estimators.simulation._delivery import (
    DeliveryPlan,
    LinkFaults,
    burst_loss,
    device_clock,
    duplicated,
    jitter,
    link_breaks,
    plan_delivery,
    reordered,
)
from estimators.simulation._faults import (
    drop_samples,
    jitter_stamps,
    kill_sensor,
    saturate,
    skew_stamps,
    turn_in_strap,
)

__all__ = [
    "DeliveryPlan",
    "LinkFaults",
    "burst_loss",
    "device_clock",
    "drop_samples",
    "duplicated",
    "jitter",
    "jitter_stamps",
    "kill_sensor",
    "link_breaks",
    "plan_delivery",
    "reordered",
    "saturate",
    "skew_stamps",
    "turn_in_strap",
]
