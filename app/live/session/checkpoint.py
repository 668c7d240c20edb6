"""Where the estimation of a live session stands, as bytes that another process goes on from, bit for bit.

Whoever reads one knows its layout or leaves it: a row of another layout, another version of the pipeline or another
calibration, or of clock epochs that were never stored, is never guessed at, the session is estimated again from its
packets. What it holds is that of the packets
below `sequence`; those from there on are to be replayed.
"""

import json
import logging
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from functools import cache
from hashlib import blake2b
from typing import Any, Final

import msgspec
import numpy as np
import zstandard
from numpy.typing import NDArray

from app.live.engine.lane import Parts
from app.live.session.runner import LiveSession
from app.network.alignment import Aligner
from app.network.clock import PacketClock
from app.network.declaration import ClockEpoch, Declaration, FoundClips
from app.recordings.signals.checkpoints import Checkpoint
from estimators.pipelines import Pipeline

logger = logging.getLogger(__name__)

LAYOUT: Final = 4
"""Of `State`, and of the arrays of clock, alignment and orientation filters; to be raised with any change of them, and
with the version of a pipeline: by it alone a worker knows what to estimate ahead (`app.scaled.worker.preparing`)."""
_PIPELINE: Final = "pipeline."
_ALIGNER: Final = "aligner."


class _Packed(msgspec.Struct, array_like=True):
    key: bytes
    clock: tuple[int, int, int]
    met: tuple[int, int, bytes]
    """How many clock epochs and found clip levels, and `_digest` of them."""
    arrays: dict[str, tuple[str, tuple[int, ...], bytes]]
    """Type (as in the head of a `.npy` file, which has the fields of records, in JSON), shape and numbers."""


Arrays = Mapping[str, NDArray[Any]]
Met = tuple[tuple[ClockEpoch, ...], tuple[FoundClips, ...]]


@dataclass(frozen=True)
class State:
    """Where a session stands, as arrays of its own.

    Parameters
    ----------
    key : bytes
        See `key_of`.
    met : tuple of ClockEpoch, tuple of FoundClips
        Which the session had met: they are stored with the hello, apart from what is stored here.
    """

    key: bytes
    clock: tuple[int, int, int]
    met: Met
    arrays: Arrays


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
    declared = parts.clock.declaration
    return State(_key(parts), parts.clock.state(), (declared.clock_epochs, declared.found_clips), own)


def _key(parts: Parts) -> bytes:
    """Return `key_of`, made again only when setup or network is another one."""
    pipeline, declaration = parts.pipeline, parts.clock.declaration
    made_of = (pipeline.setup, declaration, pipeline.version)
    if parts.key is None or any(one is not other for one, other in zip(parts.key[0], made_of, strict=True)):
        parts.key = (made_of, key_of(pipeline, declaration))
    return parts.key[1]


def pack(state: State) -> Checkpoint:
    """Return a state as it is stored."""
    arrays = {name: (_text_of(one.dtype), one.shape, one.tobytes()) for name, one in state.arrays.items()}
    epochs, clips = map(len, state.met)
    packed = _Packed(state.key, state.clock, (epochs, clips, _digest(state.met)), arrays)
    data = zstandard.ZstdCompressor(level=1, write_checksum=True).compress(msgspec.msgpack.encode(packed))
    return Checkpoint(LAYOUT, state.clock[0] + 1, data)


def resume(session: LiveSession, checkpoint: Checkpoint | None) -> bool:
    """Let a session that has just been made go on from a checkpoint; False when it must begin with its first packet.

    Parameters
    ----------
    session : LiveSession
        Not yet given to anybody.
    """
    if checkpoint is None or checkpoint.layout != LAYOUT:
        return False
    parts = session.now
    declaration, before = parts.clock.declaration, None
    try:
        packed = _unpack(checkpoint.data)
        epochs, clips, digest = packed.met
        met = declaration.clock_epochs[:epochs], declaration.found_clips[:clips]
        if packed.key != _key(parts) or tuple(map(len, met)) != (epochs, clips) or _digest(met) != digest:
            return False
        before = parts.pipeline.state()
        _restore(parts, packed)
    except Exception as error:
        # Whatever is wrong with it: the packets are there, and other sessions are to be taken up as well.
        logger.warning("the checkpoint of session %s cannot be read: %s", session.id, type(error).__name__)
        if before is not None:
            # One that does not fit after all leaves no trace.
            parts.pipeline.restore(before)
            parts.clock, parts.aligner = PacketClock(declaration), Aligner(declaration)
        return False
    return True


def _unpack(data: bytes) -> _Packed:
    return msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(data), type=_Packed)


def _digest(met: Met) -> bytes:
    text = json.dumps([[astuple(one) for one in some] for some in met])
    return blake2b(text.encode(), digest_size=16).digest()


def _restore(parts: Parts, packed: _Packed) -> None:
    arrays = {
        name: np.frombuffer(numbers, _type_of(text)).reshape(shape).copy()
        for name, (text, shape, numbers) in packed.arrays.items()
    }
    parts.pipeline.restore(_below(arrays, _PIPELINE))
    parts.aligner.restore(_below(arrays, _ALIGNER))
    parts.clock.restore(packed.clock)


@cache
def _text_of(of_array: np.dtype[Any]) -> str:
    return json.dumps(np.lib.format.dtype_to_descr(of_array))


@cache
def _type_of(text: str) -> np.dtype[Any]:
    # Not by Python's parser: it fails now and then where several threads parse at once.
    return np.lib.format.descr_to_dtype(_described(json.loads(text)))


def _described(found: Any) -> Any:
    """Return a description with the tuples that JSON has made lists."""
    if isinstance(found, str):
        return found
    return [(name, _described(of), *map(tuple, shape)) for name, of, *shape in found]


def _below(arrays: Arrays, prefix: str) -> dict[str, NDArray[Any]]:
    return {name.removeprefix(prefix): one for name, one in arrays.items() if name.startswith(prefix)}
