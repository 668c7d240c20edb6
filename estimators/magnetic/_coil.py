"""A body-worn source: its coils, and the field that they make.

Frames: `source` is fixed to the source module (origin: the origin of its inertial sensor); positions are those of
the sensor in it. A coil has any place and direction in the source; its field follows its axis by the right hand.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from estimators.errors import SetupError, ShapeError
from estimators.magnetic import _loop_kernel as kernel
from estimators.magnetic._loop_kernel import MU0_TM_PER_A
from estimators.recording import Float

FieldModel = Literal["exact", "dipole"]
_NUMBERS = ("turns", "radius_m", "length_m", "depth_m")


@dataclass(frozen=True)
class Coil:
    """A circular coil.

    Attributes
    ----------
    turns : float
        All of them; may carry a calibrated gain, so need not be whole.
    radius_m : float
        Mean radius of the winding.
    centre_m, axis : tuple of 3 float
        In the source frame; the axis need not be of unit length.
    length_m, depth_m : float
        Of the winding, along the axis and along the radius; zero for a thin loop.
    layers : tuple of 2 int
        Thin loops that stand for the winding, along its length and its depth.
    """

    turns: float = 50.0
    radius_m: float = 0.055
    centre_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    length_m: float = 0.0
    depth_m: float = 0.0
    layers: tuple[int, int] = (1, 1)

    def __post_init__(self) -> None:
        values = (self.turns, self.radius_m, *self.centre_m, *self.axis, self.length_m, self.depth_m)
        if not np.isfinite(values).all() or self.radius_m <= 0.0 or self.turns == 0.0:
            raise SetupError("a coil needs finite numbers, turns and a radius above zero")
        if np.linalg.norm(self.axis) < 1e-9:
            raise SetupError("the axis of a coil must not be the zero vector")
        if min(self.layers) < 1 or self.length_m < 0.0 or not 0.0 <= self.depth_m < 2.0 * self.radius_m:
            raise SetupError("a winding needs one layer or more, and a depth below its diameter")

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> "Coil":
        """Rebuild from `to_dict` after a trip through JSON; `SetupError` for what is no coil."""
        if unknown := sorted(set(stored) - {field.name for field in fields(cls)}):
            raise SetupError(f"a coil has no {', '.join(unknown)}")
        try:
            values: dict[str, Any] = {name: float(stored[name]) for name in _NUMBERS if name in stored}
            for name in ("centre_m", "axis"):
                if name in stored:
                    x, y, z = stored[name]
                    values[name] = (float(x), float(y), float(z))
            if "layers" in stored:
                along, across = stored["layers"]
                values["layers"] = (int(along), int(across))
        except (TypeError, ValueError) as error:
            raise SetupError(
                "a coil needs numbers, its centre and axis three of them, its layers two"
            ) from error
        return cls(**values)

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON types; `from_dict` reverses it."""
        return {
            name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()
        }

    @property
    def unit_axis(self) -> Float:
        """Axis of unit length in the source frame."""
        axis = np.asarray(self.axis, dtype=np.float64)
        return np.asarray(axis / np.linalg.norm(axis))

    @property
    def moment_m2(self) -> float:
        """Magnetic moment for one ampere, in A m^2 per A."""
        return math.pi * self.radius_m**2 * self.turns

    def loops(self, number: int, model: FieldModel = "exact") -> Float:
        """Return the thin loops of this coil as rows of the kernel."""
        along, across = self.layers
        share = self.turns / (along * across)
        middles = (np.arange(along) + 0.5) / along - 0.5
        depths = (np.arange(across) + 0.5) / across - 0.5
        rows = [
            (
                float(number),
                0.0 if model == "exact" else 1.0,
                share,
                self.radius_m + depth * self.depth_m,
                *(np.asarray(self.centre_m) + middle * self.length_m * self.unit_axis),
                *self.unit_axis,
            )
            for middle in middles
            for depth in depths
        ]
        return np.array(rows, dtype=np.float64)


@dataclass(frozen=True)
class Source:
    """Coils that are worn together on one segment.

    Attributes
    ----------
    coils : tuple of Coil
        In the order of their numbers, from 0.
    model : {"exact", "dipole"}
        How the field is predicted.
    current_limit_a : float
        What the driver can give.
    """

    coils: tuple[Coil, ...]
    model: FieldModel = "exact"
    current_limit_a: float = 1.5

    def __post_init__(self) -> None:
        if not self.coils:
            raise SetupError("a source needs at least one coil")
        if not self.current_limit_a > 0.0:
            raise SetupError("current_limit_a must be above zero")

    @property
    def loops(self) -> Float:
        """All loops for the kernels, C-contiguous, shape (L, 10)."""
        return np.ascontiguousarray(
            np.concatenate([coil.loops(number, self.model) for number, coil in enumerate(self.coils)])
        )

    def with_model(self, model: FieldModel) -> "Source":
        """Return the same coils with the field predicted otherwise."""
        return replace(self, model=model)

    def field(self, coil: ArrayLike, current_a: ArrayLike, position_m: ArrayLike) -> Float:
        """Return the field in the source frame (T), shape (..., 3); arguments as for `field_and_gradient`."""
        return self.field_and_gradient(coil, current_a, position_m)[0]

    def field_and_gradient(
        self, coil: ArrayLike, current_a: ArrayLike, position_m: ArrayLike
    ) -> tuple[Float, Float]:
        """Return field and gradient at points of the source frame.

        Parameters
        ----------
        coil : array_like of int, shape (...)
            Number of the coil that is on.
        current_a : array_like, shape (...)
        position_m : array_like, shape (..., 3)

        Returns
        -------
        field_t : ndarray, shape (..., 3)
        gradient_t_per_m : ndarray, shape (..., 3, 3)
            Derivative with respect to the position; symmetric and free of trace.

        Raises
        ------
        ShapeError
            If the positions are not triples or a coil does not exist.
        """
        position = np.asarray(position_m, dtype=np.float64)
        if position.shape[-1:] != (3,):
            raise ShapeError(f"positions need three components, not shape {position.shape}")
        numbers = np.asarray(coil)
        if numbers.size and not (
            np.issubdtype(numbers.dtype, np.integer)
            and numbers.min() >= 0
            and numbers.max() < len(self.coils)
        ):
            raise ShapeError(f"coils are numbered 0 to {len(self.coils) - 1}")
        shape = np.broadcast_shapes(position.shape[:-1], numbers.shape, np.shape(current_a))
        flat = np.array(np.broadcast_to(position, (*shape, 3)), order="C").reshape(-1, 3)
        chosen = np.array(np.broadcast_to(numbers, shape), dtype=np.int64).reshape(-1)
        currents = np.array(np.broadcast_to(current_a, shape), dtype=np.float64).reshape(-1)
        field, gradient = np.empty((len(flat), 3)), np.empty((len(flat), 3, 3))
        kernel.coil_fields(self.loops, chosen, currents, flat, field, gradient)
        return field.reshape(*shape, 3), gradient.reshape(*shape, 3, 3)


def perpendicular_source(
    offset_m: float = 0.0,
    turns: float = 50.0,
    radius_m: float = 0.055,
    current_limit_a: float = 1.5,
    model: FieldModel = "exact",
    *,
    length_m: float = 0.0,
    depth_m: float = 0.0,
    layers: tuple[int, int] = (1, 1),
) -> Source:
    """Return three coils along the axes of the source, their centres `offset_m` out along their own axis.

    With no offset the coils are concentric, and a point and its mirror image through the origin are the same to them
    (method page E16): a mounting prior is needed then. `length_m`, `depth_m` and `layers` are those of `Coil`.
    """
    axes = np.eye(3)
    coils = tuple(
        Coil(
            turns,
            radius_m,
            tuple((offset_m * axes[i]).tolist()),
            tuple(axes[i].tolist()),
            length_m,
            depth_m,
            layers,
        )
        for i in range(3)
    )
    return Source(coils, model, current_limit_a)


def dipole_gradient(moment_am2: ArrayLike, offset_m: ArrayLike) -> Float:
    """Return the gradient (T/m) of the field of dipoles, shape (..., 3, 3); derivation of Schepers eq. 10, E1."""
    moment, offset = np.asarray(moment_am2, dtype=np.float64), np.asarray(offset_m, dtype=np.float64)
    r = np.linalg.norm(offset, axis=-1)[..., None, None]
    u = offset[..., :, None] / r
    m = moment[..., :, None]
    along = np.sum(u * m, axis=-2, keepdims=True)
    um = u @ np.swapaxes(m, -1, -2)
    uu = u @ np.swapaxes(u, -1, -2)
    strength = 3.0 * MU0_TM_PER_A / (4.0 * math.pi * r**4)
    return np.asarray(strength * (um + np.swapaxes(um, -1, -2) + along * (np.eye(3) - 5.0 * uu)))


def dipole_field(moment_am2: ArrayLike, offset_m: ArrayLike) -> Float:
    """Return the field (T) of dipoles with moments (A m^2), shape (..., 3), at offsets from them."""
    moment, offset = np.asarray(moment_am2, dtype=np.float64), np.asarray(offset_m, dtype=np.float64)
    r = np.linalg.norm(offset, axis=-1, keepdims=True)
    u = offset / r
    along = np.sum(u * moment, axis=-1, keepdims=True)
    return np.asarray(MU0_TM_PER_A / (4.0 * math.pi * r**3) * (3.0 * along * u - moment))


def biot_savart(coil: Coil, current_a: float, position_m: ArrayLike, segments: int = 600) -> Float:
    """Return the field of a thin coil by a sum over segments of the wire: slow, independent, for checks.

    The trapezoidal sum over a full circle converges geometrically off the wire.
    """
    position = np.asarray(position_m, dtype=np.float64)
    axis = coil.unit_axis
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    angle = np.arange(segments) * (2.0 * math.pi / segments)
    points = np.asarray(coil.centre_m) + coil.radius_m * (
        np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    )
    wire = (
        coil.radius_m
        * (2.0 * math.pi / segments)
        * (np.cos(angle)[:, None] * second - np.sin(angle)[:, None] * first)
    )
    offset = position[..., None, :] - points
    r = np.linalg.norm(offset, axis=-1, keepdims=True)
    strength = MU0_TM_PER_A * coil.turns * current_a / (4.0 * math.pi)
    return np.asarray(strength * np.sum(np.cross(wire, offset) / r**3, axis=-2))
