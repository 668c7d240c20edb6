"""Parser of messages: the part of ICU MessageFormat that `messages` uses.

The client has the same (`web/src/i18n/message.ts`); both are held to `tests/data/sentence_formats.json`.
"""

import functools
import re
from collections.abc import Iterator
from typing import Final, NamedTuple, TypeAlias


class Place(NamedTuple):
    """Where a parameter is put in: `{name}` or `{name, kind, style}`.

    Attributes
    ----------
    kind : str
        `number`, `list` or `code`; empty for a value that is written as it is.
    style : str
        How it is written, see `written` and `Catalogue`.
    """

    name: str
    kind: str
    style: str


class Plural(NamedTuple):
    """Words by a number: `{name, plural, one {...} other {...}}`."""

    name: str
    branches: dict[str, "Message"]


Message: TypeAlias = tuple[str | Place | Plural, ...]

_PART: Final = re.compile(
    r"(?P<text>(?:[^{}']|'')+)"
    r"|\{\s*(?P<name>\w+)\s*(?:,\s*(?P<kind>number|list|code)\s*(?:,\s*(?P<style>[^{}',]+?)\s*)?)?\}"
    r"|\{\s*(?P<plural>\w+)\s*,\s*plural\s*,\s*"
)
_BRANCH: Final = re.compile(r"(\w+)\s*\{")
_END_OF_BRANCH: Final = re.compile(r"\}\s*")


@functools.cache
def parsed(text: str) -> Message:
    """Return the parts of a message.

    Parameters
    ----------
    text : str
        An apostrophe is written twice. Braces in the text, which ICU quotes with apostrophes, are not known.

    Raises
    ------
    ValueError
        It is not such a message.
    """
    message, at = _message(text, 0)
    if at < len(text):
        raise _wrong(text, at)
    return message


def _message(text: str, at: int) -> tuple[Message, int]:
    """Return the parts from a character on, and where they end."""
    parts: list[str | Place | Plural] = []
    while found := _PART.match(text, at):
        at = found.end()
        if found["text"]:
            parts.append(found["text"].replace("''", "'"))
        elif found["plural"]:
            branches, at = _branches(text, at)
            parts.append(Plural(found["plural"], branches))
        else:
            parts.append(Place(found["name"], found["kind"] or "", found["style"] or ""))
    return tuple(parts), at


def _branches(text: str, at: int) -> tuple[dict[str, Message], int]:
    """Return the words of a plural, and where it ends."""
    branches: dict[str, Message] = {}
    while found := _BRANCH.match(text, at):
        branches[found[1]], at = _message(text, found.end())
        end = _END_OF_BRANCH.match(text, at)
        if end is None:
            raise _wrong(text, at)
        at = end.end()
    if "other" not in branches or text[at : at + 1] != "}":
        raise _wrong(text, at)
    return branches, at + 1


def _wrong(text: str, at: int) -> ValueError:
    return ValueError(f"not a message from character {at + 1} on: {text}")


def places(message: Message) -> Iterator[Place]:
    """Yield every place of a message, a plural as one of the kind `plural`."""
    for part in message:
        if isinstance(part, Place):
            yield part
        elif isinstance(part, Plural):
            yield Place(part.name, "plural", "")
            for branch in part.branches.values():
                yield from places(branch)
