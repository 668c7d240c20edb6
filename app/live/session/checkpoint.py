"""Where the estimation of a live session stands, as bytes that another process goes on from, bit for bit.

Whoever reads one knows its layout or leaves it: a row of another layout, another version of the pipeline or another
calibration is never guessed at, the session is estimated again from its packets. What it holds is that of the packets
below `sequence`; those from there on are to be replayed.
"""

import json
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import blake2b
from io import BytesIO
from typing import Any, Final

import msgspec
import numpy as np
import zstandard
from numpy.typing import NDArray

from app.live.engine.lane import Parts
from app.live.session.runner import LiveSession
from app.network.declaration import Declaration
from estimators import pipelines
from estimators.pipelines import Pipeline

logger = logging.getLogger(__name__)

LAYOUT: Final = 1
"""Of `State`, and of the arrays of clock, alignment and orientation filters; to be raised with any change of them."""
_PIPELINE: Final = "pipeline."
_ALIGNER: Final = "aligner."


class _Packed(msgspec.Struct, array_like=True):
    key: bytes
    clock: tuple[int, int, int]
    arrays: dict[str, bytes]
    """In the format of `.npy` files, which has the fields of records."""


Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class State:
    """Where a session stands, as arrays of its own.

    Parameters
    ----------
    key : bytes
        See `key_of`.
    clock : tuple of int
    arrays : mapping of str to ndarray
    """

    key: bytes
    clock: tuple[int, int, int]
    arrays: Arrays


@dataclass(frozen=True)
class Checkpoint:
    """What is stored of one.

    Parameters
    ----------
    layout : int
    sequence : int
        First packet that is not in it.
    data : bytes
    """

    layout: int
    sequence: int
    data: bytes


def key_of(pipeline: Pipeline, declaration: Declaration) -> bytes:
    """Return what a checkpoint is of: pipeline and its version, setup with calibration, network."""
    network = {name: value for name, value in declaration.to_dict().items() if name != "clock_epochs"}
    network.pop("found_clips", None)
    parts = [pipeline.name, pipeline.version, pipeline.setup.to_dict(), network]
    return blake2b(json.dumps(parts, sort_keys=True, default=str).encode(), digest_size=16).digest()


def capture(session: LiveSession) -> "State | None":
    """Return where a session stands; None while it cannot be said in a checkpoint, which passes.

    On the event loop; `pack` does the rest in any thread.
    """
    parts = session.parts
    if not parts.aligner.is_in_order or not session.line.is_idle or session.is_calibrating:
        return None
    if parts.aligner.next_sequence != parts.clock.highest + 1:
        return None
    own = {f"{_PIPELINE}{name}": values for name, values in parts.pipeline.state().items()}
    own |= {f"{_ALIGNER}{name}": values for name, values in parts.aligner.state().items()}
    return State(key_of(parts.pipeline, parts.clock.declaration), parts.clock.state(), own)


def pack(state: State) -> Checkpoint:
    """Return a state as it is stored."""
    packed = _Packed(state.key, state.clock, {name: _to_npy(one) for name, one in state.arrays.items()})
    data = zstandard.ZstdCompressor(level=1, write_checksum=True).compress(msgspec.msgpack.encode(packed))
    return Checkpoint(LAYOUT, state.clock[0] + 1, data)


def resume(session: LiveSession, checkpoint: Checkpoint | None) -> bool:
    """Let a session that has just been made go on from a checkpoint; False when it must begin with its first packet.

    Parameters
    ----------
    session : LiveSession
        Not yet given to anybody.
    checkpoint : Checkpoint or None
    """
    if checkpoint is None or checkpoint.layout != LAYOUT:
        return False
    parts = session.now
    declaration = parts.clock.declaration
    try:
        state = _unpack(checkpoint.data)
        if state.key != key_of(parts.pipeline, declaration):
            return False
        # One that does not fit after all must leave no trace.
        _restore(Parts(declaration, pipelines.create(parts.pipeline.setup), 0), state)
    except Exception as error:
        # Whatever is wrong with it: the packets are there, and other sessions are to be taken up as well.
        logger.warning("the checkpoint of session %s cannot be read: %s", session.id, type(error).__name__)
        return False
    _restore(parts, state)
    return True


def _unpack(data: bytes) -> State:
    packed = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(data), type=_Packed)
    return State(packed.key, packed.clock, {name: _from_npy(one) for name, one in packed.arrays.items()})


def _restore(parts: Parts, state: State) -> None:
    parts.pipeline.restore(_below(state.arrays, _PIPELINE))
    parts.aligner.restore(_below(state.arrays, _ALIGNER))
    parts.clock.restore(state.clock)


def _to_npy(values: NDArray[Any]) -> bytes:
    file = BytesIO()
    np.lib.format.write_array(file, values, allow_pickle=False)
    return file.getvalue()


def _from_npy(content: bytes) -> NDArray[Any]:
    found: NDArray[Any] = np.lib.format.read_array(BytesIO(content), allow_pickle=False)
    return found


def _below(arrays: Arrays, prefix: str) -> dict[str, NDArray[Any]]:
    return {name.removeprefix(prefix): one for name, one in arrays.items() if name.startswith(prefix)}


__all__ = ["LAYOUT", "Checkpoint", "State", "capture", "key_of", "pack", "resume"]
