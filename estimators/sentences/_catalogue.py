"""Words by code, and the sentences made of them."""

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from estimators.sentences._formats import LISTS, is_of_codes, joined, written
from estimators.sentences._sentence import Sentence

Entry = str | Mapping[str, str]
"""Words with places, or `one` and `other` of them by the parameter `count`."""

_PLACE: Final = re.compile(r"\{(\w+)(?::([^}]*))?\}")


class Catalogue:
    """The words of one language.

    Parameters
    ----------
    entries : mapping of str to Entry
        A place is `{name}` or `{name:format}`. A format is one of `written`, or the first part of a code:
        `{where:place}` with the value `pelvis` is the entry `place.pelvis`, a list of values `a, b and c` of them
        (`{where:place|or}`: `a, b or c`); a value without an entry is written as it is.
    """

    def __init__(self, entries: Mapping[str, Entry]) -> None:
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
        entry = self.entries[code]
        words = entry if isinstance(entry, str) else entry["one" if values["count"] == 1 else "other"]
        text = _PLACE.sub(lambda place: self._written(values[place[1]], place[2] or ""), words)
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

    def _written(self, value: Any, form: str) -> str:
        if not is_of_codes(form):
            return written(value, form)
        kind, _, last = form.partition("|")
        names = [self._named(kind, one) for one in (value if isinstance(value, list) else [value])]
        return joined(names, LISTS[last or "and"])

    def _named(self, kind: str, value: Any) -> str:
        entry = self.entries.get(f"{kind}.{value}")
        return entry if isinstance(entry, str) else str(value)


def places(entry: Entry) -> Iterator[tuple[str, str]]:
    """Yield name and format of every place of an entry."""
    for words in [entry] if isinstance(entry, str) else entry.values():
        for found in _PLACE.finditer(words):
            yield found[1], found[2] or ""


def _plain(value: Any) -> Any:
    """Return a value that JSON can hold: numbers of arrays become Python's, what is no number becomes text.

    JSON has no infinity: it would come to the client as null and be read there as zero.
    """
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    plain = value.item() if hasattr(value, "item") else value
    return json.dumps(plain) if isinstance(plain, float) and not math.isfinite(plain) else plain
