"""Receiving `multipart/form-data`: one JSON part and one file, straight to disk, never beyond a limit."""

from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any, BinaryIO, Final

from anyio import to_thread
from fastapi import Request
from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header

from app.errors import InvalidInput, TooLarge
from app.recordings.files_in_passing import open_private
from estimators.sentences import say

MAX_FIELD_BYTES: Final = 256 * 1024
_WRITE_BYTES: Final = 1 << 20


def described(declaration: str) -> dict[str, Any]:
    """Return how OpenAPI says what an `UploadReceiver` takes.

    Parameters
    ----------
    declaration : str
        Name of the declaration's schema.
    """
    said = f"{declaration} as JSON; must come before the file."
    parts = {
        "declaration": {"type": "string", "contentMediaType": "application/json", "description": said},
        "file": {"type": "string", "format": "binary"},
    }
    schema = {"type": "object", "required": list(parts), "properties": parts}
    return {"requestBody": {"required": True, "content": {"multipart/form-data": {"schema": schema}}}}


class UploadReceiver:
    """Takes the body of one request.

    The part `declaration` must come before the part `file`, so that the right to the patient is checked
    before anything is stored.

    Parameters
    ----------
    content_type : str
        Header of the request.
    target : Path
        The file is written here; the caller removes it when receiving fails.
    limit_bytes : int
        Largest file.
    on_declaration : async callable(bytes)
        Called once, before the first byte of the file is written; raises to refuse.
    on_growth : callable(int)
        Called in a thread before more of the file is written, with its size in bytes by then; raises to refuse.
    """

    def __init__(
        self,
        content_type: str,
        target: Path,
        limit_bytes: int,
        on_declaration: Callable[[bytes], Awaitable[None]],
        on_growth: Callable[[int], None] = lambda _: None,
    ) -> None:
        kind, options = parse_options_header(content_type)
        boundary = options.get(b"boundary")
        if kind != b"multipart/form-data" or not boundary:
            raise InvalidInput(say("upload.multipart"))
        self._target = target
        self._limit_bytes = limit_bytes
        self._on_declaration = on_declaration
        self._on_growth = on_growth
        self._parser = MultipartParser(
            boundary,
            {
                "on_part_begin": self._part_begins,
                "on_header_field": self._header_field,
                "on_header_value": self._header_value,
                "on_header_end": self._header_ends,
                "on_headers_finished": self._headers_end,
                "on_part_data": self._data,
                "on_part_end": self._part_ends,
                "on_end": self._all_ends,
            },
        )
        self._header_name = b""
        self._header_text = b""
        self._part = ""
        self._declaration = b""
        self._pending = bytearray()
        self._seen: list[str] = []
        self._is_complete = False
        self.file_bytes = 0

    async def receive(self, body: AsyncIterator[bytes]) -> None:
        """Read the whole body.

        Raises
        ------
        TooLarge
            The file exceeds the limit; stop reading.
        InvalidInput
            The body is malformed, a part is missing or in the wrong order.
        """
        is_declared = False
        file: BinaryIO | None = None
        try:
            async for piece in body:
                try:
                    self._parser.write(piece)
                except FormParserError as error:
                    raise InvalidInput(say("upload.malformed")) from error
                if not is_declared and ("file" in self._seen or self._is_complete):
                    if not self._declaration:
                        raise InvalidInput(say("upload.declaration_first"))
                    await self._on_declaration(self._declaration)
                    is_declared = True
                    file = await to_thread.run_sync(open_private, self._target)
                if file is not None and len(self._pending) >= _WRITE_BYTES:
                    await self._flush(file)
            if not self._is_complete:
                raise InvalidInput(say("upload.broken_off"))
            if file is None or "file" not in self._seen:
                raise InvalidInput(say("upload.no_file"))
            await self._flush(file)
        finally:
            if file is not None:
                file.close()

    async def _flush(self, file: BinaryIO) -> None:
        data, self._pending = bytes(self._pending), bytearray()
        await to_thread.run_sync(self._on_growth, self.file_bytes)
        await to_thread.run_sync(file.write, data)

    def _part_begins(self) -> None:
        self._part = ""
        self._header_name = self._header_text = b""

    def _header_field(self, data: bytes, start: int, end: int) -> None:
        self._header_name += data[start:end]

    def _header_value(self, data: bytes, start: int, end: int) -> None:
        self._header_text += data[start:end]
        if len(self._header_text) > MAX_FIELD_BYTES:
            raise InvalidInput(say("upload.header_too_long"))

    def _header_ends(self) -> None:
        if self._header_name.lower() == b"content-disposition":
            _, options = parse_options_header(self._header_text)
            self._part = options.get(b"name", b"").decode("utf-8", "replace")
        self._header_name = self._header_text = b""

    def _headers_end(self) -> None:
        if self._part not in {"declaration", "file"} or self._part in self._seen:
            raise InvalidInput(say("upload.parts"))
        if self._part == "file" and "declaration" not in self._seen:
            raise InvalidInput(say("upload.declaration_first"))
        self._seen.append(self._part)

    def _data(self, data: bytes, start: int, end: int) -> None:
        if self._part == "declaration":
            self._declaration += data[start:end]
            if len(self._declaration) > MAX_FIELD_BYTES:
                raise InvalidInput(say("upload.declaration_too_long"))
            return
        self.file_bytes += end - start
        if self.file_bytes > self._limit_bytes:
            raise too_large(self._limit_bytes)
        self._pending += data[start:end]

    def _part_ends(self) -> None:
        self._part = ""

    def _all_ends(self) -> None:
        self._is_complete = True


def announced_bytes(request: Request) -> int:
    """Return the length that a request announces for its body; 0 where it announces none."""
    length = request.headers.get("content-length", "")
    return int(length) if length.isdigit() else 0


def too_large(limit_bytes: int) -> TooLarge:
    """Return the error for a file above the limit."""
    return TooLarge(
        say("upload.too_large", limit_bytes=limit_bytes),
        limit_bytes=limit_bytes,
    )
