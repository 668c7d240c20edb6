"""The relay and the control socket: access at the door and while open, what passes, and what steers."""

import json
import struct
import time
from collections.abc import Callable
from typing import Any

import anyio
import msgspec
import numpy as np
import pytest
import zstandard
from starlette.websockets import WebSocketDisconnect

from app.accounts.models import SignIn
from app.database.unit_of_work import unit_of_work
from app.live.blocks import PublishedFrames
from app.live.bus import MemoryBus, topic
from app.live.messages import StateMessage
from app.patients.models import Grant
from app.viewer import wire
from app.viewer.service import Viewer
from estimators.pipelines import Frames
from tests.patience import PATIENCE_S

CAMERA = msgspec.msgpack.encode(
    {
        "type": "ViewerCameraMessage",
        "wxyz": [1.0, 0.0, 0.0, 0.0],
        "position": [3.0, 0.0, 1.0],
        "fov": 0.56,
        "near": 0.01,
        "far": 1000.0,
        "image_height": 800,
        "image_width": 400,
        "look_at": [0.0, 0.0, 1.0],
        "up_direction": [0.0, 0.0, 1.0],
    }
)


def messages_in(batch: bytes) -> list[dict[str, Any]]:
    size, compressed = struct.unpack_from("<QQ", batch)
    plain = zstandard.ZstdDecompressor().decompress(batch[16 : 16 + compressed], max_output_size=size)
    found: list[dict[str, Any]] = msgspec.msgpack.decode(plain)["messages"]
    return found


def received(socket) -> dict[str, Any]:
    """Receive one message, but do not wait for ever when it does not come."""

    async def wait() -> dict[str, Any]:
        with anyio.fail_after(30.0):
            return await socket._send_rx.receive()

    return socket.portal.call(wait)


def until(socket, wanted: Callable[[dict[str, Any]], bool], batches: int = 400) -> dict[str, Any]:
    """Read on until a message fits; what came after it in its batch is kept for the next call."""
    waiting: list[dict[str, Any]] = socket.__dict__.setdefault("waiting_messages", [])
    for _ in range(batches):
        while waiting:
            message = waiting.pop(0)
            if wanted(message):
                return message
        waiting.extend(messages_in(received(socket)["bytes"]))
    raise AssertionError("the message did not come")


def of_type(name: str) -> Callable[[dict[str, Any]], bool]:
    return lambda message: message["type"] == name


def raised_arm(message: dict[str, Any]) -> bool:
    """The right upper arm, of the patient or of the ghost, turned by more than 30 degrees."""
    is_patient = message["type"] == "SetOrientationMessage" and message["name"].endswith("/upper_arm_right")
    is_ghost = message["type"] == "SetBoneOrientationMessage" and message["bone_index"] == 0
    return (is_patient or is_ghost) and bool(
        2 * np.degrees(np.arccos(min(abs(message["wxyz"][0]), 1.0))) > 30
    )


def read_until_closed(socket) -> None:
    while True:
        socket._raise_on_close(received(socket))


def page_socket(client, view):
    return client.websocket_connect(f"/viewer/{view['id']}", subprotocols=[wire.PROTOCOL])


def refused(client, path: str, **keywords: Any) -> bool:
    """Whether nothing comes but a refusal: at the handshake, or by one word that closes."""
    try:
        with client.websocket_connect(path, **keywords) as socket:
            message = socket.receive_json()
            assert (message["type"], message["closing"]) == ("error", True)
            socket.receive_json()
    except WebSocketDisconnect:
        return True
    return False


@pytest.mark.parametrize("path", ["/viewer/{id}", "/ws/views/{id}"])
@pytest.mark.parametrize(
    "name", ["colleague", "former", "expired", "other_patient", "reader", "integrator", "foreign_therapist"]
)
def test_strangers_are_refused_at_the_door(name: str, path: str, sign_in, therapist, open_view) -> None:
    view = open_view(therapist)
    assert refused(sign_in(name), path.format(**view), subprotocols=[wire.PROTOCOL])


@pytest.mark.parametrize("path", ["/viewer/{id}", "/ws/views/{id}"])
def test_without_a_cookie_or_from_another_page_nothing_opens(path: str, nobody, therapist, open_view) -> None:
    view = open_view(therapist)
    address = path.format(**view)
    assert refused(nobody, address, subprotocols=[wire.PROTOCOL])
    assert refused(
        therapist, address, subprotocols=[wire.PROTOCOL], headers={"Origin": "https://evil.example"}
    )
    assert refused(therapist, path.format(id="0" * 32), subprotocols=[wire.PROTOCOL])


def test_the_page_gets_the_scene_and_then_its_own_camera(therapist, open_view) -> None:
    with page_socket(therapist, open_view(therapist)) as socket:
        seen: list[str] = []
        until(
            socket,
            lambda m: seen.append(m["type"]) or (m["type"] == "SetCameraLookAtMessage" and not m["initial"]),
        )
        assert "MeshMessage" in seen
        assert "ReplayDoneMessage" in seen
        assert "GridMessage" in seen
        assert "ShareUrlUpdated" not in seen


def test_another_version_of_the_page_is_refused(therapist, open_view) -> None:
    view = open_view(therapist)
    assert refused(therapist, f"/viewer/{view['id']}", subprotocols=["viser-v0.0.1"])
    assert refused(therapist, f"/viewer/{view['id']}")


def test_only_camera_poses_reach_viser(therapist, open_view, services, monkeypatch) -> None:
    """A share request, an upload, a scene change and noise are sent with a camera pose; only the pose arrives."""
    view = open_view(therapist)
    stage = next(iter(services.get(Viewer)._stages.values()))
    arrived: list[str] = []
    handlers = stage._server._websock_server._handle_incoming_message

    async def note(client_id: int, message: Any) -> None:
        arrived.append(type(message).__name__)
        await handlers(client_id, message)

    monkeypatch.setattr(stage._server._websock_server, "_handle_incoming_message", note)
    with page_socket(therapist, view) as socket:
        until(socket, of_type("ReplayDoneMessage"))
        for hostile in (
            {"type": "ShareUrlRequest"},
            {"type": "FileTransferStartUpload", "source_component_uuid": "a", "transfer_uuid": "b"},
            {"type": "SceneNodeUpdateMessage", "name": "/patient", "updates": {"visible": False}},
            {"type": "GuiUpdateMessage", "uuid": "x", "updates": {}},
        ):
            socket.send_bytes(msgspec.msgpack.encode(hostile))
        socket.send_bytes(b"\x00\xff noise")
        socket.send_text("text is not spoken here")
        socket.send_bytes(CAMERA)
        deadline = time.monotonic() + PATIENCE_S
        while not arrived and time.monotonic() < deadline:
            time.sleep(0.01)
    assert set(arrived) == {"ViewerCameraMessage"}
    assert stage._server._share_tunnel is None


def test_a_narrow_picture_makes_the_camera_step_back(therapist, open_view) -> None:
    with page_socket(therapist, open_view(therapist)) as socket:
        first = until(socket, lambda m: m["type"] == "SetCameraPositionMessage" and not m["initial"])
        socket.send_bytes(CAMERA)
        second = until(socket, of_type("SetCameraPositionMessage"))
        assert np.linalg.norm(second["position"]) > 1.2 * np.linalg.norm(first["position"])


@pytest.mark.parametrize("path", ["/viewer/{id}", "/ws/views/{id}"])
@pytest.mark.parametrize("loss", ["grant", "sign_in"])
def test_a_lost_right_closes_an_open_socket(
    path: str, loss: str, therapist, open_view, services, engine, world
) -> None:
    services.get(Viewer).check_right_every_s = 0.1
    view = open_view(therapist)
    with therapist.websocket_connect(path.format(**view), subprotocols=[wire.PROTOCOL]) as socket:
        socket.receive()
        with unit_of_work(engine) as session:
            kind = Grant if loss == "grant" else SignIn
            session.query(kind).filter_by(account_id=world.accounts["therapist"]).delete()
        with pytest.raises(WebSocketDisconnect) as closed:
            read_until_closed(socket)
        assert closed.value.code == (4404 if loss == "grant" else 4401)


def control(client, view):
    return client.websocket_connect(view["control_path"])


def test_a_view_that_is_not_known_any_more_is_said_to_be_so(therapist) -> None:
    """A browser learns nothing of a refused handshake: it would ask its old address for ever."""
    with therapist.websocket_connect(f"/ws/views/{'0' * 32}") as socket:
        message = socket.receive_json()
        assert (message["type"], message["code"], message["closing"]) == ("error", "not_found", True)
        with pytest.raises(WebSocketDisconnect) as closed:
            socket.receive_json()
        assert closed.value.code == 4404


def test_a_view_that_is_not_steered_has_a_pulse(therapist, open_view) -> None:
    with control(therapist, open_view(therapist)) as socket:
        assert socket.receive_json()["type"] == "player_state"
        assert socket.receive_json() == {"type": "pulse"}


def test_a_replay_obeys_time_speed_and_pause(therapist, open_view, recorded) -> None:
    with control(therapist, open_view(therapist)) as socket:
        first = socket.receive_json()
        assert first["type"] == "player_state"
        assert (first["mode"], first["playing"], first["has_ghost"]) == ("replay", False, False)
        assert first["end_s"] == pytest.approx(float(recorded.frames.time_s[-1]), abs=0.03)
        socket.send_json({"type": "player", "time_s": 3.0, "playing": True, "speed": 2.0})
        playing = socket.receive_json()
        assert playing["playing"]
        assert playing["time_s"] == pytest.approx(3.0, abs=0.2)
        socket.send_json({"type": "player", "time_s": 5.5, "playing": False})
        stopped = socket.receive_json()
        assert not stopped["playing"]
        assert stopped["time_s"] == pytest.approx(5.5)
        socket.send_json({"type": "player", "time_s": 1e9, "playing": False})
        assert socket.receive_json()["time_s"] == pytest.approx(first["end_s"])


def test_seeking_moves_the_figure_and_the_ghost(therapist, open_view, recorded) -> None:
    """In the middle of a reach the upper arm is raised; what the page is told says so."""
    view = open_view(therapist, template_version_id=recorded.template_version_id)
    repetition = recorded.compared.repetitions[1].repetition
    with page_socket(therapist, view) as page, control(therapist, view) as steer:
        until(page, of_type("ReplayDoneMessage"))
        assert steer.receive_json()["has_warp"]
        time_s = 0.5 * (repetition.start_s + repetition.end_s)
        steer.send_json({"type": "player", "time_s": time_s, "playing": False})
        until(page, lambda m: raised_arm(m) and m["name"].startswith("/patient"))
        until(page, lambda m: raised_arm(m) and m["name"].startswith("/template"))


def test_the_ghost_can_be_hidden_in_one_view(therapist, open_view, recorded) -> None:
    view = open_view(therapist, template_version_id=recorded.template_version_id)
    with page_socket(therapist, view) as page, control(therapist, view) as steer:
        until(page, lambda m: m["type"] == "SetCameraLookAtMessage" and not m["initial"])
        steer.receive_json()
        steer.send_json({"type": "player", "time_s": 1.0, "playing": False, "ghost": False})
        hidden = until(
            page, lambda m: m["type"] == "SetSceneNodeVisibilityMessage" and m["name"] == "/template"
        )
        assert not hidden["visible"]
    with page_socket(therapist, view) as page:  # and stays so when the page is loaded again
        until(page, of_type("ReplayDoneMessage"))
        again = until(
            page, lambda m: m["type"] == "SetSceneNodeVisibilityMessage" and m["name"] == "/template"
        )
        assert not again["visible"]


def test_keys_turn_the_camera_and_the_theme_follows_the_page(therapist, open_view) -> None:
    view = open_view(therapist)
    with page_socket(therapist, view) as page, control(therapist, view) as steer:
        until(page, lambda m: m["type"] == "SetCameraLookAtMessage" and not m["initial"])
        steer.receive_json()
        steer.send_json({"type": "camera", "preset": "top", "theme": "dark"})
        assert until(page, of_type("SetCameraPositionMessage"))["position"][2] > 3.0
        assert until(page, of_type("ThemeConfigurationMessage"))["dark_mode"]
        steer.send_json({"type": "camera", "preset": "front", "turn_deg": 90})
        turned = until(page, of_type("SetCameraPositionMessage"))["position"]
        assert turned[1] > 2.0


def test_nonsense_on_the_control_socket_is_answered_and_survived(therapist, open_view) -> None:
    with control(therapist, open_view(therapist)) as socket:
        socket.receive_json()
        for nonsense in ("{", json.dumps({"type": "fly"}), json.dumps({"type": "player"}), "x" * 5000):
            socket.send_text(nonsense)
            assert socket.receive_json()["code"] == "invalid_input"
        socket.send_json({"type": "player", "time_s": 1.0, "playing": False})
        assert socket.receive_json()["type"] == "player_state"


def test_a_live_view_shows_the_newest_frames(therapist, open_view, services, nobody, recorded) -> None:
    """Frames on the bus move the figure; other sensors than declared change nothing but the colour."""
    view = open_view(therapist, "live")
    with page_socket(therapist, view) as page:
        until(page, of_type("ReplayDoneMessage"))
        repetition = recorded.compared.repetitions[0].repetition
        tick = int(0.5 * (repetition.start_s + repetition.end_s) / recorded.frames.time_step_s)
        part = slice(tick, tick + 5)
        arrays = (
            "q_room_segment", "point_room_m", "angle_rad", "angle_sigma_rad", "scalar", "segment_flags", "angle_flags",
        )  # fmt: skip
        fields = {**vars(recorded.frames), "first_tick": tick}
        fields |= {name: getattr(recorded.frames, name)[part] for name in arrays}
        frames = PublishedFrames(Frames(**fields), time.time())
        nobody.portal.call(services.get(MemoryBus).publish, topic(recorded.live_session_id, "frames"), frames)
        until(page, raised_arm)
        # When no packet comes any more, what was measured turns grey and one label says so.
        lost = StateMessage(
            state="link_lost", reason="", session_time_s=0.0, recording_start_s=None, calibration=None,
            calibration_progress=None,
        )  # fmt: skip
        nobody.portal.call(services.get(MemoryBus).publish, topic(recorded.live_session_id, "state"), lost)
        said = until(
            page, lambda m: m["type"] == "SetSceneNodeVisibilityMessage" and m["name"].endswith("/silent")
        )
        assert said["visible"]


def test_an_unwatched_scene_is_taken_down_and_comes_back(therapist, open_view, services, nobody) -> None:
    view = open_view(therapist)
    with page_socket(therapist, view) as page:
        until(page, of_type("ReplayDoneMessage"))
        nobody.portal.call(services.get(Viewer)._sweep, 0.0)
        assert services.get(Viewer).stage_count == 1
    deadline = time.monotonic() + PATIENCE_S
    while services.get(Viewer).stage_count and time.monotonic() < deadline:
        nobody.portal.call(services.get(Viewer)._sweep, 0.0)
    assert services.get(Viewer).stage_count == 0
    with page_socket(therapist, view) as page:
        until(page, of_type("ReplayDoneMessage"))
    assert services.get(Viewer).stage_count == 1
