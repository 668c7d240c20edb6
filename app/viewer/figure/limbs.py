"""Pieces of the left arm and leg; the right ones are their mirror images."""

from app.viewer.figure.proportions import leg_lengths_m
from app.viewer.figure.surface import (
    Mesh,
    Shape,
    cut,
    ellipsoid,
    inflated,
    lofted,
    polygonise,
    smooth_union,
    tapered,
)
from estimators.body import BodyDimensions


def upper_arm_shape(body: BodyDimensions, wide: float) -> Shape:
    """Bare upper arm with deltoid and biceps, rounded at both joints."""
    long = body.upper_arm_m
    stations = [-1.0, -0.90, -0.70, -0.50, -0.30, -0.10, 0.0]
    depths, widths = (
        [0.037, 0.039, 0.045, 0.049, 0.047, 0.045, 0.040],
        [0.040, 0.040, 0.041, 0.043, 0.046, 0.047, 0.040],
    )
    middle = [0.0, 0.001, 0.004, 0.005, 0.003, 0.0, 0.0]
    arm = lofted(
        [s * long for s in stations],
        [d * wide for d in depths],
        [w * wide for w in widths],
        [m * wide for m in middle],
    )
    deltoid = ellipsoid((0, 0.006 * wide, -0.045 * wide), (0.052 * wide, 0.050 * wide, 0.082 * wide))
    elbow = ellipsoid((0, 0, -long), (0.0385 * wide, 0.0405 * wide, 0.0390 * wide))
    shoulder = ellipsoid((0, 0, -0.004 * wide), (0.0480 * wide, 0.0470 * wide, 0.0460 * wide))
    return smooth_union([arm, deltoid, elbow, shoulder], 0.018 * wide)


def upper_arm(body: BodyDimensions, wide: float) -> Mesh:
    """Bare upper arm."""
    side, long = 0.08 * wide, body.upper_arm_m
    return polygonise(
        upper_arm_shape(body, wide),
        (-side, -side, -long - 0.06 * wide),
        (side, side, 0.08 * wide),
        0.0125 * wide,
    )


def sleeve(body: BodyDimensions, wide: float) -> Mesh:
    """Short sleeve: the arm a little larger, open toward the elbow."""
    side, length = 0.10 * wide, 0.56 * body.upper_arm_m
    flare = lofted(
        [-length - 0.01, -0.02 * wide, 0.01 * wide],
        [0.060 * wide, 0.050 * wide, 0.045 * wide],
        [0.057 * wide, 0.052 * wide, 0.047 * wide],
    )
    shape = smooth_union([inflated(upper_arm_shape(body, wide), 0.006 * wide), flare], 0.02 * wide)
    shape = cut(shape, (0, 0, -length), (0, 0.12, -1), 0.006 * wide)
    return polygonise(shape, (-side, -side, -length - 0.05), (side, side, 0.09 * wide), 0.0125 * wide)


def arm_band(body: BodyDimensions, wide: float) -> Mesh:
    """Ring around the upper arm below the sleeve: marks the affected side by shape."""
    side, long = 0.09 * wide, body.upper_arm_m
    ring = inflated(upper_arm_shape(body, wide), 0.0085 * wide)
    ring = cut(ring, (0, 0, -0.655 * long), (0, 0, 1), 0.008 * wide)
    ring = cut(ring, (0, 0, -0.775 * long), (0, 0, -1), 0.008 * wide)
    return polygonise(ring, (-side, -side, -0.86 * long), (side, side, -0.56 * long), 0.0100 * wide)


def forearm_shape(body: BodyDimensions, wide: float) -> Shape:
    """Round below the elbow, flat at the wrist, so that turning it can be seen."""
    long = body.forearm_m
    stations = [-1.0, -0.85, -0.60, -0.35, -0.15, 0.0]
    depths, widths = (
        [0.0205, 0.0225, 0.030, 0.038, 0.0405, 0.0385],
        [0.0290, 0.0300, 0.0365, 0.0445, 0.0455, 0.0405],
    )
    arm = lofted([s * long for s in stations], [d * wide for d in depths], [w * wide for w in widths])
    elbow = ellipsoid((0, 0, 0), (0.0395 * wide, 0.0410 * wide, 0.0400 * wide))
    wrist = ellipsoid((0, 0, -long), (0.0210 * wide, 0.0290 * wide, 0.0240 * wide))
    return smooth_union([arm, elbow, wrist], 0.012 * wide)


def forearm(body: BodyDimensions, wide: float) -> Mesh:
    """Bare forearm."""
    long, side = body.forearm_m, 0.08 * wide
    shape = forearm_shape(body, wide)
    return polygonise(shape, (-side, -side, -long - 0.05 * wide), (side, side, 0.06 * wide), 0.0110 * wide)


def hand_shape(body: BodyDimensions) -> Shape:
    """Left hand, palm forward (+x), thumb outward (+y), fingers slightly curled."""
    long = body.hand_m / 0.18  # everything below is for a hand of 18 cm
    wrist = ellipsoid((0, 0, 0), (0.0205, 0.0285, 0.0230))
    palm = lofted(
        [-0.100, -0.090, -0.050, -0.015, 0.0],
        [0.0105, 0.0125, 0.0150, 0.0170, 0.0170],
        [0.0395, 0.0415, 0.0400, 0.0320, 0.0260],
        roundness=2.5,
    )
    shapes: list[Shape] = [wrist, palm]
    # Knuckle y, length, radius of index, middle, ring and little finger.
    for knuckle_y, knuckle_z, length, radius in (
        (0.0295, -0.092, 0.068, 0.0096),
        (0.0100, -0.096, 0.076, 0.0098),
        (-0.0095, -0.093, 0.070, 0.0093),
        (-0.0285, -0.086, 0.055, 0.0084),
    ):
        spread = knuckle_y * 0.10
        bend = (0.006, knuckle_y + spread, knuckle_z - 0.50 * length)
        tip = (0.022, knuckle_y + 1.4 * spread, knuckle_z - 0.94 * length)
        shapes.append(
            smooth_union(
                [
                    tapered((0.0, knuckle_y, knuckle_z), bend, radius * 1.08, radius),
                    tapered(bend, tip, radius, radius * 0.82),
                ],
                0.004,
            )
        )
    thumb_root, thumb_bend, thumb_tip = (0.010, 0.024, -0.024), (0.022, 0.056, -0.058), (0.024, 0.064, -0.092)
    thumb = smooth_union(
        [tapered(thumb_root, thumb_bend, 0.0180, 0.0125), tapered(thumb_bend, thumb_tip, 0.0122, 0.0095)],
        0.008,
    )
    shape = smooth_union([smooth_union(shapes, 0.007), thumb], 0.014)
    return lambda points: shape(points / long) * long


def hand(body: BodyDimensions, _wide: float) -> Mesh:
    """Bare left hand."""
    long = body.hand_m / 0.18
    return polygonise(
        hand_shape(body),
        (-0.05 * long, -0.07 * long, -0.20 * long),
        (0.07 * long, 0.10 * long, 0.05 * long),
        0.0056 * long,
    )


def thigh_shape(body: BodyDimensions, wide: float) -> Shape:
    """Trouser leg down to the knee."""
    long = leg_lengths_m(body)[0]
    stations = [-1.0, -0.85, -0.60, -0.30, -0.10, 0.0]
    depths, widths = [0.056, 0.060, 0.073, 0.085, 0.087, 0.085], [0.054, 0.058, 0.069, 0.078, 0.080, 0.078]
    leg = lofted(
        [s * long for s in stations],
        [d * wide for d in depths],
        [w * wide for w in widths],
        [0, 0.003, 0.006, 0.004, 0, 0],
    )
    ends = [
        ellipsoid((0, 0, 0), (0.085 * wide, 0.078 * wide, 0.080 * wide)),
        ellipsoid((0, 0, -long), (0.057 * wide, 0.055 * wide, 0.058 * wide)),
    ]
    return smooth_union([leg, *ends], 0.02 * wide)


def thigh(body: BodyDimensions, wide: float) -> Mesh:
    """Trouser leg down to the knee."""
    long, side = leg_lengths_m(body)[0], 0.13 * wide
    low, high = (-side, -side, -long - 0.09 * wide), (side, side, 0.11 * wide)
    return polygonise(thigh_shape(body, wide), low, high, 0.0180 * wide)


def shank_shape(body: BodyDimensions, wide: float) -> Shape:
    """Leg from the knee to the ankle."""
    long = leg_lengths_m(body)[1]
    stations = [-1.0, -0.85, -0.55, -0.30, -0.12, 0.0]
    depths, widths = [0.048, 0.048, 0.054, 0.060, 0.058, 0.056], [0.046, 0.046, 0.050, 0.056, 0.055, 0.054]
    middle = [-0.004, -0.005, -0.010, -0.010, -0.003, 0.0]
    return lofted(
        [s * long for s in stations],
        [d * wide for d in depths],
        [w * wide for w in widths],
        [m * wide for m in middle],
    )


def shank(body: BodyDimensions, wide: float) -> Mesh:
    """Trouser leg, open above the shoe."""
    long, side = leg_lengths_m(body)[1], 0.10 * wide
    knee = ellipsoid((0, 0, 0), (0.0570 * wide, 0.0550 * wide, 0.0580 * wide))
    shape = smooth_union(
        [cut(shank_shape(body, wide), (0, 0, -0.965 * long), (0, 0, -1), 0.008 * wide), knee], 0.02 * wide
    )
    return polygonise(shape, (-side, -side, -long - 0.03 * wide), (side, side, 0.09 * wide), 0.0165 * wide)


def ankle(body: BodyDimensions, wide: float) -> Mesh:
    """Bare ankle between trousers and shoe."""
    long, side = leg_lengths_m(body)[1], 0.07 * wide
    shape = tapered(
        (-0.006 * wide, 0, -0.80 * long), (-0.006 * wide, 0, -1.03 * long), 0.038 * wide, 0.034 * wide
    )
    return polygonise(shape, (-side, -side, -1.16 * long), (side, side, -0.68 * long), 0.0150 * wide)


def shoe_shape(body: BodyDimensions, wide: float) -> Shape:
    """Left shoe with a flat sole; the origin is the ankle."""
    low = -leg_lengths_m(body)[2]
    heel = ellipsoid((-0.030 * wide, 0, low + 0.038 * wide), (0.048 * wide, 0.037 * wide, 0.052 * wide))
    middle = tapered(
        (-0.02 * wide, 0, low + 0.046 * wide),
        (0.075 * wide, -0.002 * wide, low + 0.030 * wide),
        0.041 * wide,
        0.034 * wide,
    )
    toes = ellipsoid(
        (0.115 * wide, 0.004 * wide, low + 0.020 * wide), (0.078 * wide, 0.048 * wide, 0.036 * wide)
    )
    collar = tapered(
        (-0.012 * wide, 0, low + 0.06 * wide),
        (-0.008 * wide, 0, low + 0.088 * wide),
        0.041 * wide,
        0.037 * wide,
    )
    shape = cut(
        smooth_union([heel, middle, toes, collar], 0.03 * wide), (0, 0, low), (0, 0, -1), 0.010 * wide
    )
    return cut(shape, (-0.01 * wide, 0, low + 0.098 * wide), (0.25, 0, 1), 0.008 * wide)


def shoe(body: BodyDimensions, wide: float) -> Mesh:
    """Left shoe with a flat sole; the origin is the ankle."""
    low = -leg_lengths_m(body)[2]
    return polygonise(
        shoe_shape(body, wide),
        (-0.13 * wide, -0.10 * wide, low - 0.02),
        (0.24 * wide, 0.10 * wide, low + 0.16 * wide),
        0.0125 * wide,
    )
