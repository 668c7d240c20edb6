"""Off-line smoothers: their registry, beside that of the filters they go with."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from estimators.errors import SetupError
from estimators.orientation._device_constants import DeviceConstants
from estimators.orientation._smoother import SmoothedOrientation, SmootherParameters
from estimators.orientation._smoother import smooth as smooth_telemotion
from estimators.recording import ImuChunk


@dataclass(frozen=True)
class Smoother:
    """A way to estimate orientation from a whole session.

    Attributes
    ----------
    name, version, title, description : str
        As for the estimators: key, changes with the numbers, for people, one sentence a therapist understands.
    follows : str
        The filter that gives the live result of the same method.
    parameters : dict
        Every parameter with its default, ready for JSON.
    run : callable
        Takes chunk, parameters and constants of the devices (or None for either).
    """

    name: str
    version: str
    title: str
    description: str
    follows: str
    parameters: dict[str, Any]
    run: Callable[
        [ImuChunk, Mapping[str, Any] | None, Sequence[DeviceConstants | None] | None], SmoothedOrientation
    ]


_REGISTRY = {
    smoother.name: smoother
    for smoother in (
        Smoother(
            name="telemotion_smoother",
            version="1",
            title="Telemotion, off-line",
            description="Uses the whole session, forward and backward, once it is recorded; the most accurate.",
            follows="telemotion",
            parameters=asdict(SmootherParameters()),
            run=smooth_telemotion,
        ),
    )
}


def smoothers() -> dict[str, Smoother]:
    """Return the off-line smoothers by name."""
    return dict(_REGISTRY)


def smooth(
    name: str,
    chunk: ImuChunk,
    parameters: Mapping[str, Any] | None = None,
    constants: Sequence[DeviceConstants | None] | None = None,
) -> SmoothedOrientation:
    """Estimate orientation from a whole session.

    Parameters
    ----------
    name : str
        A key of `smoothers()`.
    chunk : ImuChunk
        All ticks of the session.
    parameters : mapping, optional
        What differs from the defaults.
    constants : sequence of DeviceConstants or None, optional
        What is known of the devices, one a sensor.

    Returns
    -------
    SmoothedOrientation
        Orientation, and the constants as they are now known.

    Raises
    ------
    SetupError
        For an unknown name or parameter.
    ShapeError
        For a chunk without ticks, or arrays that do not fit together.
    """
    if name not in _REGISTRY:
        raise SetupError(f"no smoother {name!r}; known are {', '.join(_REGISTRY)}")
    return _REGISTRY[name].run(chunk, parameters, constants)


__all__ = ["Smoother", "smooth", "smoothers"]
