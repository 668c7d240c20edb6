"""What may pass from the browser to viser: a sound camera pose, rebuilt; nothing else of all viser's messages."""

import math

import msgspec
import numpy as np
import pytest
import viser
from hypothesis import given
from hypothesis import strategies as st
from viser import _messages as viser_messages

from app.viewer import wire

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [3.0, 0.5, 1.4],
    "fov": 0.56,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 600,
    "image_width": 900,
    "look_at": [0.0, 0.0, 1.0],
    "up_direction": [0.0, 0.0, 1.0],
}


def packed(**changes: object) -> bytes:
    return msgspec.msgpack.encode({**CAMERA, **changes})


def test_a_camera_pose_passes_and_viser_understands_it() -> None:
    admitted = wire.admit(packed())
    assert admitted is not None
    assert admitted.aspect == pytest.approx(1.5)
    understood = viser_messages.Message.deserialize(admitted.data)
    assert isinstance(understood, viser_messages.ViewerCameraMessage)
    assert understood.position == (3.0, 0.5, 1.4)


def test_whole_numbers_from_javascript_pass() -> None:
    assert wire.admit(packed(position=[3, 0, 1], far=1000)) is not None


@pytest.mark.parametrize(
    "message_type",
    sorted({kind.__name__ for kind in viser_messages.Message.get_subclasses()} - wire.ALLOWED_FROM_BROWSER),
)
def test_every_other_message_of_viser_is_dropped(message_type: str) -> None:
    """Also when it carries the fields of an allowed one: the share request, uploads, scripts, GUI, scene."""
    assert wire.admit(msgspec.msgpack.encode({"type": message_type})) is None
    assert wire.admit(packed(type=message_type)) is None


def test_the_share_request_is_among_them() -> None:
    """Guards the list above: the message that opens a public tunnel exists under this name."""
    assert "ShareUrlRequest" in {kind.__name__ for kind in viser_messages.Message.get_subclasses()}


@pytest.mark.parametrize(
    "changes",
    [
        {"position": [math.nan, 0.0, 0.0]},
        {"look_at": [math.inf, 0.0, 0.0]},
        {"position": [0.0, 0.0]},
        {"wxyz": "abcd"},
        {"fov": None},
        {"image_height": 0},
        {"image_width": -5},
        {"extra": 1},
        {"type": None},
    ],
)
def test_unsound_poses_are_dropped(changes: dict[str, object]) -> None:
    assert wire.admit(packed(**changes)) is None


def test_too_long_a_message_is_dropped() -> None:
    assert wire.admit(packed(extra="x" * wire.LARGEST_FROM_BROWSER)) is None


@given(st.binary(max_size=300))
def test_noise_is_dropped(data: bytes) -> None:
    assert wire.admit(data) is None


def test_what_we_pack_reads_as_visers_own_batch() -> None:
    batch = wire.pack([viser_messages.SetCameraPositionMessage((1.0, 2.0, 3.0))])
    assert wire.types_in(batch) == ["SetCameraPositionMessage"]


@given(st.binary(max_size=300))
def test_a_damaged_batch_has_no_types(data: bytes) -> None:
    assert wire.types_in(data) == []


def test_the_stage_refuses_a_public_address_and_listens_on_loopback_only() -> None:
    """The defence behind the relay: even a message that got through opens no tunnel."""
    from app.viewer.stage import LoopbackServer

    server = LoopbackServer()
    try:
        assert server.get_host() == "127.0.0.1"
        assert server.request_share_url() is None
        assert server._share_tunnel is None
        assert viser.ViserServer.request_share_url is not LoopbackServer.request_share_url
    finally:
        server.stop()


def test_frames_of_numpy_survive_as_plain_numbers() -> None:
    """Rotations are sent as plain tuples: numpy scalars would make viser's thread fail."""
    message = viser_messages.SetOrientationMessage("/a", tuple(np.array([1, 0, 0, 0], np.float32).tolist()))
    assert wire.types_in(wire.pack([message])) == ["SetOrientationMessage"]
