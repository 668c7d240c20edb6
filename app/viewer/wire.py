"""Messages between viser and its page, as far as the relay must understand them.

Towards the browser a binary message is two u64 (sizes of the packed and the compressed part), zstd-compressed
msgpack of a batch, then arrays. Towards the server it is one msgpack map with a `type`. Only the camera's
pose may pass that way; it is rebuilt from checked numbers, so nothing else can ride along.
"""

import math
import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import msgspec
import viser
import zstandard

PROTOCOL: Final = f"viser-v{viser.__version__}"
"""Subprotocol that page and server must agree on."""

LARGEST_FROM_BROWSER: Final = 4096
_LARGEST_BATCH: Final = 64 * 2**20
_FARTHEST_M: Final = 1e4


class _CameraMessage(msgspec.Struct, tag="ViewerCameraMessage", tag_field="type", forbid_unknown_fields=True):
    wxyz: tuple[float, float, float, float]
    position: tuple[float, float, float]
    fov: float
    near: float
    far: float
    image_height: int
    image_width: int
    look_at: tuple[float, float, float]
    up_direction: tuple[float, float, float]


ALLOWED_FROM_BROWSER: Final = frozenset({_CameraMessage.__struct_config__.tag})
"""The scene defines no controls of its own, so there are no others."""


@dataclass(frozen=True)
class Admitted:
    """A message from the browser that may go on.

    Attributes
    ----------
    data : bytes
        What to send to viser: not what came, but the same content packed again.
    position_m, look_at_m : tuple of float
        Of the camera, in the room.
    aspect : float
        Width over height of the picture.
    """

    data: bytes
    position_m: tuple[float, float, float]
    look_at_m: tuple[float, float, float]
    aspect: float


_decoder = msgspec.msgpack.Decoder(_CameraMessage)


def admit(data: bytes) -> Admitted | None:
    """Check a message from the browser.

    Returns
    -------
    Admitted or None
        None for everything that is not a sound camera pose: requests for a public address, uploads, scene or
        GUI changes, rendered pictures, damaged or oversized data.
    """
    if len(data) > LARGEST_FROM_BROWSER:
        return None
    try:
        camera = _decoder.decode(data)
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError):
        return None
    numbers = (
        *camera.wxyz,
        *camera.position,
        *camera.look_at,
        *camera.up_direction,
        camera.fov,
        camera.near,
    )
    if not all(math.isfinite(value) and abs(value) < _FARTHEST_M for value in numbers):
        return None
    if not math.isfinite(camera.far) or not (
        0 < camera.image_height < 2**16 and 0 < camera.image_width < 2**16
    ):
        return None
    return Admitted(
        data=msgspec.msgpack.encode(camera),
        position_m=camera.position,
        look_at_m=camera.look_at,
        aspect=camera.image_width / camera.image_height,
    )


def pack(messages: Sequence[Any]) -> bytes:
    """Pack messages for one browser only, as viser would.

    Parameters
    ----------
    messages : sequence of viser messages
        Without arrays.
    """
    packed = msgspec.msgpack.encode(
        {
            "messages": tuple(message.as_serializable_dict() for message in messages),
            "timestampSec": time.perf_counter(),
            "binaryBufferLengths": (),
        }
    )
    compressed = zstandard.ZstdCompressor(level=1).compress(packed)
    return struct.pack("<QQ", len(packed), len(compressed)) + compressed


def types_in(batch: bytes) -> list[str]:
    """Return the types of the messages in a batch to the browser, in order; empty when it cannot be read."""
    try:
        size, compressed = struct.unpack_from("<QQ", batch)
        if size > _LARGEST_BATCH:
            return []
        packed = zstandard.ZstdDecompressor().decompress(batch[16 : 16 + compressed], max_output_size=size)
        return [message["type"] for message in msgspec.msgpack.decode(packed)["messages"]]
    except (struct.error, zstandard.ZstdError, msgspec.DecodeError, UnicodeDecodeError, KeyError, TypeError):
        return []
