"""Smooth closed surfaces from distance fields: the clay that the figure is made of.

A shape is a function from points (N, 3) to signed distances (N,), negative inside. Shapes are joined with
`smooth_union`, so that a thumb grows out of a palm without a seam, and turned into triangles by `polygonise`
(naive surface nets, Gibson 1998, then Newton steps onto the zero level, which makes the shading smooth
even on a coarse grid).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.recording import Float

Shape = Callable[[Float], Float]

# Corners of a grid cell, and the twelve pairs of corners that are its edges.
_CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])
_EDGES = np.array(
    [(a, b) for a in range(8) for b in range(a + 1, 8) if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1]
)


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh, faces counter-clockwise seen from outside.

    Attributes
    ----------
    vertices_m : ndarray of float32, shape (V, 3)
    faces : ndarray of uint32, shape (F, 3)
    """

    vertices_m: NDArray[np.float32]
    faces: NDArray[np.uint32]

    @property
    def volume_m3(self) -> float:
        """Enclosed volume; negative if the faces were inside out."""
        a, b, c = (self.vertices_m[self.faces[:, i]].astype(np.float64) for i in range(3))
        return float(np.einsum("ni,ni->n", a, np.cross(b, c)).sum() / 6.0)

    def mirrored(self) -> "Mesh":
        """Return the same shape for the other side of the body: y negated, faces turned back outward."""
        return Mesh(self.vertices_m * np.array([1, -1, 1], np.float32), self.faces[:, ::-1].copy())


def tapered(
    start_m: Sequence[float], end_m: Sequence[float], start_radius_m: float, end_radius_m: float
) -> Shape:
    """Return a round-ended limb from one point to another whose radius changes evenly."""
    start, end = np.asarray(start_m, float), np.asarray(end_m, float)
    axis = end - start
    length_squared = float(axis @ axis)

    def distance(points: Float) -> Float:
        along = np.clip((points - start) @ axis / length_squared, 0.0, 1.0)
        radius = start_radius_m + along * (end_radius_m - start_radius_m)
        gap: Float = np.linalg.norm(points - start - along[:, None] * axis, axis=1) - radius
        return gap

    return distance


def ellipsoid(centre_m: Sequence[float], radii_m: Sequence[float]) -> Shape:
    """Return an axis-aligned ellipsoid."""
    centre, radii = np.asarray(centre_m, float), np.asarray(radii_m, float)

    def distance(points: Float) -> Float:
        scaled = (points - centre) / radii
        level = np.linalg.norm(scaled, axis=1)
        slope = np.linalg.norm(scaled / radii, axis=1)
        # First-order distance; the guard is for the exact centre, where the slope vanishes.
        near: Float = level * (level - 1.0) / np.maximum(slope, 1e-9)
        return np.where(level < 1e-6, -radii.min(), near)

    return distance


def lofted(
    height_m: Sequence[float],
    half_depth_m: Sequence[float],
    half_width_m: Sequence[float],
    centre_x_m: Sequence[float] | None = None,
    roundness: float = 2.0,
) -> Shape:
    """Return a stack of cross-sections along z, each a (super)ellipse, closed by flat ends.

    Parameters
    ----------
    height_m : sequence, increasing
        Heights of the given cross-sections; between them a smooth interpolation.
    half_depth_m, half_width_m : sequence
        Half axes along x and along y.
    centre_x_m : sequence, optional
        How far forward the middle of each section lies.
    roundness : float
        2 is an ellipse, more is squarer.
    """
    from scipy.interpolate import PchipInterpolator

    depth, width = PchipInterpolator(height_m, half_depth_m), PchipInterpolator(height_m, half_width_m)
    centre = PchipInterpolator(height_m, centre_x_m if centre_x_m is not None else np.zeros(len(height_m)))
    low, high = float(height_m[0]), float(height_m[-1])

    def distance(points: Float) -> Float:
        z = np.clip(points[:, 2], low, high)
        a, b = depth(z), width(z)
        x, y = np.abs(points[:, 0] - centre(z)), np.abs(points[:, 1])
        level = ((x / a) ** roundness + (y / b) ** roundness) ** (1.0 / roundness)
        # Distance along the ray from the axis: exact on the surface, good enough near it.
        around = np.hypot(x, y) * (1.0 - 1.0 / np.maximum(level, 1e-6))
        around = np.where(level < 1e-6, -np.minimum(a, b), around)
        beyond = np.maximum(low - points[:, 2], points[:, 2] - high)
        ends: Float = np.maximum(around, beyond)
        return ends

    return distance


def smooth_union(shapes: Sequence[Shape], blend_m: float) -> Shape:
    """Join shapes; where two surfaces come nearer than `blend_m` they flow into each other."""

    def distance(points: Float) -> Float:
        joined = shapes[0](points)
        for shape in shapes[1:]:
            joined = _soft_minimum(joined, shape(points), blend_m)
        return joined

    return distance


def cut(shape: Shape, point_m: Sequence[float], outward: Sequence[float], blend_m: float = 0.0) -> Shape:
    """Remove what lies beyond the plane through a point, with an edge rounded by `blend_m`."""
    origin, normal = np.asarray(point_m, float), np.asarray(outward, float) / np.linalg.norm(outward)

    def distance(points: Float) -> Float:
        beyond = (points - origin) @ normal
        if blend_m <= 0.0:
            sharp: Float = np.maximum(shape(points), beyond)
            return sharp
        return -_soft_minimum(-shape(points), -beyond, blend_m)

    return distance


def hollowed(shape: Shape, tool: Shape, blend_m: float) -> Shape:
    """Press a tool into a shape, with an edge rounded by `blend_m`."""
    return lambda points: -_soft_minimum(-shape(points), tool(points), blend_m)


def inflated(shape: Shape, by_m: float) -> Shape:
    """Move the surface outward."""
    return lambda points: shape(points) - by_m


def lowered(shape: Shape, to_z_m: float) -> Shape:
    """Move the surface up to a height."""
    offset = np.array([0.0, 0.0, to_z_m])
    return lambda points: shape(points - offset)


def polygonise(shape: Shape, low_m: Sequence[float], high_m: Sequence[float], cell_m: float) -> Mesh:
    """Return the closed surface of a shape that lies wholly inside a box.

    Parameters
    ----------
    low_m, high_m : sequence of 3
        Corners of the box.
    cell_m : float
        Grid spacing, about the length of the triangles' sides.

    Raises
    ------
    ValueError
        If the shape is empty or reaches the border of the box.
    """
    low = np.asarray(low_m, float) - 2 * cell_m
    counts = np.ceil((np.asarray(high_m, float) + 2 * cell_m - low) / cell_m).astype(int) + 1
    axes = [low[i] + cell_m * np.arange(counts[i]) for i in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    level = shape(grid.reshape(-1, 3)).reshape(grid.shape[:3])
    inside = level < 0.0
    border = [inside[0], inside[-1], inside[:, 0], inside[:, -1], inside[:, :, 0], inside[:, :, -1]]
    if not inside.any() or any(side.any() for side in border):
        raise ValueError("the shape is empty or reaches the border of its box; enlarge the box")

    cells = tuple(n - 1 for n in counts)
    corner_level = np.stack(
        [level[i : i + cells[0], j : j + cells[1], k : k + cells[2]] for i, j, k in _CORNERS], -1
    )
    corner_inside = corner_level < 0.0
    crossed = corner_inside.any(-1) & ~corner_inside.all(-1)
    where = np.argwhere(crossed)
    corner_level = corner_level[crossed]

    first, second = corner_level[:, _EDGES[:, 0]], corner_level[:, _EDGES[:, 1]]
    crosses = (first < 0.0) != (second < 0.0)
    fraction = np.where(crosses, first / np.where(crosses, first - second, 1.0), 0.0)
    ends = _CORNERS[_EDGES].astype(float)
    crossing = ends[:, 0] + fraction[..., None] * (ends[:, 1] - ends[:, 0])
    middle = (crossing * crosses[..., None]).sum(1) / crosses.sum(1)[:, None]
    vertices = low + cell_m * (where + middle)
    vertices = _onto_surface(shape, vertices, cell_m)

    number = np.full(cells, -1, dtype=np.int64)
    number[tuple(where.T)] = np.arange(len(where))
    faces = np.concatenate([_quads(inside, number, axis) for axis in range(3)])
    return Mesh(vertices.astype(np.float32), faces.astype(np.uint32))


def _quads(inside: NDArray[np.bool_], number: NDArray[np.int64], axis: int) -> NDArray[np.int64]:
    """Return the triangles around every grid edge along one axis that crosses the surface."""
    second, third = (axis + 1) % 3, (axis + 2) % 3
    here = np.moveaxis(inside, (axis, second, third), (0, 1, 2))
    cell = np.moveaxis(number, (axis, second, third), (0, 1, 2))
    # Only inner edges have four cells around them; the border is outside by construction.
    start, stop = here[:-1, 1:-1, 1:-1], here[1:, 1:-1, 1:-1]
    edge = np.argwhere(start != stop)
    leaving = start[tuple(edge.T)]
    i, j, k = edge[:, 0], edge[:, 1] + 1, edge[:, 2] + 1
    corners = np.stack([cell[i, j - 1, k - 1], cell[i, j, k - 1], cell[i, j, k], cell[i, j - 1, k]], axis=1)
    corners = np.where(leaving[:, None], corners, corners[:, ::-1])
    return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


def _onto_surface(shape: Shape, points: Float, cell_m: float) -> Float:
    """Move points along the gradient onto the zero level, by less than half a cell in all."""
    start, step = points, 1e-4
    for _ in range(3):
        value = shape(points)
        gradient = np.stack(
            [(shape(points + offset) - shape(points - offset)) / (2 * step) for offset in step * np.eye(3)],
            axis=1,
        )
        correction = value[:, None] * gradient / np.maximum((gradient**2).sum(1), 0.25)[:, None]
        points = start + np.clip(points - correction - start, -0.5 * cell_m, 0.5 * cell_m)
    return points


def _soft_minimum(first: Float, second: Float, blend_m: float) -> Float:
    """Return the polynomial smooth minimum; the plain one where the two differ by more than `blend_m`."""
    mix = np.maximum(blend_m - np.abs(first - second), 0.0) / blend_m
    softened: Float = np.minimum(first, second) - mix * mix * blend_m * 0.25
    return softened
