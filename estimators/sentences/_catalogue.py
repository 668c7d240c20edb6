"""Words by code, and the sentences made of them."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from estimators.sentences._formats import joined, written
from estimators.sentences._message import Message, Place, Plural, parsed
from estimators.sentences._sentence import Sentence


class Catalogue:
    """The words of one language.

    Parameters
    ----------
    entries : mapping of str to str
        Messages of `messages` by code. Places of the kinds `number` and `list` are written by `written`. The style of
        the kind `code` is the first part of a code: `{where, code, place}` with the value `pelvis` is the entry
        `place.pelvis`, a list of values `a, b and c` of them (`{where, code, place or}`: `a, b or c`); a value without
        an entry is written as it is.
    """

    def __init__(self, entries: Mapping[str, str]) -> None:
        self.entries = entries

    def say(self, code: str, /, **parameters: Any) -> Sentence:
        """Return a sentence.

        Parameters
        ----------
        code : str
            Of the catalogue, written out where it is used: a test compares code and parameters with the entry.
        **parameters
            Numbers in SI units, strings, sentences, or lists of them.

        Raises
        ------
        KeyError
            No such entry, or a parameter is missing.
        """
        values = {name: _plain(value) for name, value in parameters.items()}
        text = self._text(parsed(self.entries[code]), values)
        return Sentence(text[:1].upper() + text[1:], code, values)

    def together(self, texts: Sequence[str]) -> str:
        """Return several sentences, one after another, as one; empty for none."""
        lines = [text for text in texts if text]
        return self.say("text.lines", lines=lines) if len(lines) > 1 else next(iter(lines), "")

    def restored(self, stored: Any) -> Any:
        """Return a text that went through JSON: a sentence again, with today's words, where it was one.

        Parameters
        ----------
        stored : mapping or str
            Of `for_json`. The words of its time are used where its code is no longer known.
        """
        if isinstance(stored, list):
            return [self.restored(one) for one in stored]
        if not isinstance(stored, Mapping):
            return stored
        try:
            return self.say(stored["code"], **{k: self.restored(v) for k, v in stored["params"].items()})
        except (KeyError, TypeError, ValueError):
            return str(stored["text"])

    def name(self, kind: str, value: Any) -> str:
        """Return a name as it stands within a sentence: `shoulder` of the kind `joint`; as it is where it has none."""
        entry = self.entries.get(f"{kind}.{value}")
        return str(value) if entry is None else self._text(parsed(entry), {})

    def _text(self, message: Message, values: Mapping[str, Any]) -> str:
        return "".join(one if isinstance(one, str) else self._written(one, values) for one in message)

    def _written(self, part: Place | Plural, values: Mapping[str, Any]) -> str:
        value = values[part.name]
        if isinstance(part, Plural):
            chosen = "one" if value == 1 and "one" in part.branches else "other"
            return self._text(part.branches[chosen], values)
        if part.kind != "code":
            return written(value, part.kind, part.style)
        kind, _, last = part.style.partition(" ")
        names = [self.name(kind, one) for one in (value if isinstance(value, list) else [value])]
        return joined(names, last or "and")


def _plain(value: Any) -> Any:
    """Return a value that JSON can hold: numbers of arrays become Python's, what is no number becomes text.

    JSON has no infinity: it would come to the client as null and be read there as zero.
    """
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    plain = value.item() if hasattr(value, "item") else value
    return json.dumps(plain) if isinstance(plain, float) and not math.isfinite(plain) else plain
