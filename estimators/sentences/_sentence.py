"""A message that knows how it was made."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any


class Sentence(str):
    """The English words of a message, with the code and the parameters they were made of.

    Parameters
    ----------
    code : str
        Stable name in the catalogue.
    parameters : mapping of str to object
        Numbers in SI units, strings, sentences, or lists of them.

    Notes
    -----
    Cutting or joining makes a plain `str`: give sentences to other sentences as parameters instead.
    """

    code: str
    parameters: Mapping[str, Any]

    def __new__(cls, text: str, code: str, parameters: Mapping[str, Any]) -> "Sentence":
        """Return the text, with what it was made of."""
        sentence = super().__new__(cls, text)
        sentence.code, sentence.parameters = code, MappingProxyType(dict(parameters))
        return sentence

    def __getnewargs__(self) -> tuple[str, str, dict[str, Any]]:  # type: ignore[override]
        """Return what pickle needs, as sentences come back from worker processes."""
        return str(self), self.code, dict(self.parameters)

    def __getstate__(self) -> None:
        """Return nothing: everything is in the arguments."""

    def to_dict(self) -> dict[str, Any]:
        """Return code, parameters and text for JSON; sentences among the parameters likewise."""
        params = {name: for_json(value) for name, value in self.parameters.items()}
        return {"code": self.code, "params": params, "text": str(self)}


def for_json(value: Any) -> Any:
    """Return a text for JSON: a sentence with what it was made of, everything else as it is."""
    if isinstance(value, Sentence):
        return value.to_dict()
    return [for_json(one) for one in value] if isinstance(value, list | tuple) else value
