"""Faults of the link, on packet numbers: which packets arrive, how often, in which order, and when.

Pure functions of counts and a seed; whoever sends real packets (a simulated gateway) follows the plan.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError

Float = NDArray[np.float64]
Numbers = NDArray[np.int64]


@dataclass(frozen=True)
class LinkFaults:
    """How bad a link is.

    Attributes
    ----------
    loss_fraction, mean_burst_packets : float
        Share of packets lost between sensors and gateway, in bursts of that mean length.
    duplicate_fraction : float
        Share of packets sent twice.
    reorder_fraction : float
        Share of packets held back so that up to `reorder_depth` later ones overtake them.
    jitter_sd_s : float
        Standard deviation of the delay (half normal).
    break_count, break_s, breaks_from_s : int, float, float
        Broken connections, evenly spread with random shifts, how long each lasts, and before when there is none.
    clock_skew_ppm, clock_offset_s : float
        The device clock against the true one.
    """

    loss_fraction: float = 0.0
    mean_burst_packets: float = 4.0
    duplicate_fraction: float = 0.0
    reorder_fraction: float = 0.0
    reorder_depth: int = 3
    jitter_sd_s: float = 0.0
    break_count: int = 0
    break_s: float = 3.0
    breaks_from_s: float = 0.0
    clock_skew_ppm: float = 0.0
    clock_offset_s: float = 0.0

    def __post_init__(self) -> None:
        shares = (self.loss_fraction, self.duplicate_fraction, self.reorder_fraction)
        if not all(0.0 <= share < 1.0 for share in shares):
            raise SetupError(f"{self}: fractions go from 0 to below 1")
        if self.mean_burst_packets < 1.0 or self.reorder_depth < 1 or self.break_count < 0:
            raise SetupError(f"{self}: bursts and depth are at least 1, breaks not negative")


@dataclass(frozen=True)
class DeliveryPlan:
    """What a gateway does with P packets.

    Attributes
    ----------
    packet : ndarray of int, shape (D,)
        Number of the packet of each delivery, in sending order; lost ones never occur, doubled ones twice.
    send_s : ndarray, shape (D,)
        When it leaves on a working link; never decreases. During a break it waits for the end.
    is_lost : ndarray of bool, shape (P,)
    device_time_s : ndarray, shape (P,)
        Stamp of the device's own clock for the first tick of each packet.
    breaks_s : ndarray, shape (B, 2)
        Half-open intervals without a connection.
    """

    packet: Numbers
    send_s: Float
    is_lost: NDArray[np.bool_]
    device_time_s: Float
    breaks_s: Float


def burst_loss(count: int, fraction: float, mean_burst: float, seed: int) -> NDArray[np.bool_]:
    """Return which of `count` packets are lost, shape (count,).

    Notes
    -----
    Gilbert (1960): a two-state chain. A burst ends with probability 1/mean_burst after each packet and the
    way into it is chosen so that the share of lost packets is `fraction` in the long run.
    """
    if fraction <= 0.0:
        return np.zeros(count, dtype=np.bool_)
    end = 1.0 / mean_burst
    begin = min(1.0, end * fraction / (1.0 - fraction))
    rng = np.random.default_rng([seed, 10])
    lost = np.zeros(count, dtype=np.bool_)
    at, is_bad = 0, bool(rng.random() < fraction)
    while at < count:
        run = int(rng.geometric(end if is_bad else begin))
        lost[at : at + run] = is_bad
        at, is_bad = at + run, not is_bad
    return lost


def duplicated(packets: Numbers, fraction: float, seed: int) -> Numbers:
    """Repeat a share of the packets right after themselves."""
    twice = np.random.default_rng([seed, 11]).random(packets.size) < fraction
    return np.repeat(packets, 1 + twice.astype(np.int64))


def reordered(packets: Numbers, fraction: float, depth: int, seed: int) -> Numbers:
    """Hold a share of the packets back behind one to `depth` later ones."""
    rng = np.random.default_rng([seed, 12])
    held = rng.random(packets.size) < fraction
    rank = np.arange(packets.size) + np.where(held, rng.integers(1, depth + 1, packets.size) + 0.5, 0.0)
    return packets[np.argsort(rank, kind="stable")]


def jitter(count: int, sd_s: float, seed: int) -> Float:
    """Return delays that are never negative, half normal, shape (count,)."""
    return np.abs(np.random.default_rng([seed, 13]).normal(size=count)) * sd_s


def device_clock(time_s: Float, skew_ppm: float, offset_s: float) -> Float:
    """Return what a clock shows at true times when it runs fast by `skew_ppm` and started at `offset_s`."""
    return np.asarray(time_s * (1.0 + 1e-6 * skew_ppm) + offset_s)


def link_breaks(duration_s: float, count: int, length_s: float, seed: int, from_s: float = 0.0) -> Float:
    """Return `count` half-open intervals without a connection after `from_s`, in order and apart, shape (count, 2)."""
    if count == 0:
        return np.zeros((0, 2))
    room = (duration_s - from_s) / count
    if length_s >= 0.8 * room:
        raise SetupError(f"{count} breaks of {length_s} s do not fit into {duration_s - from_s} s")
    slack = room - length_s
    start = (
        from_s + room * np.arange(count) + slack * np.random.default_rng([seed, 14]).uniform(0.2, 0.8, count)
    )
    return np.stack((start, start + length_s), axis=1)


def plan_delivery(packet_count: int, packet_s: float, faults: LinkFaults, seed: int) -> DeliveryPlan:
    """Put all faults of a link together.

    Parameters
    ----------
    packet_s : float
        Time covered by one packet; packet n is complete at `(n + 1) * packet_s`.
    """
    complete_s = np.arange(1, packet_count + 1, dtype=np.float64) * packet_s
    lost = burst_loss(packet_count, faults.loss_fraction, faults.mean_burst_packets, seed)
    packets = duplicated(np.flatnonzero(~lost).astype(np.int64), faults.duplicate_fraction, seed)
    packets = reordered(packets, faults.reorder_fraction, faults.reorder_depth, seed)
    send = complete_s[packets] + jitter(packets.size, faults.jitter_sd_s, seed)
    breaks = link_breaks(
        packet_count * packet_s, faults.break_count, faults.break_s, seed, faults.breaks_from_s
    )
    for start, end in breaks:
        send = np.where((send >= start) & (send < end), end, send)
    return DeliveryPlan(
        packet=packets,
        # A link keeps order: what waits holds up what follows.
        send_s=np.maximum.accumulate(send) if send.size else send,
        is_lost=lost,
        device_time_s=device_clock(complete_s - packet_s, faults.clock_skew_ppm, faults.clock_offset_s),
        breaks_s=breaks,
    )
