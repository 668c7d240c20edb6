"""Magnetic field that a sensor meets in a room: of the earth, furniture, magnets that pass, and iron on the wearer."""

from typing import Final

import numpy as np

from estimators import rotation
from estimators.recording import Float
from validation.worlds.conditions import Conditions
from validation.worlds.curves import smooth_step

_SIZE_M: Final = 0.1
"""Radius of magnets and of steel: within it the field of a dipole grows no more."""
_PIECES: Final = 4
_ROOM_T: Final = (1e-6, 8e-6)
_START_T: Final = (8e-6, 40e-6)
_PASSING_T: Final = (8e-6, 60e-6)
_WORN_T: Final = (5e-6, 35e-6)
_WHOLE_RAD: Final = (np.radians(3.0), np.radians(15.0))
_CHANGE_S: Final = 0.4


def earth_field(conditions: Conditions) -> Float:
    """Return the earth's field in earth axes, tesla: magnetic north is y."""
    dip = conditions.dip_rad
    return conditions.strength_t * np.array([0.0, np.cos(dip), -np.sin(dip)])


def field_along(
    conditions: Conditions, time_s: Float, place_m: Float, generator: np.random.Generator
) -> tuple[Float, Float]:
    """Return the field along a path, and that of iron that goes with the sensor.

    Parameters
    ----------
    time_s : ndarray, shape (K,)
    place_m : ndarray, shape (K, 3)

    Returns
    -------
    field_earth_t : ndarray, shape (K, 3)
        In earth axes. North is the mean along the path in a room with furniture, and that of the earth otherwise.
    iron_sensor_t : ndarray, shape (K, 3)
        In sensor axes.
    """
    earth = earth_field(conditions)
    field, iron = np.tile(earth, (len(time_s), 1)), np.zeros((len(time_s), 3))
    kind = conditions.field
    if kind == "room":
        field += _furniture(place_m, generator)
    elif kind == "iron at the start":
        field += _beside(place_m, generator)
    elif kind == "magnets passing":
        for _ in range(generator.integers(1, 5)):
            field += _passing(time_s, generator)
    elif kind == "lift or bed":
        field += _elsewhere(time_s, generator)[:, None] * (_other_field(earth, generator) - earth)
    elif kind == "turned all along":
        angle = generator.uniform(*_WHOLE_RAD) * generator.choice([-1.0, 1.0])
        field = rotation.rotate(rotation.about_z(angle), field)
    elif kind in ("iron worn", "iron put on", "iron taken off"):
        iron += _worn(kind, time_s, generator)[:, None] * _any_way(generator, generator.uniform(*_WORN_T))
    return field, iron


def dipole_field(moment: Float, from_magnet_m: Float) -> Float:
    """Return the field of a magnet, shape (N, 3), in units of the moment over the cube of the distance.

    Parameters
    ----------
    moment : ndarray, shape (3,)
    from_magnet_m : ndarray, shape (N, 3)
    """
    distance = np.sqrt((from_magnet_m**2).sum(axis=1, keepdims=True) + _SIZE_M**2)
    way = from_magnet_m / distance
    return np.asarray((3.0 * (way @ moment)[:, None] * way - moment) / distance**3)


def _any_way(generator: np.random.Generator, length: float) -> Float:
    way = generator.normal(size=3)
    return np.asarray(length * way / np.linalg.norm(way))


def _furniture(place_m: Float, generator: np.random.Generator) -> Float:
    """Return what steel around the path adds; the mean along the path belongs to the field of the place."""
    middle = place_m.mean(axis=0)
    reach_m = float(np.linalg.norm(place_m - middle, axis=1).max())
    added = np.zeros_like(place_m)
    for _ in range(_PIECES):
        apart = place_m - middle - _any_way(generator, reach_m + generator.uniform(0.2, 1.0))
        added += dipole_field(_any_way(generator, 1.0), apart)
    added -= added.mean(axis=0)
    spread = float(np.sqrt((added**2).sum(axis=1).mean()))
    return added * (generator.uniform(*_ROOM_T) / spread)


def _beside(place_m: Float, generator: np.random.Generator) -> Float:
    """Return what a piece of iron at the place of the start adds along the path."""
    apart = place_m - place_m[0] - _any_way(generator, generator.uniform(0.2, 0.6))
    added = dipole_field(_any_way(generator, 1.0), apart)
    return added * (generator.uniform(*_START_T) / float(np.linalg.norm(added[0])))


def _passing(time_s: Float, generator: np.random.Generator) -> Float:
    """Return what a magnet adds that goes by on a straight line."""
    middle_s = generator.uniform(time_s[0], time_s[-1])
    nearest_m, lasts_s = generator.uniform(0.15, 0.6), generator.uniform(0.5, 8.0)
    nearest = _any_way(generator, nearest_m)
    aside = np.cross(nearest, _any_way(generator, 1.0))
    speed = aside / np.linalg.norm(aside) * (2.0 * nearest_m / lasts_s)
    added = dipole_field(_any_way(generator, 1.0), nearest + (time_s - middle_s)[:, None] * speed)
    return added * (generator.uniform(*_PASSING_T) / float(np.linalg.norm(added, axis=1).max()))


def _elsewhere(time_s: Float, generator: np.random.Generator) -> Float:
    """Return how far a wearer is in a lift or on a bed, from 0 to 1, for 15 to 50 s."""
    comes_s = generator.uniform(8.0, 0.5 * time_s[-1])
    leaves_s = comes_s + generator.uniform(15.0, 50.0)
    change_s = generator.uniform(0.5, 3.0)
    return smooth_step((time_s - comes_s) / change_s) - smooth_step((time_s - leaves_s) / change_s)


def _other_field(earth: Float, generator: np.random.Generator) -> Float:
    turn = rotation.exp(_any_way(generator, np.radians(generator.uniform(15.0, 90.0))))
    return generator.uniform(0.3, 1.3) * rotation.rotate(turn, earth)


def _worn(kind: str, time_s: Float, generator: np.random.Generator) -> Float:
    """Return whether iron is worn, from 0 to 1."""
    if kind == "iron worn":
        return np.ones(len(time_s))
    change = smooth_step((time_s - generator.uniform(0.25, 0.6) * time_s[-1]) / _CHANGE_S)
    return change if kind == "iron put on" else 1.0 - change
