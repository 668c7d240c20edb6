"""Roetenberg's detector of magnetic disturbance (method page 2.4 and 2.5), compiled."""

from estimators.kernels import Record, step


@step(inlined=True)
def smooth(x: Record, c: Record, norm: float, dip: float) -> float:
    """Take norm and dip of a field; return the variance by which the disturbance may have changed (page 2.4)."""
    if x.is_detecting == 0:
        x.smooth_norm = x.last_norm = norm
        x.smooth_dip = x.last_dip = dip
        x.is_detecting = 1
    norm_step, dip_step, band = (
        c.smoothing * (norm - x.smooth_norm),
        c.smoothing * (dip - x.smooth_dip),
        c.dead_band,
    )
    x.smooth_norm += norm_step
    x.smooth_dip += dip_step
    if c.raw_detector:
        norm_step, dip_step, band = norm - x.last_norm, dip - x.last_dip, 0.0
    x.last_norm, x.last_dip = norm, dip
    change = c.norm_gain * max(abs(norm_step) - band, 0.0) + c.dip_gain * max(abs(dip_step) - band, 0.0)
    return float(c.floor_variance + change * change)


@step(inlined=True)
def detect(x: Record, c: Record, norm: float, dip: float) -> float:
    """Return what `smooth` does, and count samples of nominal and of foreign field.

    Takes the norm of the field over that of the reference, and its dip. After enough samples of nominal field the
    disturbance is held to nothing (page 2.5).
    """
    variance = smooth(x, c, norm, dip)
    norm_off, dip_off = abs(x.smooth_norm - 1.0), abs(x.smooth_dip - x.reference_dip)
    is_nominal = norm_off < c.nominal_norm and dip_off < c.nominal_dip
    x.nominal = x.nominal + 1 if is_nominal else 0
    x.mismatch = x.mismatch + 1 if norm_off > c.guard_norm or dip_off > c.guard_dip else 0
    x.is_pinned = 1 if c.compensate == 0 or x.nominal >= c.nominal_ticks else 0
    return variance
