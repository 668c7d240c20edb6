"""The body of an upload: received to disk piece by piece, stopped at its limit."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

MIB = 1 << 20


def multipart(declaration: dict[str, Any], size_mib: int, *, close: bool = True) -> Iterator[bytes]:
    yield b'--xyz\r\nContent-Disposition: form-data; name="declaration"\r\n\r\n'
    yield json.dumps(declaration).encode()
    yield b'\r\n--xyz\r\nContent-Disposition: form-data; name="file"; filename="a"\r\n\r\n'
    for _ in range(size_mib):
        yield bytes(MIB)
    if close:
        yield b"\r\n--xyz--\r\n"


async def receive(
    tmp_path: Path, pieces: Iterator[bytes], limit_bytes: int
) -> tuple[Path, list[bytes], BaseException | None]:
    from app.errors import TelemotionError
    from app.ingest._multipart import UploadReceiver

    seen: list[bytes] = []

    async def on_declaration(text: bytes) -> None:
        seen.append(text)

    async def body() -> Any:
        for piece in pieces:
            yield piece

    target = tmp_path / "target.part"
    receiver = UploadReceiver("multipart/form-data; boundary=xyz", target, limit_bytes, on_declaration)
    try:
        await receiver.receive(body())
    except TelemotionError as error:
        return target, seen, error
    return target, seen, None


@pytest.mark.anyio
async def test_an_unannounced_upload_is_stopped_at_the_limit(tmp_path: Path) -> None:
    given = 0

    def counted() -> Iterator[bytes]:
        nonlocal given
        for piece in multipart({"a": 1}, 2048):
            given += len(piece)
            yield piece

    target, seen, error = await receive(tmp_path, counted(), 3 * MIB)
    assert error is not None
    assert error.status == 413
    assert len(seen) == 1
    # Read no further than the piece that went over, and never wrote more than the limit.
    assert given < 5 * MIB
    assert target.stat().st_size <= 3 * MIB


@pytest.mark.anyio
async def test_a_body_that_breaks_off_is_an_error(tmp_path: Path) -> None:
    _, _, error = await receive(tmp_path, multipart({"a": 1}, 1, close=False), 3 * MIB)
    assert "broke off" in str(error)


@pytest.mark.anyio
async def test_a_file_arrives_unchanged_whatever_the_pieces(tmp_path: Path) -> None:
    content = np.random.default_rng(1).bytes(300_000) + b"\r\n--xy" + b"\r\n--xyzz"
    whole = b"".join(multipart({"a": 1}, 0)).replace(
        b"\r\n\r\n\r\n--xyz--", b"\r\n\r\n" + content + b"\r\n--xyz--"
    )
    rng = np.random.default_rng(2)

    def pieces() -> Iterator[bytes]:
        at = 0
        while at < len(whole):
            size = int(rng.integers(1, 5000))
            yield whole[at : at + size]
            at += size

    target, seen, error = await receive(tmp_path, pieces(), MIB)
    assert error is None
    assert json.loads(seen[0]) == {"a": 1}
    assert target.read_bytes() == content
