"""Pieces of the trunk: shirt, trousers around the hips, head and hair."""

from app.viewer.figure.proportions import hip_half_width_m, hip_height_m, neck_height_m
from app.viewer.figure.surface import (
    Mesh,
    Shape,
    cut,
    ellipsoid,
    hollowed,
    lofted,
    polygonise,
    smooth_union,
    tapered,
)
from estimators.body import BodyDimensions


def torso(body: BodyDimensions, wide: float) -> Mesh:
    """Shirt from the hem over waist and chest to the neckline and the tops of the shoulders."""
    up, half_shoulder = body.trunk_m / 0.50, body.shoulder_width_m / 2
    heights = [-0.105, -0.04, 0.03, 0.10, 0.18, 0.27, 0.36, 0.43, 0.48, 0.53]
    depths = [0.130, 0.126, 0.115, 0.104, 0.100, 0.106, 0.112, 0.104, 0.084, 0.055]
    widths = [0.178, 0.176, 0.168, 0.154, 0.145, 0.149, 0.157, 0.156, 0.130, 0.075]
    middle = [0.000, 0.000, 0.001, 0.005, 0.006, 0.004, 0.001, -0.006, -0.012, -0.016]
    trunk = lofted(
        [h * up for h in heights],
        [d * wide for d in depths],
        [w * wide for w in widths],
        [m * wide for m in middle],
        roundness=2.3,
    )
    top = body.trunk_m
    shapes: list[Shape] = [trunk]
    for side in (1, -1):
        joint = (-0.006 * wide, side * (half_shoulder - 0.010), top + 0.002 * wide)
        neck = (-0.020 * wide, side * 0.028 * wide, top + 0.046 * wide)
        shapes.append(tapered(neck, joint, 0.044 * wide, 0.046 * wide))
        chest = (0.050 * wide, side * 0.070 * wide, 0.400 * up)
        shapes.append(ellipsoid(chest, (0.060 * wide, 0.078 * wide, 0.085 * wide)))
        blade = (-0.060 * wide, side * 0.078 * wide, 0.405 * up)
        shapes.append(ellipsoid(blade, (0.048 * wide, 0.075 * wide, 0.095 * wide)))
    shape = cut(smooth_union(shapes, 0.060 * wide), (0, 0, top + 0.066 * wide), (0.42, 0, 1), 0.012 * wide)
    reach = half_shoulder + 0.08 * wide
    return polygonise(
        shape, (-0.18 * wide, -reach, -0.13 * up), (0.18 * wide, reach, top + 0.12 * wide), 0.0150 * wide
    )


def pelvis(body: BodyDimensions, wide: float) -> Mesh:
    """Trousers around the hips, hidden above the hem of the shirt."""
    heights = [-0.13, -0.08, -0.03, 0.03, 0.08]
    depths, widths = [0.086, 0.098, 0.096, 0.082, 0.060], [0.144, 0.156, 0.150, 0.125, 0.090]
    girdle = lofted(
        [h * wide for h in heights], [d * wide for d in depths], [w * wide for w in widths], roundness=2.4
    )
    half = hip_half_width_m(body)
    legs = [
        tapered((0, s * half, -0.02 * wide), (0, s * half, -0.14 * wide), 0.083 * wide, 0.080 * wide)
        for s in (1, -1)
    ]
    shape = smooth_union([girdle, *legs], 0.03 * wide)
    return polygonise(
        shape,
        (-0.15 * wide, -0.21 * wide, -0.24 * wide),
        (0.15 * wide, 0.21 * wide, 0.13 * wide),
        0.0150 * wide,
    )


def _head_shape(body: BodyDimensions, wide: float) -> tuple[Shape, float, float]:
    """Return the bare head without the neck, and the heights of chin and crown above the head's origin.

    A face of nobody: brow, nose and chin catch the light and say where it looks, no more.
    """
    crown = max(body.stature_m - hip_height_m(body) - neck_height_m(body), 0.2 * wide)
    chin = crown - 0.222 * wide

    def at(x: float, y: float, z: float) -> tuple[float, float, float]:
        return (x * wide, y * wide, chin + z * wide)

    def size(*radii: float) -> tuple[float, ...]:
        return tuple(radius * wide for radius in radii)

    skull = ellipsoid(at(-0.010, 0, 0.124), size(0.096, 0.076, 0.098))
    face = ellipsoid(at(0.022, 0, 0.082), size(0.063, 0.060, 0.084))
    jaw = tapered(at(0.052, 0, 0.026), at(-0.006, 0, 0.052), *size(0.027, 0.052))
    shape = smooth_union([skull, face, jaw], 0.050 * wide)
    for side in (1, -1):
        socket = ellipsoid(at(0.0985, side * 0.030, 0.112), size(0.017, 0.022, 0.013))
        shape = hollowed(shape, socket, 0.020 * wide)
        ear = ellipsoid(at(-0.006, side * 0.0815, 0.098), size(0.018, 0.0095, 0.031))
        shape = smooth_union([shape, ear], 0.010 * wide)
    nose = smooth_union(
        [
            tapered(at(0.080, 0, 0.118), at(0.0975, 0, 0.082), *size(0.0070, 0.0095)),
            ellipsoid(at(0.0925, 0, 0.078), size(0.0120, 0.0130, 0.0080)),
        ],
        0.010 * wide,
    )
    return smooth_union([shape, nose], 0.016 * wide), chin, crown


def head(body: BodyDimensions, wide: float) -> Mesh:
    """Head with nose and ears, so that the way the person faces is plain, and the neck into the shirt."""
    head, chin, crown = _head_shape(body, wide)
    neck = tapered(
        (-0.022 * wide, 0, -0.03 * wide), (-0.014 * wide, 0, chin + 0.055 * wide), 0.060 * wide, 0.049 * wide
    )
    return polygonise(
        smooth_union([head, neck], 0.016 * wide),
        (-0.13 * wide, -0.11 * wide, -0.10 * wide),
        (0.13 * wide, 0.11 * wide, crown + 0.01),
        0.0078 * wide,
    )


def hair(body: BodyDimensions, wide: float) -> Mesh:
    """Short hair: the back and top of the head, a little larger."""
    _, chin, crown = _head_shape(body, wide)
    skull = ellipsoid((-0.013 * wide, 0, crown - 0.096 * wide), (0.1035 * wide, 0.0855 * wide, 0.1065 * wide))
    nape = ellipsoid((-0.036 * wide, 0, chin + 0.088 * wide), (0.070 * wide, 0.072 * wide, 0.066 * wide))
    shape = smooth_union([skull, nape], 0.04 * wide)
    # The hairline runs from the forehead back over the ears and then down to the nape.
    shape = cut(shape, (0.066 * wide, 0, crown - 0.050 * wide), (1.0, 0, -0.62), 0.008 * wide)
    shape = cut(shape, (-0.004 * wide, 0, chin + 0.126 * wide), (0.62, 0, -0.78), 0.008 * wide)
    return polygonise(
        shape,
        (-0.14 * wide, -0.11 * wide, chin - 0.01),
        (0.12 * wide, 0.11 * wide, crown + 0.02),
        0.0085 * wide,
    )
